"""What an estimator in compact C asks of a contact patch."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from observers.embedded.patches.linear_torque import LinearTorque
from observers.embedded.scalar_type import Real
from observers.model_observer import ModelObserver


@dataclass(frozen=True)
class Kept:
    """What a window keeps of the patch with its samples.

    Attributes:
        reals, integers: fields of C; integers come last in the state.
        bytes: of both, a sample.
    """

    reals: str
    integers: str
    bytes: int


class EmbeddedPatch(Protocol):
    """A contact patch as text of C.

    Its C defines `begin_patch` and `advance_patch`, for a window `begin_kept`, `follow_sample` and
    `kept_torque`, and, where the memory depends on mu, `forget_sensitivity`. A torque is an array in the
    order of `templates/patches/interface.c`.
    """

    @property
    def observer(self) -> ModelObserver:
        """The observer whose patch it is."""

    @property
    def real(self) -> Real:
        """The type of its numbers."""

    @property
    def bytes(self) -> int:
        """Bytes of the patch in the state."""

    @property
    def kept(self) -> Kept:
        """What a window keeps of the patch with its samples."""

    @property
    def torque_model(self) -> LinearTorque:
        """The patch as Functions of the estimator have it."""

    @property
    def follows_mu(self) -> bool:
        """The memory depends on mu: it is moved to first order when mu is corrected."""

    @property
    def takes_rig(self) -> bool:
        """Model and rig can be taken at run time."""

    @property
    def k(self) -> str:
        """C of the stiffness of the tyre, beside the state."""

    @property
    def terms(self) -> Mapping[str, Any]:
        """Values of the placeholders that templates of estimators share."""

    def text(self, terms: Mapping[str, Any]) -> str:
        """C of the patch: tables, expressions, loops."""

    def tables(self) -> str:
        """C of the tables that elementary functions read."""

    def state_type(self, name: str) -> str:
        """The type of the patch, C of a header."""
