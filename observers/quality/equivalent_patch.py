"""The declared patch that replaces a model with effects while friction is acquired.

Acquisition weighs hypotheses on the declared patch, which costs little and forgets nothing wrongly. A
model with effects is softer, or slides at another level: it is driven once through a turn and back, and
the acquisition itself says which declared patch it looks like. What effects add to the patch's torque,
as a spring does, no declared patch looks like, and it does not scale with friction: it is taken off. So
is the turn through a gap, which the torque tells by its sign.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import cache

import casadi as ca
import numpy as np

from observers.layout import Expression, Layout, named, symbols, vector_of
from observers.measurement.measurement_model import CLEAN, MeasurementModel
from observers.measurement.torque_error import is_known
from observers.patch.update import signals_with_states
from observers.quality.acquisition import DECLARED_PATCH, EquivalentPatch, build_hypothesis_search_step
from observers.quality.acquisition_handover import newest_sample_values, newest_state
from observers.quality.mu_and_scale_from_hypotheses import VERDICT
from observers.quality.mu_over_k_hypotheses import RATIOS, SETTINGS, VAGUE, build_hypothesis_search_start
from observers.tuning import Tuning
from symbolic import GEOMETRY, SIGNALS, InvalidInputError, Model, Rig, full_slide_torque, simulate
from symbolic.bristle_patch import BristlePatch
from symbolic.effects.base import Effect, Signals
from symbolic.elements_in_series import series_deflection
from symbolic.full_slide_friction import effect_factor_and_torque
from symbolic.model import add_effect_torques
from symbolic.named_and_buffered_functions import named_function
from symbolic.patch_interface import patch_inputs

TURN, RATE, PERIOD = 0.3, 0.2, 0.01
"""The path: so far to one side and to the other [rad], so fast [rad/s], a sample so often [s]."""
SLIDES_AT = 0.08
"""Turn at which the patch begins to slide as a whole under the load of the path, mu = 1 [rad]."""
MISFIT = 0.05
"""Least difference of a model from its equivalent patch, as a share of the torque [1]."""

REST = 1e-3
"""Least rate at which friction is taken [rad/s]: that of a wheel which turns back."""
COLUMNS = 4
"""Bristles over the length whose friction tells that of the patch at a rate [1]."""
CLEAR, ANY = 3.0, 1e9
"""Deviations within which a torque may be on either flank of a gap [1]; a torque of any size [N m]."""
SLIDES = 0.75
"""Share of the full slide from which on a memory that mu enters is handed over [1].

