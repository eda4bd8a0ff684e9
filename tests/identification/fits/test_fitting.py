import numpy as np
import pytest

from identification import Fit, FitOptions, Recording, Values, fit, initial_guess
from identification.fits.covariance import standard_deviations
from identification.fits.least_squares_problem import torque_range
from identification.fits.options import COARSE_FIT
from identification.selection.trial import ROUGH, fit_recording_parameters, thin_for_ranking
from identification.selection.trial import model_of as ranked_model
from reference_rig import Campaign
from symbolic import DECLARED, EFFECTS, Model, Parameter, effects_named, full_slide_torque
from tests.identification.factories import positions, read_campaign, with_torque
from tests.refusal import refused

Given = tuple[Campaign, list[Recording]]


def model_of(*effects: str, discretised: bool = False) -> Model:
    return Model(effects=effects_named(effects), corners=16, discretised=discretised)


@pytest.fixture(scope="module")
def declared() -> Given:
    return read_campaign(None, 1)


@pytest.fixture(scope="module")
def offset() -> Given:
    return read_campaign("torque_offset", 2)


@pytest.mark.parametrize(
    ("wrong", "fault"),
    [
        ({"tolerance": 0.0}, "tolerance must be greater than 0, got 0.0"),
        ({"tolerance": float("nan")}, "tolerance must be greater than 0, got nan"),
        ({"max_evaluations": 0}, "max_evaluations must be at least 1, got 0"),
    ],
)
def test_faults_of_the_options(wrong: dict[str, float], fault: str) -> None:
    assert refused(FitOptions, **wrong) == fault


def test_first_values(declared: Given) -> None:
    made, recordings = declared
    values = initial_guess(model_of("torque_offset", "contact_damping"), recordings)

    assert values.tyre["k"] == pytest.approx(made.nominal.k)
    assert values.tyre["contact_damping.c"] == EFFECTS["contact_damping"].parameters[0].start
    for recording, truth in zip(recordings, made.recordings, strict=True):
        assert values.own[recording.name]["mu"] == pytest.approx(truth.tyre.mu, rel=0.15)
        assert values.own[recording.name]["torque_offset.M_0"] != 0
        everything = values.of(recording)
        assert set(everything) == {"k", "mu", "contact_damping.c", "torque_offset.M_0"}


