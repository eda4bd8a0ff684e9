"""Chance has to stay within the bands, and what the rig plants has to stand out."""

import json
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from identification import Recording, fit
from identification.fits.least_squares_problem import torque_range
from identification.residuals.correlation import (
    additional_basis,
    orthogonal_part,
    orthonormal_basis,
    partial_correlation,
    residual_noise,
    stack_residuals,
)
from identification.residuals.partial_correlations import SignalCorrelation, Signatures, signatures
from identification.residuals.residual_signals import (
    RESIDUAL_SIGNALS,
    correlation_meaning_text,
    effects_with_signature,
    motion_and_model_torque,
)
from identification.selection.trial import model_of
from reference_rig import RigTyre, make_recording
from rig_recordings import as_read
from symbolic import EFFECTS, Effect, InvalidInputError, ResidualSignature
from tests.identification.factories import first_order, read_campaign, recording, with_torque

CONSTANT, ANGLE, RATE = "a constant of each recording", "the angle", "the yaw rate"
DIRECTION = "the direction of turning"
SPEED = "the direction of friction times log speed"
SIZE, DELAY = "the magnitude of the torque", "the rate of the torque"

GROWS = ("rate_friction", "frictional_creep", "asymmetric_friction", "friction_drift")
FALLS, ZERO = ("stribeck", "sensor_delay"), ("torque_offset", "pretwist", "tared_pretwist")
LENGTH = ("load_dependent_friction", "contact_length")
POINTED_AT: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    CONSTANT: (ZERO, ZERO),
    ANGLE: (
        ("steering_return", "viscoelastic_relaxation", "frictional_creep", "pressure_skew"),
        ("carcass_torsion", "pressure_shape", "pressure_skew", "patch_width"),
    ),
    RATE: (("contact_damping", "rate_friction", "frictional_creep"), FALLS),
    DIRECTION: (("bearing_friction", "rate_friction"), FALLS),
    SPEED: (("rate_friction", "frictional_creep"), ("stribeck",)),
    "the load": (("contact_length",), ("contact_length",)),
    "the torque times the load": (LENGTH, LENGTH),
    SIZE: (("asymmetric_friction",), ("asymmetric_friction",)),
    "the torque near zero": (("backlash",), ()),
    "the signed angle since the last reversal": (GROWS, FALLS),
    "the signed time since the last reversal": (GROWS, FALLS),
    "time": (("pretwist", "zero_drift"), ("pretwist", "zero_drift")),
    "the torque times the time": (("friction_drift",), ("friction_drift",)),
    DELAY: (
        ("sensor_delay", "carcass_torsion", "pressure_shape"),
        ("viscoelastic_relaxation", "frictional_creep", "contact_damping"),
    ),
    "the initial twist that remains": (
        ("pretwist", "tared_pretwist"),
        ("pretwist", "tared_pretwist"),
    ),
}
"""Effects for a correlation above and below zero."""


@pytest.fixture(scope="module")
def recordings() -> list[Recording]:
    """Two recordings, the second shorter and of another range."""
    made = [
        make_recording(41, bristles=300, noise=0.0, name="long"),
        make_recording(43, bristles=300, noise=0.0, duration=9.0, load=300.0, name="short"),
    ]
    return [as_read(recording, RigTyre()) for recording in made]


def with_residual(
    recordings: list[Recording], residual: Callable[[Recording], np.ndarray], level: float = 0.004
) -> tuple[dict[str, np.ndarray], list[Recording]]:
    """Recordings whose measured torque is that of the model less a residual."""
    residuals = {r.name: level * torque_range(r) * residual(r) for r in recordings}
    return residuals, [with_torque(r, r.M_z - residuals[r.name]) for r in recordings]


def looked(name: str | None, seed: int) -> Signatures:
    """What the rig's residual follows after a fit of the declared structure."""
    _, made = read_campaign(name, seed, recordings=2)
    fitted = fit(model_of(()), made)
    return signatures(fitted.residuals, made, [fitted])


