"""The effects that the rig plants, each at its own hook: those that the library has too."""

from dataclasses import dataclass, replace
from math import exp, inf

import numpy as np

from reference_rig.hooks import Array, BristleStep, MaxwellBranch, PlantedEffect, RigDrive, RigHistory
from reference_rig.patch import REFERENCE_SPEED, REST_SPEED

LEAST_RATE_FACTOR = 0.05
REFERENCE_LOAD = 400.0
BEARING_RATE = 0.01


@dataclass(frozen=True, kw_only=True)
class PlantedRateFriction(PlantedEffect):
    """Limit times 1 + c ln(sqrt(v² + v_0²)/v_ref)."""

    c: float = 0.0

    def friction(self, sample: BristleStep) -> Array:
        """Factor of each bristle."""
        regular = np.sqrt(sample.speed**2 + REST_SPEED**2)
        return np.maximum(LEAST_RATE_FACTOR, 1 + self.c * np.log(regular / REFERENCE_SPEED))


@dataclass(frozen=True, kw_only=True)
class PlantedFrictionalCreep(PlantedEffect):
    """Limit times 1 + c ln(v/v_ref), v the bristle's own speed."""

    c: float = 0.0

    def rate(self) -> float:
        """The growth c."""
        return self.c


@dataclass(frozen=True, kw_only=True)
class PlantedStribeck(PlantedEffect):
    """Limit times 1 + (ratio - 1) exp(-v/v_s)."""

    ratio: float = 1.0
    v_s: float = 3e-3

    def friction(self, sample: BristleStep) -> Array:
        """Factor of each bristle."""
        return 1 + (self.ratio - 1) * np.exp(-sample.speed / self.v_s)


@dataclass(frozen=True, kw_only=True)
class PlantedCarcassTorsion(PlantedEffect):
    """The patch is turned by psi + M_z/k_t, k_t in N m/rad."""

    k_t: float = inf

    def compliance(self) -> float:
        """One over k_t."""
        return 1 / self.k_t


@dataclass(frozen=True, kw_only=True)
class PlantedContactLength(PlantedEffect):
    """The half-length is a (F_N / (F_0 (a / 45 mm)^m))^n, F_0 in N."""

    n: float = 0.0
    F_0: float = 400.0
    m: float = 2.0

    def span(self) -> float:
        """Room to grow, none where it does not."""
        return 1.6 if self.n else 1.0

    def growth(self, F_N: float, a: float) -> float:
        """The factor."""
        return (F_N / (self.F_0 * (a / 0.045) ** self.m)) ** self.n


@dataclass(frozen=True, kw_only=True)
class PlantedPatchWidth(PlantedEffect):
    """Bristles fill |y| <= half_width [m]."""

    half_width: float = 0.0

    def width(self) -> float:
        """The half-width itself."""
        return self.half_width


@dataclass(frozen=True, kw_only=True)
class PlantedPressureShape(PlantedEffect):
    """Pressure ~ 1 - |x/a|^exponent with the load unchanged."""

    exponent: float = 2.0

    def pressure(self, xi: Array) -> Array:
        """Ratio of the two normalised shapes."""
        n = self.exponent
        return (n + 1) / (2 * n) * (1 - np.abs(xi) ** n) / (0.75 * (1 - xi**2))


@dataclass(frozen=True, kw_only=True)
class PlantedViscoelasticRelaxation(PlantedEffect):
    """Maxwell branch of stiffness gain k and relaxation time [s]."""

    gain: float = 0.0
    time: float = 0.5

    def relaxation(self) -> MaxwellBranch:
        """The branch."""
        return MaxwellBranch(gain=self.gain, time=self.time)


@dataclass(frozen=True, kw_only=True)
class PlantedContactDamping(PlantedEffect):
    """M_z -= c psi_dot, c in N m s/rad."""

    c: float = 0.0

    def torque(self, history: RigHistory) -> Array:
        """Torque with the damping."""
        return history.M_z - self.c * history.drive.psi_dot


@dataclass(frozen=True, kw_only=True)
class PlantedSensorDelay(PlantedEffect):
    """The torque channel shows the torque of `delay` [s] ago; at first, that of the first sample."""

    delay: float = 0.0

    @property
    def rank(self) -> int:
        """Last: the channel delays whatever makes the torque."""
        return 1

    def torque(self, history: RigHistory) -> Array:
        """Late torque, linear between samples."""
        t = history.drive.t
        return np.interp(t - self.delay, t, history.M_z)