While friction is acquired mu changes from sample to sample; what a patch keeps of that, a filter would
take for torque. Chosen on simulated turns of 0.04 to 0.06 rad with carcass torsion, errors 0.2 to 2 %:
of 800 other runs, 20 of 584 usable ones were beyond three deviations without it, 1 of 395 with it.
"""


def equivalent_patch(model: Model, values: Mapping[str, float], rig: Rig) -> EquivalentPatch:
    """The declared patch that comes closest to a model; the declared model is its own."""
    if not model.effects:
        return DECLARED_PATCH
    return _fit_equivalent_patch(model, tuple(sorted(values.items())), rig.a, rig.e)


@cache
def build_added_torque(model: Model) -> ca.Function | None:
    """Torque beside that of the patch [N m]: (signals, theta) -> torque; None where no effect adds one.

    signals are in the order of `SIGNALS`; a sensor's delay is left out.
    """
    if all(type(effect).torque is Effect.torque for effect in model.effects):
        return None
    signals, theta = ca.MX.sym("signals", len(SIGNALS)), ca.MX.sym("theta", len(model.coordinate_names))
    given = Signals(**dict(zip(SIGNALS, ca.vertsplit(signals), strict=True)))
    outputs = {"torque": add_effect_torques(ca.MX(0), model, given, theta)}
    return named_function("added_torque", {"signals": signals, "theta": theta}, outputs)


@cache
def build_equivalent_contact(model: Model) -> ca.Function | None:
    """Loads and half-length with which the declared patch slides as a model does at this rate and load.

    (signals, theta, geometry) -> (loads, half_length): loads (2,) [N] make the friction of mu that of
    the present rate and that of rest; half-length [m]. Friction is that of a steady full slide, see
    `symbolic.full_slide_friction`, without what effects count up. None where neither rate nor load
    matters.
    """
    inputs = symbols(
        ca.MX, signals=len(SIGNALS), theta=len(model.coordinate_names), geometry=len(GEOMETRY)
    )
    signals, theta, geometry = inputs.values()
    given, at = named(SIGNALS, signals), {**named(model.coordinate_names, theta), "mu": 1}
    patch, F_N, half_length = model.patch(theta), given["F_N"], geometry[0]
    effects, (_, _, counted) = (
        model.values_by_effect(theta),
        model.split_angle_patch_effects(ca.MX.zeros(model.memory_size)),
    )
    bristles, creeps = None, False
    if isinstance(patch, BristlePatch):
        traits = patch.traits
        half_length = half_length * traits.relative_length(F_N, geometry[0])
        if (creeps := traits.creep is not None) or traits.limits:
            columns = COLUMNS if traits.half_width is None else 2 * COLUMNS
            bristles = BristlePatch(traits=replace(traits, growth=None), columns=columns, rows=1)

    def friction(rate: Expression) -> Expression:
        sides = [Signals(psi=0, psi_dot=side, F_N=F_N, dt=1) for side in (rate, -rate)]
        factor = sum(effect_factor_and_torque(effects, counted, side)[0] for side in sides) / 2
        if bristles is None:
            return factor
        contact, values_at = ca.vertcat(half_length, geometry[1]), vector_of(model.coordinate_names, at)
        slide = patch_inputs(replace(sides[0], F_N=1), 1, values_at, contact)
        neutral = replace(bristles, traits=replace(bristles.traits, limits=(), creep=None))
        return factor * bristles.effective_friction(slide) / neutral.effective_friction(slide)

    now = friction(ca.fmax(ca.fabs(given["psi_dot"]), REST))
    # Creep takes long. Friction that falls with speed has no time to rise where the wheel turns back.
    rest = now if creeps else ca.fmin(now, friction(ca.MX(REST)))
    if not any(ca.which_depends(ca.vertcat(now, rest, half_length), signals)):
        return None
    outputs = {"loads": F_N * ca.vertcat(now, rest), "half_length": half_length}
    return named_function("equivalent_contact", inputs, outputs, cse=True)


@cache
def build_patch_angle(model: Model) -> ca.Function | None:
    """(last, psi, M_z, variance, F_N, theta) -> angle behind the gaps in series with the patch [rad].

    Of the angles that a torque of this variance allows it is the one next to the last: where the torque
    does not tell which flank is touched, what is behind stays. None where there is no gap.
    """
    if (deflection := series_deflection(model, gaps=True)) is None:
        return None
    inputs = symbols(ca.MX, last=1, psi=1, M_z=1, variance=1, F_N=1, theta=len(model.coordinate_names))
    last, psi, M_z, variance, F_N, theta = inputs.values()
    known, elements = is_known(M_z), ca.vertcat(F_N, theta)
    torque = ca.if_else(known, M_z, 0)
    off = ca.if_else(known, CLEAR * ca.sqrt(variance), ANY)
    low, high = (psi + deflection(torque + side * off, elements) for side in (-1, 1))
    angle = ca.if_else(is_known(psi), ca.fmax(low, ca.fmin(high, last)), last)
    return named_function("patch_angle", inputs, {"angle": angle})


def effect_torques_of_sample(
    model: Model, measurement_model: MeasurementModel, parts: Layout, state: Expression,
    theta: Expression, psi: Expression,
) -> tuple[Expression, Expression]:  # fmt: skip
    """That torque at the angle psi of a torque, and at the newest sample of the state [N m]."""
    added = build_added_torque(model)
    if added is None:
        return ca.MX(0), ca.MX(0)
    signals = newest_signals(measurement_model, parts, state)
    return added(ca.vertcat(psi, signals[1:]), theta), added(signals, theta)


def newest_signals(measurement_model: MeasurementModel, parts: Layout, state: Expression) -> Expression:
    """Signals of the model at the newest sample of a state."""
    x = (newest_state(parts, measurement_model, state, name) for name in measurement_model.states)
    now = newest_sample_values(parts, state, CLEAN)
    return signals_with_states(measurement_model, ca.vertcat(*x), now)


@cache
def _fit_equivalent_patch(
    model: Model, values: tuple[tuple[str, float], ...], a: float, e: float
) -> EquivalentPatch:
    """The same of values that can be looked up."""
    theta, k = model.theta({**dict(values), "mu": 1.0}), dict(values)["k"]
    ahead = np.arange(0, TURN, RATE * PERIOD)
    psi = np.concatenate([ahead, np.arange(TURN, -TURN, -RATE * PERIOD), -TURN + ahead])
    load, count = SLIDES_AT * 4 * a**2 * k / 3, psi.size
    F_N, dt = np.full((1, count), load), np.full(count, PERIOD)
    signals = np.vstack([psi, np.gradient(psi, PERIOD), F_N, dt])
    M_z = simulate(model, signals, np.array(theta).ravel(), np.array([a, e])).M_z
    if (added := build_added_torque(model)) is not None:
        M_z = M_z - np.asarray(added(signals, theta)).ravel()
    if (behind := series_deflection(model, gaps=True)) is not None:
        elements = np.vstack([F_N, np.tile(np.asarray(theta).reshape(-1, 1), count)])
        psi = psi + np.asarray(behind(M_z.reshape(1, -1), elements)).ravel()
    loads, half_length = np.repeat(F_N, 2, axis=0), np.full((1, count), a)
    if (contact := build_equivalent_contact(model)) is not None:
        loads, half_length = map(np.asarray, contact(signals, theta, np.array([a, e])))
    tuning = Tuning(mu_std=1.0, error=MISFIT, psi_noise=1e-5, stiffness_std=1.0)
    start = build_hypothesis_search_start()(
        psi[0], 1, VAGUE, 0, tuning.zero_std * full_slide_torque(load, a)
    )
    search = build_hypothesis_search_step().mapaccum("searches", count, 2, {})
    tyre = np.vstack([np.full(count, k), half_length, np.full(count, e)])
    settings = np.array([[getattr(tuning, name)] for name in SETTINGS])
    phases = np.arange(count).reshape(1, -1) % 2
    _, verdicts, _, _ = search(
        start, np.zeros(len(VERDICT)), phases, np.full_like(phases, len(RATIOS)), psi.reshape(1, -1),
        F_N, loads, M_z.reshape(1, -1), np.zeros((1, count)),
        tyre, np.tile(settings, count),
    )  # fmt: skip
    last = dict(zip(VERDICT, np.asarray(verdicts)[:, -1].tolist(), strict=True))
    found = np.exp([last["log_gain"], last["log_mu"]])
    if not np.isfinite(found).all():
        raise InvalidInputError(
            "the model's torque is not finite over a turn and back; check the parameters of its effects"
        )
    return EquivalentPatch(
        stiffness=float(found[0]),
        friction=float(found[1]),
        misfit=MISFIT,
        memoryless_share=SLIDES if model.memory_depends_on("mu") else 0.0,
    )