def named(found: Signatures, signal: str) -> SignalCorrelation:
    return next(s for s in found.signatures if s.signal == signal)


@pytest.mark.long
def test_white_noise_keeps_within_its_bands(recordings: list[Recording]) -> None:
    outside, quiet, within = np.zeros(len(RESIDUAL_SIGNALS)), 0, []
    for seed in range(100):
        rng = np.random.default_rng([seed, 11])
        noise = with_residual(recordings, lambda r, rng=rng: rng.standard_normal(r.t.size))
        found = signatures(*noise)
        outside += [s.is_significant for s in found.signatures]
        quiet += found.summary_paragraph == "The residual is noise: it follows none of the signals."
        known = found.autocorrelation
        within.append(float(np.mean(np.abs(known.values) < known.band)))

    assert (outside <= 3).all(), dict(zip([s.name for s in RESIDUAL_SIGNALS], outside, strict=True))
    assert outside.sum() > 0
    assert quiet >= 99
    assert np.mean(within) == pytest.approx(0.99, abs=0.004)


TRIALS = 400
"""Three standard errors of a share of 1 % are 1.5 %."""
MOST = 0.025


def drawn(recordings: list[Recording], memory: float, *, own: bool) -> np.ndarray:
    """Size of the correlation of independent series in many trials, and its band, shape (2, trials)."""
    found = []
    for seed in range(TRIALS):
        rng = np.random.default_rng([seed, 13])
        residuals = {r.name: first_order(memory, r.t.size, rng) for r in recordings}
        for residual in residuals.values():
            residual[rng.random(residual.size) < 0.2] = np.nan
            residual[300:400] = np.nan
        rows = stack_residuals(residuals, recordings)
        signal = rows.signal_columns([first_order(memory, r.t.size, rng) for r in recordings])
        columns = signal if own else signal.sum(axis=1, keepdims=True)
        found.append(
            partial_correlation(
                columns, orthonormal_basis(rows.indicator_columns()), residual_noise(rows)
            )[:2]
        )
    return np.abs(found).T


@pytest.mark.parametrize("own", [pytest.param(False, marks=pytest.mark.long), True])
def test_the_band_holds_for_several_columns_and_holes(recordings: list[Recording], own: bool) -> None:
    """The oracle is simulation: of independent series, one in a hundred leaves the band."""
    values, bands = drawn(recordings, 0.95, own=own)

    assert np.mean(values > bands) <= MOST


@pytest.mark.parametrize(
    "memory", [0.98, *(pytest.param(m, marks=pytest.mark.long) for m in (0.9, 0.97))]
)
def test_the_band_of_a_constant(recordings: list[Recording], memory: float) -> None:
    outside = 0
    for seed in range(TRIALS):
        rng = np.random.default_rng([seed, 18])
        left = {r.name: first_order(memory, r.t.size, rng) for r in recordings}
        rows = stack_residuals(left, recordings)
        noise = residual_noise(rows)
        none = np.zeros((rows.residual.size, 0))
        value, band, _ = partial_correlation(
            rows.indicator_columns(), none, noise, noise.degrees_of_freedom
        )
        outside += abs(value) > band

    assert outside / TRIALS <= MOST


def test_autocorrelation_of_a_known_process(recordings: list[Recording]) -> None:
    rng = np.random.default_rng(14)
    long = [make_long(r) for r in recordings]
    found = signatures(*with_residual(long, lambda r: first_order(0.9, r.t.size, rng)))
    known = found.autocorrelation

    assert known.lags[:10] == pytest.approx(0.01 * np.arange(1, 11))
    assert known.values[:10] == pytest.approx(0.9 ** np.arange(1, 11), abs=0.06)
    assert 0.1 < known.memory < 0.6
    assert "correlated over" in found.summary_paragraph or found.followed


