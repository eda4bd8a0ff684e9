"""Constants of an observer in generated code: numbers in the code, or a vector of the state.

Constants are theta, rig, tuning and `EQUIVALENT`, one after another. With parameters at run time C keeps
all of them in its state, whichever of them are numbers in the code none the less.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import casadi as ca

from observers.embedded.scalar_expansion import expand_with_constants
from observers.estimators.model_observer import ModelObserver
from observers.measurement.measurement_model import RIG
from observers.patch.patch_protocol import EQUIVALENT
from observers.tuning import TUNING_FIELDS

Tunable = Literal["", "tuning", "all"]
"""What generated code takes at run time: nothing, the tuning, or model, rig and tuning."""


@dataclass(frozen=True)
class ConstantSubstitution:
    """Puts constants into Functions of scalars."""

    observer: ModelObserver  # Whose constants they are.
    tunable: Tunable = ""  # Which of them C reads at run time.
    # Places in the observer's theta that the Functions take; None for all.
    theta: Sequence[int] | None = None

    def fill(self, name: str, function: ca.Function) -> ca.Function:
        """A Function of scalars without the inputs `constants`, `theta`, `rig`, `tuning`.

        Where something is taken at run time, the last input is the vector of all constants, used or not.
        """
        parts, last = self._parts()
        used = {given: parts[given] for given in function.name_in() if given in parts}
        return expand_with_constants(name, function, used, last=last)

    def _parts(self) -> tuple[dict[str, list[Any]], ca.SX | None]:
        numbers: list[Any] = self.observer.constants.tolist()
        last = ca.SX.sym("constants", len(numbers)) if self.tunable else None
        values = numbers if last is None else ca.vertsplit(last)
        rig = len(self.observer.model.coordinates)
        tuning = rig + len(RIG)
        if self.tunable == "tuning":
            values = [*numbers[:tuning], *values[tuning:]]
        theta = values[:rig] if self.theta is None else [values[i] for i in self.theta]
        after = values[tuning : tuning + len(TUNING_FIELDS)]
        parts = {"theta": theta, "rig": values[rig:tuning], "tuning": after}
        patch = numbers[-len(EQUIVALENT) :]
        return parts | {"constants": [*theta, *parts["rig"], *after, *patch]}, last