@dataclass(frozen=True, kw_only=True)
class PlantedTorqueOffset(PlantedEffect):
    """M_z += M_0 [N m]."""

    M_0: float = 0.0

    def torque(self, history: RigHistory) -> Array:
        """Shifted torque."""
        return history.M_z + self.M_0


@dataclass(frozen=True, kw_only=True)
class PlantedPretwist(PlantedEffect):
    """A virgin patch was turned by psi_0 [rad] before the first sample."""

    psi_0: float = 0.0

    def drive(self, drive: RigDrive) -> RigDrive:
        """The first step of the patch turns it by psi_0."""
        return replace(drive, psi_virgin=drive.psi_virgin - self.psi_0)


@dataclass(frozen=True, kw_only=True)
class PlantedLoadDependentFriction(PlantedEffect):
    """Limit times (F_N/F_ref)^(-n)."""

    n: float = 0.0

    def friction(self, sample: BristleStep) -> float:
        """Factor of all bristles."""
        return (sample.F_N / REFERENCE_LOAD) ** -self.n


@dataclass(frozen=True, kw_only=True)
class PlantedAsymmetricFriction(PlantedEffect):
    """Limit times ratio while psi_dot > 0."""

    ratio: float = 1.0

    def friction(self, sample: BristleStep) -> float:
        """Factor of all bristles."""
        return self.ratio if sample.psi_dot > 0 else 1.0


@dataclass(frozen=True, kw_only=True)
class PlantedFrictionDrift(PlantedEffect):
    """Limit times 1 + gain (1 - exp(-s/scale)), s the angle turned so far, scale in rad."""

    gain: float = 0.0
    scale: float = 0.5

    def friction(self, sample: BristleStep) -> float:
        """Factor of all bristles."""
        return 1 + self.gain * (1 - exp(-sample.travel / self.scale))


@dataclass(frozen=True, kw_only=True)
class PlantedPressureSkew(PlantedEffect):
    """Pressure times 1 + skew x/a."""

    skew: float = 0.0

    def pressure(self, xi: Array) -> Array:
        """Factor at each bristle."""
        return 1 + self.skew * xi


@dataclass(frozen=True, kw_only=True)
class PlantedBearingFriction(PlantedEffect):
    """M_z -= M_c tanh(psi_dot/omega_0), M_c in N m."""

    M_c: float = 0.0

    def torque(self, history: RigHistory) -> Array:
        """Torque with the dry friction."""
        return history.M_z - self.M_c * np.tanh(history.drive.psi_dot / BEARING_RATE)


@dataclass(frozen=True, kw_only=True)
class PlantedSteeringReturn(PlantedEffect):
    """M_z -= stiffness psi, stiffness in N m/rad."""

    stiffness: float = 0.0

    def torque(self, history: RigHistory) -> Array:
        """Torque with the return."""
        return history.M_z - self.stiffness * history.drive.psi


@dataclass(frozen=True, kw_only=True)
class PlantedBacklash(PlantedEffect):
    """A gap [rad], from flank to flank, that is crossed at no torque; flanks are hard."""

    gap: float = 0.0

    def lost_motion(self) -> float:
        """The gap itself."""
        return self.gap


LIBRARY_EFFECTS: dict[str, type[PlantedEffect]] = {
    "rate_friction": PlantedRateFriction,
    "frictional_creep": PlantedFrictionalCreep,
    "stribeck": PlantedStribeck,
    "carcass_torsion": PlantedCarcassTorsion,
    "contact_length": PlantedContactLength,
    "patch_width": PlantedPatchWidth,
    "pressure_shape": PlantedPressureShape,
    "viscoelastic_relaxation": PlantedViscoelasticRelaxation,
    "contact_damping": PlantedContactDamping,
    "sensor_delay": PlantedSensorDelay,
    "torque_offset": PlantedTorqueOffset,
    "pretwist": PlantedPretwist,
    "load_dependent_friction": PlantedLoadDependentFriction,
    "asymmetric_friction": PlantedAsymmetricFriction,
    "friction_drift": PlantedFrictionDrift,
    "pressure_skew": PlantedPressureSkew,
    "bearing_friction": PlantedBearingFriction,
    "steering_return": PlantedSteeringReturn,
    "backlash": PlantedBacklash,
}
"""Name of the effect -> its class; the class's fields are the parameters, neutral by default."""
