"""The moving-horizon estimator on the declared model in compact C.

The patch of `observers.embedded.compact_patch` is stored with every sample of the window. C loops over
the samples and calls, at each, the Functions of `observers.estimators.mhe_terms`, adapted here to scalar
arguments.
"""

from collections.abc import Callable, Mapping
from typing import Any

import casadi as ca

from observers.embedded.casadi_c import embedded_code
from observers.embedded.compact_patch import (
    build_corner,
    is_declared,
    patch_bytes,
    patch_numbers,
    patch_types,
)
from observers.embedded.compact_window import (
    STORED_CORNERS,
    corner_state,
    elimination,
    elimination_size,
    is_steered,
    row_names,
    window_values,
)
from observers.embedded.constants import Constants, Tunable
from observers.embedded.scalar_type import Real
from observers.embedded.supervision_code import supervised, supervision_functions
from observers.embedded.templating import Body, render
from observers.estimators.initial_state import build_initial_state
from observers.estimators.mhe import Mhe
from observers.estimators.mhe_terms import (
    arrival_jump,
    build_acceptance,
    build_backward,
    build_forward,
    build_prediction,
    is_unsettled,
)
from observers.estimators.model_observer import ModelObserver
from observers.estimators.step_terms import StepSample, clip_to_bounds
from observers.layout import Layout, named, outputs_of
from observers.measurement.linearisation import build_clean, build_motion, directions
from observers.measurement.measurement_model import CLEAN, RIG, ROWS, AligningTorque
from observers.patch.update import slopes_by_states
from observers.protocol import SAMPLE, FunctionObserver
from observers.quality.innovation_gate import COUNTS, build_innovation
from observers.quality.innovation_monitor import MONITOR, change_variance
from observers.tuning import TUNING_FIELDS

TORQUE = ("M_z", "log_mu", "stiffness", "psi")
"""M_z, its derivatives by mu, by k over its nominal value, and, where it is a state, by the angle."""
TEST = ("accepted", "reset", "run", "missing", "expected", "nis", "inconsistent")
"""Result of the test of the newest innovation."""


def window_functions(
    observer: Mhe, output: Callable[[Mhe], ca.Function], tunable: Tunable
) -> list[ca.Function]:
    """The Functions that C calls; `output` builds the last one."""
    builders = (
        _begin,
        _clean,
        _limit,
        _predict,
        _test_innovation,
        _accept,
        _reset_arrival,
        _forward,
        _backward,
        output,
    )
    built, constants = [build(observer) for build in builders], Constants(observer, tunable)
    return [constants.fill(function.name(), function) for function in built]


def symbols(observer: ModelObserver, *names: str) -> list[ca.MX]:
    """Symbols of these names, in their shapes."""
    n = len(observer.states)
    shapes = {
        "sample": (len(SAMPLE), 1), "last": (len(CLEAN), 1), "now": (len(CLEAN), 1), "x": (n, 1),
        "mean": (n, 1), "factor": (n, n), "P": (n, n), "torque": (len(TORQUE), 1),
        "row": (len(row_names(observer)), 1), "next": (len(row_names(observer)), 1),
        "counts": (len(COUNTS), 1), "monitor": (len(MONITOR), 1),
        "eliminated": (elimination_size(observer), 1), "costate": (n, 1), "newest": (n, 1),
        "test": (len(TEST), 1), "age": (1, 1), "imputed": (1, 1), "rig": (len(RIG), 1),
        "theta": (len(observer.model.coordinates), 1), "tuning": (len(TUNING_FIELDS), 1),
    }  # fmt: skip
    return [ca.MX.sym(name, *shapes[name]) for name in names]


def _function(name: str, inputs: list[ca.MX], outputs: list[Any]) -> ca.Function:
    outputs = [ca.densify(ca.vec(ca.MX(output))) for output in outputs]
    return ca.Function(
        name, inputs, outputs, [s.name() for s in inputs], [f"o{i}" for i in range(len(outputs))]
    )


def _full_row(observer: ModelObserver, row: ca.MX) -> ca.MX:
    """A row in the order of `ROWS`; its terms do not depend on the rest."""
    stored = named(row_names(observer), row)
    full: ca.MX = ca.vertcat(*(stored.get(name, 0) for name in ROWS))
    return full


