"""Every effect that the search may pick, by name, in the order of the vocabulary."""

from collections.abc import Iterable

from symbolic.effects.asymmetric_friction import AsymmetricFriction
from symbolic.effects.base import Effect
from symbolic.effects.bearing_friction import BearingFriction
from symbolic.effects.carcass_torsion import CarcassTorsion
from symbolic.effects.contact_damping import ContactDamping
from symbolic.effects.contact_length import ContactLength
from symbolic.effects.friction_drift import FrictionDrift
from symbolic.effects.frictional_creep import FrictionalCreep
from symbolic.effects.load_dependent_friction import LoadDependentFriction
from symbolic.effects.patch_width import PatchWidth
from symbolic.effects.pressure_shape import PressureShape
from symbolic.effects.pressure_skew import PressureSkew
from symbolic.effects.pretwist import Pretwist
from symbolic.effects.rate_friction import RateFriction
from symbolic.effects.sensor_delay import SensorDelay
from symbolic.effects.steering_return import SteeringReturn
from symbolic.effects.stribeck import Stribeck
from symbolic.effects.torque_offset import TorqueOffset
from symbolic.effects.viscoelastic_relaxation import ViscoelasticRelaxation
from symbolic.errors import InvalidInputError

EFFECTS: dict[str, Effect] = {
    effect.name: effect
    for effect in (
        RateFriction(),
        FrictionalCreep(),
        Stribeck(),
        LoadDependentFriction(),
        AsymmetricFriction(),
        FrictionDrift(),
        CarcassTorsion(),
        ContactLength(),
        PatchWidth(),
        PressureShape(),
        PressureSkew(),
        ViscoelasticRelaxation(),
        ContactDamping(),
        BearingFriction(),
        SteeringReturn(),
        SensorDelay(),
        TorqueOffset(),
        Pretwist(),
    )
}


def effects_named(names: Iterable[str]) -> tuple[Effect, ...]:
    """The effects of these names.

    Raises:
        InvalidInputError: a name is not in the vocabulary, or stands twice.
    """
    chosen = tuple(names)
    for name in chosen:
        if name not in EFFECTS:
            raise InvalidInputError(f"unknown effect {name!r}; known are {', '.join(EFFECTS)}")
        if chosen.count(name) > 1:
            raise InvalidInputError(f"effect {name!r} is named twice")
    return tuple(EFFECTS[name] for name in chosen)
