"""The interface that observers need of a model of the contact patch."""

from collections.abc import Hashable
from typing import Protocol

import casadi as ca

from observers.measurement.measurement_model import RIG
from observers.tuning import TUNING_FIELDS


class PatchModel(Hashable, Protocol):
    """A contact patch whose torque depends on its memory; `symbolic.Model` is one.

    signals (4,) are in the order of `symbolic.SIGNALS`, theta (p,) in that of `coordinates`, and
    geometry (2,) in that of `symbolic.GEOMETRY`.
    """

    @property
    def memory_size(self) -> int:
        """Length of the memory, m."""

    @property
    def coordinates(self) -> tuple[str, ...]:
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
        """(memory, F_N, theta, geometry, rate) -> (mu_eff, M_slide), see `symbolic.full_slide`."""

    def memory_depends_on(self, coordinate: str) -> bool:
        """True where the memory depends on a parameter."""


EQUIVALENT = ("stiffness", "friction")
"""Last of an observer's constants: numbers of `observers.quality.acquisition.EquivalentPatch` [1]."""


def observer_constants_size(model: PatchModel) -> int:
    """Length of the constants of an observer: theta, the rig, the tuning, the equivalent patch."""
    return len(model.coordinates) + len(RIG) + len(TUNING_FIELDS) + len(EQUIVALENT)


def split_theta_rig_tuning(model: PatchModel, constants: ca.MX) -> tuple[ca.MX, ca.MX, ca.MX]:
    """theta, rig and tuning of an observer's constants."""
    at, end = len(model.coordinates), constants.numel()
    places = [0, at, at + len(RIG), end - len(EQUIVALENT), end]
    theta, rig, tuning, _ = ca.vertsplit(constants, places)
    return theta, rig, tuning