def _torque(observer: Mhe, torque: ca.MX, x: ca.MX) -> tuple[ca.MX, ca.MX]:
    """M_z and its slopes by the states."""
    by_tyre = named(TORQUE, torque)
    slopes = ca.vertcat(*(by_tyre[name] for name in directions(observer.measurement_model)))
    return by_tyre["M_z"], slopes_by_states(observer.measurement_model, slopes, x)


def no_torque(observer: ModelObserver) -> tuple[ca.DM, ca.DM]:
    """Where the angle is known the torque does not move the states."""
    return ca.DM(0), ca.DM.zeros(len(directions(observer.measurement_model)))


def _begin(observer: Mhe) -> ca.Function:
    """(sample) -> mean, factor, last."""
    n = len(observer.states)
    parts = Layout((("mean", n, 1), ("factor", n, n), ("last", len(CLEAN), 1)))
    start = build_initial_state(observer.model, observer.measurement_model, parts)
    inputs = [ca.MX.sym(name, *start.size_in(name)) for name in start.name_in()]
    return _function("begin_window", inputs, list(parts.split(start(*inputs)).values()))


def _clean(observer: Mhe) -> ca.Function:
    """(sample, last) -> the sample cleaned, and whether a value is imputed."""
    sample, last = symbols(observer, "sample", "last")
    return _function("clean", [sample, last], [*build_clean(observer.measurement_model)(sample, last)])


def _limit(observer: Mhe) -> ca.Function:
    """(x) -> within bounds."""
    x, tuning = symbols(observer, "x", "tuning")
    return _function("limit", [x, tuning], [clip_to_bounds(observer.measurement_model, x, tuning)])


def _predict(observer: Mhe) -> ca.Function:
    """(x, P, last, now) -> newest, P at it; the torque second where it moves the states."""
    names = ("x", "torque", "P", "last", "now", "rig", "tuning")
    x, torque, P, last, now, rig, tuning = inputs = symbols(observer, *names)
    by_torque = is_steered(observer)
    moved = _torque(observer, torque, x) if by_torque else no_torque(observer)
    inputs = inputs if by_torque else [x, *inputs[2:]]
    predict = build_prediction(observer.measurement_model)
    newest, P_newest, _ = predict(x, P, *moved, last, now, rig, tuning)
    return _function("predict", inputs, [newest, P_newest])


def _test_innovation(observer: Mhe) -> ca.Function:
    """(newest, torque, now, P, counts, monitor) -> test, counts, monitor."""
    names = ("newest", "torque", "now", "P", "counts", "monitor", "rig", "tuning")
    newest, torque, now, P, counts, monitor, rig, tuning = inputs = symbols(observer, *names)
    innovation = build_innovation(observer.measurement_model)
    results = outputs_of(
        innovation, newest, P, *_torque(observer, torque, newest), now, counts, monitor, rig, tuning
    )
    test = ca.vertcat(*(results[name] for name in TEST))
    return _function("test_innovation", inputs, [test, results["counts_next"], results["monitor_next"]])


def _accept(observer: Mhe) -> ca.Function:
    """(row, age, test) -> accepted, jump."""
    row, age, test, tuning = inputs = symbols(observer, "row", "age", "test", "tuning")
    stored, three = named(row_names(observer), row), test[: TEST.index("run") + 1]
    unknown = change_variance(named(TUNING_FIELDS, tuning))
    accepted = build_acceptance()(stored["accepted"], stored["jump"], age, three, unknown)
    return _function("accept", inputs, [*accepted])


def _reset_arrival(observer: Mhe) -> ca.Function:
    """(test) -> increment of the arrival's variance of ln mu."""
    test, tuning = inputs = symbols(observer, "test", "tuning")
    result, unknown = named(TEST, test), change_variance(named(TUNING_FIELDS, tuning))
    jump = arrival_jump(observer.window, result["reset"], result["run"], unknown)
    return _function("reset_arrival", inputs, [jump])


