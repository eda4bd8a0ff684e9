"""What code generation asks of an observer: its two casadi Functions and the labels of their numbers."""

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import casadi as ca
from numpy.typing import NDArray

from observers.base import ModelObserver
from observers.ekf import Ekf, build_step
from observers.embedded.initial_state import build_start
from observers.layout import Layout
from observers.measurement_model import RIG
from observers.mhe import Mhe
from observers.mhe_step import build_window_step
from observers.protocol import Estimate, Sample
from observers.tuning import BELIEFS, INFORMED
from symbolic import InvalidInputError
from symbolic.serialisation import units_of

RIG_UNITS = ("m", "m", "kg m^2", "N m s/rad")


@dataclass(frozen=True, kw_only=True)
class FunctionObserver:
    """An observer as two casadi Functions.

    Attributes:
        name: name of the kind of observer, small letters.
        title: one line about the observer.
        channel: the torque that it uses, `M_z`, the aligning torque, or `M`, the steering torque.
        layout: parts of the state.
        initial_function: (sample, constants) -> state.
        step_function: (state, sample, constants) -> (state_next, output).
        constants: numbers that both Functions take, shape (c,).
        constant_labels: name and unit of every constant.
        informed_below: relative standard deviation of mu below which an estimate is informed [1].
        prior: the estimate before any sample.
        settings: settings of the observer as JSON values.
    """

    name: str
    title: str
    channel: str
    layout: Layout
    initial_function: ca.Function
    step_function: ca.Function
    constants: NDArray[Any]
    constant_labels: tuple[str, ...]
    informed_below: float
    prior: Estimate
    settings: Mapping[str, Any]


def function_observer(observer: ModelObserver) -> FunctionObserver:
    """An `Ekf` or `Mhe` as code generation takes it.

    Raises:
        InvalidInputError: the observer is neither.
    """
    if type(observer) not in KINDS:
        raise InvalidInputError(f"observer must be an Ekf or an Mhe, got {type(observer).__name__}")
    title, build = KINDS[type(observer)]
    channel = "M" if observer.measurement_model.turns else "M_z"
    effects = ", ".join(effect.name for effect in observer.model.effects)
    settings = {n: getattr(observer, n) for n in ("iterations", "window") if hasattr(observer, n)}
    return FunctionObserver(
        name=type(observer).__name__.lower(),
        title=f"{title.format(**settings)} on the {'steering' if channel == 'M' else 'aligning'} torque,"
        f" {f'effects {effects}' if effects else 'the declared model'}",
        channel=channel,
        layout=observer.layout,
        initial_function=build_start(observer),
        step_function=build(observer),
        constants=observer.constants,
        constant_labels=_constant_labels(observer),
        informed_below=INFORMED * observer.tuning.log_std,
        prior=observer.estimate(observer.init(Sample(psi=0.0, psi_dot=0.0, F_N=1.0, dt=0.01))),
        settings={
            "sensing": type(observer.measurement_model).__name__,
            "states": list(observer.states),
            "beliefs": asdict(observer.tuning),
            "settings": settings,
        },
    )


def _ekf_step(observer: Any) -> ca.Function:
    return build_step(observer.model, observer.measurement_model, observer.iterations)


def _mhe_step(observer: Any) -> ca.Function:
    return build_window_step(
        observer.model, observer.measurement_model, observer.window, observer.iterations
    )


KINDS: dict[type[ModelObserver], tuple[str, Callable[[Any], ca.Function]]] = {
    Ekf: ("Extended Kalman filter", _ekf_step),
    Mhe: ("Moving-horizon estimator over {window} samples", _mhe_step),
}
"""Title and step of every observer of which C can be generated."""


def _constant_labels(observer: ModelObserver) -> tuple[str, ...]:
    units = units_of(observer.model)
    names = (c if c in units else f"{c}, as the model counts it" for c in observer.model.coordinates)
    parameters = (f"{name} [{unit}]" for name, unit in zip(names, units.values(), strict=True))
    rig = (f"{name} [{unit}]" for name, unit in zip(RIG, RIG_UNITS, strict=True))
    return (*parameters, *rig, *(f"tuning: {name}" for name in BELIEFS))