def make_long(recording: Recording) -> Recording:
    """The recording four times over, to and fro."""
    arrays = {}
    for name in ("psi", "psi_dot", "M_z", "F_N"):
        there = getattr(recording, name)
        arrays[name] = np.concatenate([there, there[::-1]] * 2)
    return replace(recording, t=0.01 * np.arange(arrays["psi"].size), psi_recorded=None, **arrays)


@pytest.mark.parametrize("number", range(len(RESIDUAL_SIGNALS)), ids=[s.name for s in RESIDUAL_SIGNALS])
def test_every_signal_is_recognised(recordings: list[Recording], number: int) -> None:
    signal, rng = RESIDUAL_SIGNALS[number], np.random.default_rng(15)

    shapes = {r.name: signal.of(motion_and_model_torque(r, np.zeros(r.t.size))) for r in recordings}
    if signal.centred:
        shapes = {name: shape - shape.mean() for name, shape in shapes.items()}
    largest = max(np.abs(shape).max() for shape in shapes.values())
    noise = with_residual(
        recordings, lambda r: shapes[r.name] / largest + 0.02 * rng.standard_normal(r.t.size), level=0.02
    )
    found = signatures(*noise)

    own = named(found, signal.name)
    assert own.is_significant or own.band > 0.9
    assert abs(own.correlation) > 0.9


def test_slope_and_size_are_those_planted(recordings: list[Recording]) -> None:
    residuals = {r.name: 0.7 * r.psi for r in recordings}
    made = [with_torque(r, r.M_z - residuals[r.name]) for r in recordings]
    found = named(signatures(residuals, made), ANGLE)

    assert found.slope == pytest.approx(0.7, rel=1e-9)
    assert found.correlation == pytest.approx(1)
    assert (found.unit, found.effects[0]) == ("rad", "steering_return")


@pytest.mark.parametrize(
    ("effect", "signal", "sign"),
    [
        pytest.param("steering_return", ANGLE, 1, marks=pytest.mark.long),
        pytest.param("carcass_torsion", ANGLE, -1, marks=pytest.mark.long),
        pytest.param("pressure_skew", ANGLE, -1, marks=pytest.mark.long),
        ("contact_damping", RATE, 1),
        pytest.param("bearing_friction", DIRECTION, 1, marks=pytest.mark.long),
        ("stribeck", SPEED, -1),
        ("sensor_delay", DELAY, 1),
        pytest.param("viscoelastic_relaxation", DELAY, -1, marks=pytest.mark.long),
        pytest.param("torque_offset", CONSTANT, 1, marks=pytest.mark.long),
        ("asymmetric_friction", SIZE, 1),
    ],
)
def test_what_the_rig_plants_stands_out(effect: str, signal: str, sign: int) -> None:
    found = looked(effect, 4)
    first = found.followed[0]

    assert (first.signal, np.sign(first.correlation)) == (signal, sign)
    assert effect in first.effects
    assert found.summary_paragraph.startswith(f"The residual follows {signal} (")


def test_a_cause_is_usual_and_what_was_tried_or_overdone_is_named() -> None:
    by_name = {signal.name: signal for signal in RESIDUAL_SIGNALS}
    every, creep = tuple(EFFECTS.values()), (EFFECTS["frictional_creep"],)
    rate, direction = by_name[RATE], by_name[DIRECTION]
    kingpin = "usually dry friction in the kingpin or the sensor's mount"
    assert correlation_meaning_text(direction, 0.5, every, ()) == kingpin
    tried = "(tried, not added: bearing friction and rate friction)"
    assert correlation_meaning_text(direction, 0.5, every, creep) == f"{kingpin} {tried}"
    only = (EFFECTS["bearing_friction"],)
    assert correlation_meaning_text(direction, 0.5, (), creep) == kingpin, "what no search tried"
    assert correlation_meaning_text(direction, 0.5, only, only) == kingpin, "what the model has"
    # Friction that grows with speed was added, and the residual says that it falls.
    assert (
        correlation_meaning_text(rate, -0.5, every, creep) == "frictional creep may be too strong there"
    )
    assert correlation_meaning_text(rate, 0.5, every, creep).startswith("usually viscous damping")
    # Of either sign, or of each recording's own, nothing is overdone.
    either = (EFFECTS["asymmetric_friction"],)
    assert correlation_meaning_text(by_name[SIZE], -0.5, (), either).startswith(
        "usually friction differs"
    )


