"""Every effect that the search may pick, by name, in the order of the vocabulary."""

from collections.abc import Iterable, Mapping
from types import ModuleType

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


RESERVED = ("learned",)
"""Names that a model file gives another meaning."""


def effects_named(chosen: Iterable[str | Effect], own: Iterable[Effect] = ()) -> tuple[Effect, ...]:
    """The effects of these names; an effect stands for itself.

    Args:
        chosen: names of effects of the library or of `own`, or effects.
        own: effects beside the library's that a name may stand for.

    Raises:
        InvalidInputError: a name is unknown or stands twice, or an effect is not one that can stand
            beside the library's, see `effects_in`.
    """
    wanted = tuple(chosen)
    known = EFFECTS | {effect.name: effect for effect in checked_effects(own)}
    effects = tuple(known.get(item, item) if isinstance(item, str) else item for item in wanted)
    for effect in effects:
        if isinstance(effect, str):
            raise InvalidInputError(
                f"unknown effect {effect!r}; known are {', '.join(known)}; pass an effect of your own as"
                " effects=[...], on the command line as --effects MODULE"
            )
    return checked_effects(effects)


def effects_in(module: ModuleType) -> tuple[Effect, ...]:
    """The effects that a user's module declares as `EFFECTS`, an iterable of `Effect` objects.

    Raises:
        InvalidInputError: the module declares none, something else is among them, two have the same
            name, a name is no identifier, or it is that of another effect of the library.
    """
    name = module.__name__
    declared = getattr(module, "EFFECTS", None)
    if not isinstance(declared, Iterable) or isinstance(declared, str | Mapping):
        raise InvalidInputError(
            f"module {name} must declare its effects as EFFECTS = [MyEffect(), ...], objects of Effect"
        )
    try:
        return checked_effects(declared)
    except InvalidInputError as error:
        raise InvalidInputError(f"module {name}: {error}") from None


def checked_effects(effects: Iterable[object]) -> tuple[Effect, ...]:
    """These effects, each with a name of its own that means no other effect of the library.

    Raises:
        InvalidInputError: see `effects_in`.
    """
    checked: dict[str, Effect] = {}
    for effect in effects:
        if not isinstance(effect, Effect):
            raise InvalidInputError(f"an effect must be an object of Effect, got {effect!r}")
        if not effect.name.isidentifier() or effect.name in RESERVED:
            raise InvalidInputError(
                f"an effect's name must be an identifier other than {', '.join(RESERVED)}, got"
                f" {effect.name!r}"
            )
        if EFFECTS.get(effect.name, effect) != effect:
            raise InvalidInputError(
                f"effect {effect.name!r} has the name of another one in the library; choose another name"
            )
        if effect.name in checked:
            raise InvalidInputError(f"effect {effect.name!r} is named twice")
        checked[effect.name] = effect
    return tuple(checked.values())