def _forward(observer: Mhe) -> ca.Function:
    """(mean, factor, x, torque, row, next) -> mean, factor, eliminated."""
    names = ("mean", "factor", "x", "torque", "row", "next", "rig", "tuning")
    mean, factor, x, torque, row, after, rig, tuning = inputs = symbols(observer, *names)
    forward = build_forward(observer.measurement_model)
    rows, (M_z, slopes) = (_full_row(observer, r) for r in (row, after)), _torque(observer, torque, x)
    results = outputs_of(forward, mean, factor, x, M_z, slopes, *rows, rig, tuning)
    results["slopes"] = slopes
    outputs = [results["mean_next"], results["factor_next"], elimination(observer).join(results)]
    return _function("forward", inputs, outputs)


def _backward(observer: Mhe) -> ca.Function:
    """(costate, eliminated, row, next) -> costate before, smoothed x within bounds."""
    names = ("costate", "eliminated", "row", "next", "rig", "tuning")
    costate, eliminated, row, after, rig, tuning = inputs = symbols(observer, *names)
    parts = elimination(observer).split(eliminated)
    # The motion is cheaper to compute again than to store with every sample.
    now, now_next = (_full_row(observer, vector)[: len(CLEAN)] for vector in (row, after))
    motion = build_motion(observer.measurement_model)
    slopes = parts.pop("slopes", no_torque(observer)[1])
    _, A, _, _ = motion(parts["filtered"], 0, slopes, now, now_next, rig, tuning)
    backward = build_backward(observer.measurement_model)
    return _function("backward", inputs, [*backward(costate, *parts.values(), A, tuning)])


def _output(observer: Mhe) -> ca.Function:
    """(x, P, newest, now, test, imputed) -> output."""
    names = ("x", "P", "newest", "now", "test", "imputed", "theta", "rig", "tuning")
    x, P, newest, now, test, imputed, theta, rig, tuning = inputs = symbols(observer, *names)
    result = named(TEST, test)
    # The full slide of the declared patch does not depend on its memory.
    memory = ca.MX(observer.model.memory_size, 1)
    sample = StepSample(
        model=observer.model, measurement_model=observer.measurement_model, now=now, imputed=imputed,
        theta=theta, rig=rig, tuning=tuning,
    )  # fmt: skip
    unsettled = is_unsettled(observer.measurement_model, x, newest, P)
    output = sample.output(x, P, memory, result["expected"], result, unsettled=unsettled)
    return _function("step_output", inputs, [output])


def is_compact_window(observer: FunctionObserver) -> bool:
    """True for one iteration over two samples or more on the declared model and the aligning torque.

    Of a sample C stores what `AligningTorque` reads; no subclass of it or of `Mhe` counts.
    """
    if type(observer) is not Mhe or type(observer.measurement_model) is not AligningTorque:
        return False
    return observer.iterations == 1 and observer.window >= 2 and is_declared(observer)


def compact_window_body(observer: Mhe, real: Real, terms: Mapping[str, Any]) -> Body:
    """The code of an estimator for which `is_compact_window` holds."""
    with_rig = terms["tunable"] == "all"
    functions = [
        build_corner(observer, with_rig=with_rig),
        *window_functions(observer, _output, terms["tunable"]),
        *supervision_functions(observer, terms["tunable"]),
    ]
    source = embedded_code(functions, real, f"{terms['name']}_core", null_checks=False)
    stiff = f"[{observer.states.index('stiffness')}]" if "stiffness" in observer.states else ""
    values = {
        **terms,
        **patch_numbers(observer, with_rig=with_rig),
        **window_values(observer),
        "stored": str(STORED_CORNERS),
        "stiffness": f"x{stiff}" if stiff else "1.0",
        "stiffness_newest": f"newest{stiff}" if stiff else "1.0",
    }
    private, size = corner_state(observer, real, terms["name"])
    body = Body(
        core=f"{source.text}\n{render('patch.c', values)}",
        stepping=render("window.c", values),
        private=private,
        bytes=size + patch_bytes(real, with_rig=with_rig),
        types=patch_types(real, terms["name"], with_rig=with_rig),
        with_rig=with_rig,
    )
    return supervised(observer, real, values, body, source, None)