@pytest.mark.parametrize(
    ("missing", "reading"),
    [
        (None, "The residual is noise: it follows none of the signals."),
        ("slide_oscillation", "follows none of the signals significantly"),
    ],
)
def test_what_no_signal_shows(missing: str | None, reading: str) -> None:
    found = looked(missing, 3)

    assert found.followed == ()
    assert reading in found.summary_paragraph
    assert missing or found.autocorrelation.memory < 0.1


def test_the_fit_hides_what_it_has_absorbed() -> None:
    _, made = read_campaign("steering_return", 4, recordings=2)
    fitted = fit(model_of(()), made)
    with_it = named(signatures(fitted.residuals, made, [fitted]), ANGLE)
    without_it = named(signatures(fitted.residuals, made), ANGLE)

    assert with_it.correlation > 0.9
    assert abs(without_it.correlation) < 0.6


def test_a_direction_that_was_fitted_tells_nothing() -> None:
    _, made = read_campaign("torque_offset", 4, recordings=2)
    fitted = fit(model_of([EFFECTS["torque_offset"]]), made)
    found = named(signatures(fitted.residuals, made, [fitted]), CONSTANT)

    assert (found.correlation, found.band) == (0.0, 1.0)


def test_a_perfect_model_leaves_nothing(recordings: list[Recording]) -> None:
    found = signatures({r.name: np.zeros(r.t.size) for r in recordings}, recordings)
    content = json.loads(json.dumps(found.to_dict(), allow_nan=False))

    assert found.rms == 0
    assert found.followed == ()
    assert set(content) == {"rms", "autocorrelation", "signatures", "followed", "reading"}
    assert [s["signal"] for s in content["signatures"]] == [s.name for s in RESIDUAL_SIGNALS]


def test_every_effect_is_pointed_at_by_a_signal() -> None:
    names = {n for row in POINTED_AT.values() for effects in row for n in effects}

    assert names == {name for name, effect in EFFECTS.items() if not effect.flexible}
    declared = {
        signal.name: tuple(effects_with_signature(signal, sign, EFFECTS.values()) for sign in (1, -1))
        for signal in RESIDUAL_SIGNALS
    }
    assert declared == POINTED_AT
    assert list(declared) == list(POINTED_AT)


def test_an_effect_of_the_users_own_is_pointed_at(recordings: list[Recording]) -> None:
    residuals, made = with_residual(recordings, lambda r: r.psi**3 / np.abs(r.psi).max() ** 3)
    own = Effect(
        name="own",
        summary="mine",
        parameters=(),
        signatures=(ResidualSignature(ANGLE, sign=1, rank=9), ResidualSignature(RATE, sign=-1)),
    )
    found = signatures(residuals, made, effects=[EFFECTS["steering_return"], own])

    assert named(found, ANGLE).effects == ("steering_return", "own")
    assert named(found, SPEED).effects == ()
    wrong = replace(own, signatures=(ResidualSignature("the weather"),))
    with pytest.raises(InvalidInputError, match="'own' declares a signature of an unknown signal 'the"):
        signatures(residuals, made, effects=[wrong])


