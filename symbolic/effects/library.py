"""Every effect that the search may pick, by name: one module of this package each.

A new effect is a new module here; nothing else lists it.
"""

from collections.abc import Iterable, Mapping
from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType
from typing import get_args

from symbolic import effects as package
from symbolic.effects.base import Effect, Family
from symbolic.effects.by_ground import GROUND_SCOPES
from symbolic.errors import InvalidInputError

NO_EFFECTS = ("base", "by_ground", "library")
"""Modules of this package that hold no effect."""
ON_REQUEST = ("iwan",)
"""Modules whose effects replace what a wheel is; a search tries them only where it is asked to."""


def _effects_defined_in(modules: Iterable[str]) -> dict[str, Effect]:
    """One object of each subclass of `Effect` that these modules of this package define, by its name."""
    found = {}
    for name in modules:
        module = import_module(f"{package.__name__}.{name}")
        for kind in vars(module).values():
            if (
                isinstance(kind, type)
                and kind.__module__ == module.__name__
                and issubclass(kind, Effect)
            ):
                effect = kind()  # type: ignore[call-arg]
                found[effect.name] = effect
    return found


EFFECTS = _effects_defined_in(
    sorted({module.name for module in iter_modules(package.__path__)} - {*NO_EFFECTS, *ON_REQUEST})
)
CANDIDATES = EFFECTS | GROUND_SCOPES
"""Effects that the search tries."""
KNOWN = CANDIDATES | _effects_defined_in(ON_REQUEST)
"""Effects that a model file, or a list of candidates, may name."""


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
    known = KNOWN | {effect.name: effect for effect in checked_effects(own)}
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
            name, a name is no identifier or that of another effect of the library, a family is unknown,
            or one cannot be hashed, as with a list of parameters.
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
    """These effects, each of a name that means no other of the library; errors as of `effects_in`."""
    checked: dict[str, Effect] = {}
    for effect in effects:
        if not isinstance(effect, Effect):
            raise InvalidInputError(f"an effect must be an object of Effect, got {effect!r}")
        if not effect.name.isidentifier():
            raise InvalidInputError(f"an effect's name must be an identifier, got {effect.name!r}")
        if effect.family not in get_args(Family):
            raise InvalidInputError(
                f"effect {effect.name!r} has the unknown family {effect.family!r}; known are"
                f" {', '.join(get_args(Family))}"
            )
        try:
            hash(effect)
        except TypeError as error:
            raise InvalidInputError(
                f"effect {effect.name!r} must be a frozen dataclass whose parameters must be a tuple,"
                f" and so must its signatures: {error}"
            ) from None
        if KNOWN.get(effect.name, effect) != effect:
            raise InvalidInputError(
                f"effect {effect.name!r} has the name of another one in the library; choose another name"
            )
        if effect.name in checked:
            raise InvalidInputError(f"effect {effect.name!r} is named twice")
        checked[effect.name] = effect
    return tuple(checked.values())