@pytest.mark.parametrize("sliding", [0.04, 0.3])
def test_the_first_friction_is_that_of_few_sliding_samples(declared: Given, sliding: float) -> None:
    recording, mu = declared[1][0], 1.2
    n = recording.t.size
    slide = mu * full_slide_torque(float(np.median(recording.F_N)), recording.rig.a)
    M_z = np.full(n, 0.1 * slide)
    M_z[: round(sliding * n)] = -slide
    M_z[-n // 100 :] = 5 * slide  # Spikes in a hundredth of the samples are above the quantile.
    values = initial_guess(model_of(), [with_torque(recording, M_z)])

    assert values.own[recording.name]["mu"] == pytest.approx(mu)


def test_a_candidate_converges_as_models_are_ranked() -> None:
    """This one takes 13 simulations of the set."""
    recordings = [thin_for_ranking(one) for one in read_campaign("rate_friction", 1, duration=6.0)[1]]
    model = ranked_model(effects_named(["carcass_torsion"]), ROUGH)

    assert fit(model, recordings, options=COARSE_FIT).converged
    assert not fit(model, recordings, options=FitOptions(tolerance=1e-3, max_evaluations=4)).converged


@pytest.mark.long
def test_what_recordings_give_is_never_fitted() -> None:
    """F_0 is the mean of the loads, brought to one length; another one is nearly another mu and k."""
    made, recordings = read_campaign("contact_length", 3)
    model = model_of("contact_length")
    fitted = fit(model, recordings)

    F_0 = fitted.values.tyre["contact_length.F_0"]
    loads = [recording.F_N.mean() * (0.045 / recording.rig.a) ** 2 for recording in recordings]
    np.testing.assert_allclose(F_0, np.prod(loads) ** (1 / len(loads)))
    assert fitted.values.tyre["contact_length.m"] == 2.0, "one half-length says nothing about it"
    given = {(None, "contact_length.F_0"), (None, "contact_length.m")}
    assert not given & {*fitted.labels}
    n = made.recordings[0].effects["contact_length"]["n"]
    assert fitted.values.tyre["contact_length.n"] == pytest.approx(n, rel=0.05)

    left_out = fit_recording_parameters(fitted, recordings[:1])
    assert left_out.values.tyre["contact_length.F_0"] == F_0, "the one of the training recordings"

    shared = fitted.values.tyre | {"contact_length.F_0": 1.1 * F_0}
    elsewhere = fit(model, recordings, Values(tyre=shared, own=fitted.values.own))
    grown = 1.1 ** -fitted.values.tyre["contact_length.n"]
    assert elsewhere.values.tyre["k"] == pytest.approx(fitted.values.tyre["k"] / grown**3, rel=0.1)
    for recording in recordings:
        name, span = recording.name, torque_range(recording)
        off = elsewhere.residuals[name] - fitted.residuals[name]
        assert np.sqrt(np.mean(off**2)) < 2e-3 * span


def test_recovers_stiffness_and_friction_as_well_as_it_says() -> None:
    apart = []
    for seed in range(4):
        made, recordings = read_campaign(None, seed)
        fitted = fit(model_of(), recordings)
        found, spread, truth = standing(fitted, made, recordings)

        assert fitted.converged
        assert fitted.labels == ((None, "k"), ("recording_a", "mu"), ("recording_b", "mu"))
        assert (spread > 1e-4 * truth).all()
        assert (spread < 3e-3 * truth).all()
        for recording in recordings:
            left = np.sqrt(np.mean(fitted.residuals[recording.name] ** 2)) / torque_range(recording)
            assert left == pytest.approx(0.004, rel=0.1)
        apart.extend((found - truth) / spread)
    assert np.abs(apart).max() < 4
    assert 0.5 < np.sqrt(np.mean(np.square(apart))) < 1.6


def standing(
    fitted: Fit, made: Campaign, recordings: list[Recording]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Values found, their deviations, and the truth, in the order of the labels; no inverse ones."""
    truths = {recording.name: recording for recording in made.recordings}
    truth = []
    for owner, name in fitted.labels:
        recording = truths[owner or made.recordings[0].name]
        effect, _, parameter = name.rpartition(".")
        values = recording.effects[effect] if effect else vars(recording.tyre)
        truth.append(values[parameter])
    return positions(fitted), standard_deviations(fitted, recordings), np.array(truth)


@pytest.mark.parametrize(
    "effect",
    [
        "contact_damping",
        pytest.param("torque_offset", marks=pytest.mark.long),
        pytest.param("sensor_delay", marks=pytest.mark.long),
        pytest.param("asymmetric_friction", marks=pytest.mark.long),
    ],
)
def test_recovers_an_effect(effect: str) -> None:
    made, recordings = read_campaign(effect, 2)
    found, spread, truth = standing(fit(model_of(effect), recordings), made, recordings)

    assert (np.abs(found - truth) < 4 * spread).all()
    assert (spread < 0.02 * np.abs(truth)).all()


@pytest.mark.long
def test_held_out_recordings_leave_shared_parameters_alone(offset: Given) -> None:
    made, (first, second) = offset
    fitted = fit(model_of("torque_offset"), [first])
    frozen = fit_recording_parameters(fitted, [second])

    assert frozen.values.tyre == fitted.values.tyre
    assert frozen.labels == ((second.name, "mu"), (second.name, "torque_offset.M_0"))
    own, truth = frozen.values.own[second.name], made.recordings[1]
    assert own["mu"] == pytest.approx(truth.tyre.mu, rel=5e-3)
    assert own["torque_offset.M_0"] == pytest.approx(truth.effects["torque_offset"]["M_0"], rel=0.02)


def test_what_is_held_stays(offset: Given) -> None:
    _, recordings = offset
    model, one = model_of("torque_offset"), recordings[0].name
    free = fit(model, recordings)
    own = {**free.values.own, one: {**free.values.own[one], "torque_offset.M_0": 0.0}}
    start = Values(tyre={"k": 1.1 * free.values.tyre["k"]}, own=own)
    fixed = (None, "k"), (one, "torque_offset.M_0")
    held = fit(model, recordings, start, FitOptions(fixed=fixed))

    assert set(free.labels) - set(held.labels) == {(None, "k"), (one, "torque_offset.M_0")}
    assert held.values.tyre["k"] == start.tyre["k"]
    assert held.values.own[one]["torque_offset.M_0"] == 0
    assert held.values.own[recordings[1].name]["torque_offset.M_0"] != 0
    assert held.jacobian.shape[1] == 3


def test_with_everything_held_nothing_is_left_to_fit(declared: Given) -> None:
    _, recordings = declared
    start = initial_guess(model_of(), recordings)
    own = [(r.name, "mu") for r in recordings]
    everything = FitOptions(free_shared=False, fixed=own)
    assert "every parameter is fixed" in refused(fit, model_of(), recordings, start, everything)


def test_missing_samples_are_left_out(declared: Given) -> None:
    _, recordings = declared
    gone = np.random.default_rng(3).random(recordings[0].t.size) < 0.3
    gone[400:500] = True
    holed = [with_torque(recordings[0], np.where(gone, np.nan, recordings[0].M_z)), recordings[1]]
    fitted = fit(model_of(), holed)
    whole = fit(model_of(), recordings)

    np.testing.assert_array_equal(np.isnan(fitted.residuals[holed[0].name]), gone)
    assert np.isfinite(fitted.residuals[holed[1].name]).all()
    assert fitted.jacobian.shape == (sum(r.t.size for r in recordings) - gone.sum(), 3)
    spread = standard_deviations(fitted, holed)
    assert fitted.values.tyre["k"] == pytest.approx(whole.values.tyre["k"], abs=3 * spread[0])
    assert np.isfinite(spread).all()


@pytest.mark.parametrize("M_z", [0.0, 3.0])
def test_a_constant_torque_is_a_fault(declared: Given, M_z: float) -> None:
    _, recordings = declared
    still = with_torque(recordings[0], np.full(recordings[0].t.size, M_z))
    assert "recording_a: M_z is constant" in refused(fit, model_of(), [still, recordings[1]])


@pytest.mark.parametrize(
    "parameter",
    [*DECLARED, *(p for effect in EFFECTS.values() for p in effect.parameters)],
    ids=lambda p: p.name,
)
def test_a_solver_at_a_bound_stays_within_it(parameter: Parameter) -> None:
    scale = 1 / parameter.scale if parameter.inverse else parameter.scale
    low, high = sorted(parameter.to_coordinate(v) / scale for v in (parameter.lower, parameter.upper))
    for end in (low, np.nextafter(low, high), np.nextafter(high, low), high):
        assert parameter.lower <= parameter.to_coordinate(float(end * scale)) <= parameter.upper
