"""Effects of a user's own, from the modules that `--effects` names."""

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path

from symbolic import Effect, InvalidInputError, Model, effects_in
from symbolic.errors import cut_to_one_line

HOOKS = (
    "transform_inputs", "initial_angle", "friction", "traits", "deflection", "torque",
    "torque_of_memory", "scope_of",
)  # fmt: skip
"""Methods of an effect of which it overrides at least one."""


def import_user_effects(modules: Sequence[str] | None) -> tuple[Effect, ...]:
    """The effects that modules declare as `EFFECTS`, in order; none for None.

    The modules are imported, which runs their code; a model file alone never has anything imported.
    The current directory, or that of a file, is put last on `sys.path` and stays there: the processes of
    a search find the same modules, and no file that lies in it takes the place of an installed one.
    """
    effects: dict[str, Effect] = {}
    for name in _module_names(modules):
        for effect in _effects_of(name):
            if effects.setdefault(effect.name, effect) is not effect:
                raise InvalidInputError(
                    f"--effects {name}: effect {effect.name!r} is declared by another module as well;"
                    " every effect needs a name of its own"
                )
    return tuple(effects.values())


def effect_files(modules: Sequence[str] | None, effects: Sequence[Effect]) -> list[Path]:
    """The files of these modules, their packages and the classes of their effects; none for None."""
    kinds = [kind for effect in effects for kind in type(effect).__mro__]
    names = [*_module_names(modules), *(kind.__module__ for kind in kinds)]
    packages = [name.rsplit(".", depth)[0] for name in names for depth in range(name.count(".") + 1)]
    files = [getattr(sys.modules[name], "__file__", None) for name in dict.fromkeys([*names, *packages])]
    return [Path(file) for file in files if file]


def _module_names(modules: Sequence[str] | None) -> list[str]:
    names = (name.strip() for entry in modules or () for name in entry.split(","))
    return list(dict.fromkeys(_make_importable(name) for name in names if name))


def _make_importable(name: str) -> str:
    """The name of a module, of which Python now knows the folder; that of a file, if one is given."""
    file = Path(name) if name.endswith(".py") else None
    folder = str(Path.cwd() if file is None else file.parent.resolve())
    if folder not in sys.path:
        sys.path.append(folder)
    return name if file is None else file.stem


def _effects_of(name: str) -> tuple[Effect, ...]:
    with _user_errors_as_input_error(
        f"--effects {name}: cannot be imported",
        "give the name of a module that Python finds here or on its path, such as mypackage.effects",
    ):
        module = import_module(name)
    try:
        return tuple(_validated_effect(effect) for effect in effects_in(module))
    except InvalidInputError as error:
        origin = getattr(module, "__file__", None) or "no file"
        raise InvalidInputError(f"--effects {name}: {error}; it was imported from {origin}") from None


def _validated_effect(effect: Effect) -> Effect:
    """The effect, where it has a hook and a model with it can be built."""
    if all(getattr(type(effect), hook) is getattr(Effect, hook) for hook in HOOKS):
        raise InvalidInputError(
            f"effect {effect.name!r} changes nothing: it overrides none of {', '.join(HOOKS)}; is the"
            " name of a method misspelt?"
        )
    model = Model(effects=(effect,))
    names = ", ".join(parameter.name for parameter in effect.parameters) or "none"
    with _user_errors_as_input_error(
        f"effect {effect.name!r} fails",
        f"its parameters are {names}, and hooks take expressions of CasADi: casadi.if_else, casadi.fabs,"
        " casadi.exp in place of if and math",
    ):
        _ = model.initial, model.step, model.full_slide
    return effect


@contextmanager
def _user_errors_as_input_error(what: str, remedy: str) -> Iterator[None]:
    """Runs the user's code: whatever it raises is one line, also when it exits the process."""
    try:
        yield
    except (KeyboardInterrupt, GeneratorExit):
        raise
    except BaseException as error:
        try:
            reason = cut_to_one_line(str(error))
        except Exception:  # __str__ is the user's code too.
            reason = "its message cannot be shown"
        raise InvalidInputError(f"{what}: {type(error).__name__}: {reason}; {remedy}") from None
