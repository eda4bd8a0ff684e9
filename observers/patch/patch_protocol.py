"""The interface that observers need of a model of the contact patch, and the effective friction by it.

The standard deviation of that follows from that of mu by the delta method; `mu_eff` is linear in mu for
every effect of the library.
"""

from collections.abc import Hashable
from functools import cache
from typing import Any, Protocol

import casadi as ca

from observers.layout import named, symbols, vector_of
from observers.measurement.measurement_model import RIG
from observers.protocol import OUTPUT
from observers.tuning import TUNING_FIELDS
from symbolic import GEOMETRY
from symbolic.named_and_buffered_functions import named_function


class PatchModel(Hashable, Protocol):
    """A contact patch whose torque depends on its memory; `symbolic.Model` is one.

    signals (4,) are in the order of `symbolic.SIGNALS`, theta (p,) in that of `coordinate_names`, and
    geometry (2,) in that of `symbolic.GEOMETRY`.
    """

    @property
    def memory_size(self) -> int:
        """Length of the memory, m."""

    @property
    def coordinate_names(self) -> tuple[str, ...]:
        """Names of the parameters theta, `mu` and `k` among them."""

    @property
    def initial(self) -> ca.Function:
        """(signals of the first sample, theta, geometry) -> memory (m,) before it."""

    @property
    def advance(self) -> ca.Function:
        """(memory, signals, theta, geometry) -> (memory_next, patch_signals), those that reach it."""

    @property
    def torque(self) -> ca.Function:
        """(memory_next, patch_signals, theta, geometry) -> M_z [N m]."""

    @property
    def full_slide(self) -> ca.Function:
        """(memory, F_N, theta, geometry, rate) -> (mu_eff, M_slide), by `full_slide_friction`."""

    def memory_depends_on(self, coordinate: str) -> bool:
        """True where the memory depends on a parameter."""


EQUIVALENT = ("stiffness", "friction")
"""Last of an observer's constants: numbers of `observers.quality.acquisition.EquivalentPatch` [1]."""


def observer_constants_size(model: PatchModel) -> int:
    """Length of the constants of an observer: theta, the rig, the tuning, the equivalent patch."""
    return len(model.coordinate_names) + len(RIG) + len(TUNING_FIELDS) + len(EQUIVALENT)


def split_theta_rig_tuning(model: PatchModel, constants: ca.MX) -> tuple[ca.MX, ca.MX, ca.MX]:
    """theta, rig and tuning of an observer's constants."""
    at, end = len(model.coordinate_names), constants.numel()
    places = [0, at, at + len(RIG), end - len(EQUIVALENT), end]
    theta, rig, tuning, _ = ca.vertsplit(constants, places)
    return theta, rig, tuning


@cache
def build_effective_friction(model: PatchModel) -> ca.Function:
    """(mu, mu_std, memory, F_N, theta, geometry, rate) -> (mu_eff, mu_eff_std, M_slide).

    memory (m,) after the sample, load [N] and parameters as of the model, theta at any mu; rate [rad/s]
    is that of the full slide. See `symbolic.full_slide_friction`.
    """
    inputs = symbols(
        ca.MX, mu=1, mu_std=1, memory=model.memory_size, F_N=1, theta=len(model.coordinate_names),
        geometry=len(GEOMETRY), rate=1,
    )  # fmt: skip
    mu, mu_std, memory, F_N, theta, geometry, rate = inputs.values()
    at = vector_of(model.coordinate_names, {**named(model.coordinate_names, theta), "mu": mu})
    mu_eff, M_slide = model.full_slide.call([memory, F_N, at, geometry, rate], True, False)
    deviation = ca.fabs(ca.jtimes(mu_eff, mu, ca.MX(1))) * mu_std
    outputs = {"mu_eff": mu_eff, "mu_eff_std": deviation, "M_slide": M_slide}
    return named_function("effective_friction", inputs, outputs, cse=True)


def output_vector(**known: Any) -> ca.MX:
    """An output in the order of `OUTPUT`; a status that is not given is 0, all else that is not NaN."""
    vector: ca.MX = vector_of(OUTPUT, dict.fromkeys(OUTPUT, float("nan")) | {"status": 0} | known)
    return vector