def test_reversals_are_those_of_the_angle() -> None:
    t = 0.01 * np.arange(1200)
    psi = 0.2 * np.sin(t) + 4e-5 * np.random.default_rng(17).standard_normal(t.size)
    motion = motion_and_model_torque(recording(psi=psi), np.zeros(t.size))
    reversals = np.flatnonzero(np.diff(motion.heading) != 0)

    assert t[reversals[-3:]] == pytest.approx([3 * np.pi / 2, 5 * np.pi / 2, 7 * np.pi / 2], abs=0.05)
    assert motion.travel[reversals[-1]] == pytest.approx(0.4, abs=1e-3)
    assert motion.elapsed[reversals[-1]] == pytest.approx(np.pi, abs=0.07)


def test_turning_back_by_a_little_is_a_reversal() -> None:
    """By 3 mrad, far more than a step of the encoder."""
    t = 0.01 * np.arange(600)
    psi = np.interp(t, [0, 2, 2.5, 6], [0, 0.2, 0.197, 0.4])
    motion = motion_and_model_torque(recording(psi=psi), np.zeros(t.size))

    assert motion.heading[[150, 225, 400]].tolist() == [1, -1, 1]
    assert motion.elapsed[240] == pytest.approx(0.4, abs=0.02)


def test_a_wheel_at_a_tenth_of_its_rate_is_turning(recordings: list[Recording]) -> None:
    motion = motion_and_model_torque(recordings[0], np.zeros(recordings[0].t.size))
    size = np.sqrt(np.mean(motion.psi_dot**2))
    slow = replace(motion, psi_dot=np.array([0.1, -0.1, 0.01, 1.0]) * size)
    slow = replace(slow, psi_dot=slow.psi_dot / np.sqrt(np.mean(slow.psi_dot**2)))

    assert np.sign(slow.direction).tolist() == [1, -1, 1, 1]
    assert np.abs(slow.direction[:2]) == pytest.approx(0.97, abs=0.02)


def test_three_signals_are_followed_where_three_are_planted(recordings: list[Recording]) -> None:
    rng = np.random.default_rng(19)

    def planted(r: Recording) -> np.ndarray:
        motion = 3 * r.psi / np.std(r.psi) + 2 * np.tanh(r.psi_dot / 0.01)
        return motion + (r.F_N - r.F_N.mean()) / np.std(r.F_N) + 0.2 * rng.standard_normal(r.t.size)

    found = signatures(*with_residual(recordings, planted, level=0.01))

    assert {s.signal for s in found.followed} == {ANGLE, DIRECTION, "the load"}
    content = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert [s["signal"] for s in content["followed"]] == [s.signal for s in found.followed]
    assert content["reading"] == found.summary_paragraph


def test_the_band_of_a_constant_allows_for_few_low_frequencies(recordings: list[Recording]) -> None:
    rng = np.random.default_rng(20)
    residuals, made = with_residual(recordings, lambda r: first_order(0.97, r.t.size, rng))
    rows = stack_residuals(residuals, made)
    noise = residual_noise(rows)
    none = np.zeros((rows.residual.size, 0))
    _, band, _ = partial_correlation(rows.indicator_columns(), none, noise, noise.degrees_of_freedom)

    assert named(signatures(residuals, made), CONSTANT).band == pytest.approx(band)


DIRECTIONS = np.random.default_rng(5).standard_normal((400, 3))


def test_only_what_is_new_is_new_directions() -> None:
    absorbed = orthonormal_basis(DIRECTIONS[:, :2])
    new = additional_basis(DIRECTIONS, absorbed)

    assert new.shape == (400, 1)
    np.testing.assert_allclose(absorbed.T @ new, 0, atol=1e-14)
    np.testing.assert_allclose(orthogonal_part(DIRECTIONS, np.hstack([absorbed, new])), 0, atol=1e-12)
    absorbed = orthonormal_basis(DIRECTIONS)
    assert np.any(orthogonal_part(DIRECTIONS @ np.ones((3, 2)), absorbed) != 0)
    assert additional_basis(DIRECTIONS @ np.ones((3, 2)), absorbed).shape == (400, 0)
