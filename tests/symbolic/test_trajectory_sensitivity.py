"""Whole recordings: the published files, and derivatives against finite differences at every kink."""

from pathlib import Path as FilePath

import casadi as ca
import numpy as np
import pytest

from reference_rig import hand_path
from symbolic import EFFECTS, InvalidInputError, Model, sensitivity_step, simulate
from tests.symbolic.oracles import (
    GEOMETRY,
    GO,
    LOAD,
    Array,
    Path,
    Tyre,
    flat,
    random_path,
    run,
    signals,
    straight,
    theta_of,
)
from tests.symbolic.test_effects import VALUES

pytestmark = pytest.mark.usefixtures("interpreted")
# Turning points, closings that meet them to the bit, rests, and a load that drops by half and returns.
CORNERS = GO * np.array([0.0, 3.0, -2.0, 1.0, 1.0, -0.5, 1.0, 1.5, -2.0, -3.0, 4.0, 3.9, 4.0])
TIE = pytest.mark.xfail(
    strict=True, reason="zones: 0.09 at one sample where both one-sided slopes are 0, at just this ratio"
)
EACH = pytest.mark.parametrize(
    "name", [pytest.param(n, marks=TIE) if n == "asymmetric_friction" else n for n in EFFECTS]
)


def kinked_signals() -> Array:
    psi = straight(*CORNERS, steps=16)
    samples = signals(psi, LOAD)
    samples[2, 70:120] *= 0.5
    return samples


def central_difference(model: Model, samples: Array, theta: Array, j: int, share: float = 1e-6) -> Array:
    h = share * max(abs(theta[j]), 1e-3)
    ends = []
    for side in (1, -1):
        moved = theta.copy()
        moved[j] += side * h
        ends.append(simulate(model, samples, moved, GEOMETRY, np.eye(len(theta))).M_z)
    return (ends[0] - ends[1]) / (2 * h)


@pytest.mark.parametrize("mu", [0.5, 1.8])
def test_published_simulations_are_met_one_sample_late(mu: float, simulation_dir: FilePath) -> None:
    file = simulation_dir / f"sim_mu_{10 * mu:02.0f}.csv"
    _, psi, psi_max, torque, e, F_N, _, _, _, true_mu = np.genfromtxt(file, delimiter=",")[1:].T
    # The columns are what they are taken for: psi_max is an earlier psi, e, F_N and mu are constant.
    assert set(true_mu) == {mu}
    assert (set(e), set(F_N)) == ({0.01}, {180.0})
    turning_points = np.unique(psi_max[psi_max != 0])
    assert np.all(np.min(np.abs(psi[:, None] - turning_points), axis=0) < 2e-3)
    path = Path(psi=psi, F_N=F_N, tyre=Tyre(a=0.04, e=e[0], k=6e4, mu=mu))

    M_z = run(Model(), path).M_z

    def rms(error: Array) -> float:
        return float(np.sqrt(np.mean(error**2)) / np.ptp(torque))

    late, now, later = rms(M_z[:-1] + torque[1:]), rms(M_z + torque), rms(M_z[:-2] + torque[2:])
    assert late <= 3e-4
    assert min(now, later) > 20 * late


@EACH
def test_derivatives_are_finite_differences_at_every_kink(name: str) -> None:
    model, samples = Model(effects=(EFFECTS[name],)), kinked_signals()
    theta = theta_of(model, flat({name: VALUES[name]}))

    exact = simulate(model, samples, theta, GEOMETRY, np.eye(len(theta))).sensitivities

    assert np.all(np.isfinite(exact))
    for j, coordinate in enumerate(model.coordinate_names):
        expected = central_difference(model, samples, theta, j)
        # A parameter that does not act, but by rounding, has no derivative to be a share of.
        size = np.max(np.abs(expected))
        size = size if size > 1e-6 else 1.0
        error = np.max(np.abs(exact[:, j] - expected)) / size
        assert error <= 2e-5, coordinate


@pytest.mark.parametrize("model", [Model(), Model(discretised=True)], ids=["zones", "bristles"])
@pytest.mark.parametrize("beside", [-1e-9, 0.0, 1e-9])
def test_derivatives_at_and_beside_a_closing_loop(model: Model, beside: float) -> None:
    corners = GO * np.array([0.0, 2.0, -1.0, 1.0, -1.0 + beside, 2.0 + beside, -2.0 + beside])
    samples, theta = signals(straight(*corners, steps=10), LOAD), theta_of(model, {})

    exact = simulate(model, samples, theta, GEOMETRY, np.eye(2)).sensitivities

    for j in range(2):
        expected = central_difference(model, samples, theta, j, share=1e-5)
        np.testing.assert_allclose(exact[:, j], expected, rtol=0, atol=1e-6 * np.max(np.abs(expected)))


@pytest.mark.parametrize("ratio", [1.19, 1.2001, 1.21])
def test_derivative_beside_the_ratio_at_which_zones_fail(ratio: float) -> None:
    model, samples = Model(effects=(EFFECTS["asymmetric_friction"],)), kinked_signals()
    theta = theta_of(model, {"asymmetric_friction.ratio": ratio})

    exact = simulate(model, samples, theta, GEOMETRY, np.eye(3)).sensitivities[:, 2]

    expected = central_difference(model, samples, theta, 2)
    np.testing.assert_allclose(exact, expected, rtol=0, atol=1e-7 * np.max(np.abs(expected)))


def by_hand() -> Array:
    """A path with rests, as a hand steers it and an encoder without steps shows it."""
    drive = hand_path(3, 8.0, rate=100.0)
    return np.vstack([drive.psi, drive.psi_dot, drive.F_N, np.full(len(drive.t), 0.01)])


# Where a delayed rest just ends, the zones beyond the last corner have no slope yet: 1.3e-4.
@pytest.mark.parametrize(
    ("discretised", "bound"), [(False, 5e-4), (True, 2e-5)], ids=["zones", "bristles"]
)
@pytest.mark.parametrize("delay", [0.03, 0.05, 0.07])
def test_derivative_in_a_delay_of_whole_samples(delay: float, discretised: bool, bound: float) -> None:
    model = Model(effects=(EFFECTS["sensor_delay"],), discretised=discretised)
    samples, theta = by_hand(), theta_of(model, {"sensor_delay.delay": delay})

    exact = simulate(model, samples, theta, GEOMETRY, np.eye(3)).sensitivities[:, 2]

    expected = central_difference(model, samples, theta, 2, share=1e-5)
    error = np.max(np.abs(exact - expected)) / np.max(np.abs(expected))
    assert error <= bound


def test_derivative_at_no_delay_is_the_mean_of_its_sides() -> None:
    model, samples, h = Model(effects=(EFFECTS["sensor_delay"],)), by_hand(), 1e-7
    theta = theta_of(model, {"sensor_delay.delay": 0.0})

    exact = simulate(model, samples, theta, GEOMETRY, np.eye(3)).sensitivities[:, 2]

    # Less than none is none, so the other side is zero; what matters is that a fit can leave.
    late = simulate(model, samples, np.array([*theta[:2], h]), GEOMETRY, np.eye(3)).M_z
    after = (late - simulate(model, samples, theta, GEOMETRY, np.eye(3)).M_z) / h
    np.testing.assert_allclose(exact, after / 2, rtol=0, atol=1e-3 * np.max(np.abs(after)))


def test_directions_are_columns_of_the_jacobian() -> None:
    path, columns = random_path(5), np.array([[1.0, 2.0, 0.0], [0.0, 1e5, 3e6]])
    plain, whole = run(Model(), path), run(Model(), path, directions=np.eye(2))

    mixed = run(Model(), path, directions=columns).sensitivities

    assert (plain.sensitivities.shape, whole.sensitivities.shape) == ((600, 0), (600, 2))
    np.testing.assert_allclose(mixed, whole.sensitivities @ columns, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(whole.M_z, plain.M_z, rtol=0, atol=1e-12)


@pytest.mark.parametrize("count", [1, 2, 99, 100, 101, 200, 250])
def test_recording_of_any_length_is_the_beginning_of_a_longer_one(count: int) -> None:
    path = random_path(7, samples=300)
    samples = signals(path.psi, path.F_N)
    theta, geometry = np.array([path.tyre.mu, path.tyre.k]), np.array([path.tyre.a, path.tyre.e])

    short = simulate(Model(), samples[:, :count], theta, geometry, np.eye(2))

    whole = simulate(Model(), samples, theta, geometry, np.eye(2))
    np.testing.assert_array_equal(short.M_z, whole.M_z[:count])
    np.testing.assert_array_equal(short.sensitivities, whole.sensitivities[:count])


def test_sensitivity_step_names_its_inputs_and_outputs() -> None:
    step = sensitivity_step(Model(corners=8), 2)

    assert step.name_in() == ["memory", "memory_sensitivity", "signals", "theta", "seeds", "geometry"]
    assert step.name_out() == ["memory_next", "memory_sensitivity_next", "M_z", "derivative"]
    assert step.size_in("memory_sensitivity") == ca.Sparsity.dense(17, 2).size()


@pytest.mark.parametrize(
    ("field", "shape"),
    [
        ("signals", (3, 10)),
        ("theta", (3,)),
        ("theta", (1, 2)),
        ("geometry", (1,)),
        ("directions", (3, 1)),
    ],
)
def test_wrong_shapes_are_refused(field: str, shape: tuple[int, ...]) -> None:
    given = {
        "signals": np.ones((4, 10)), "theta": np.ones(2),
        "geometry": np.ones(2), "directions": np.eye(2),
    }  # fmt: skip

    with pytest.raises(InvalidInputError, match=f"{field} must have leading shape"):
        simulate(Model(), **given | {field: np.ones(shape)})


def test_a_stiffness_in_place_of_one_over_it_is_refused() -> None:
    model = Model(effects=(EFFECTS["carcass_torsion"],))
    given = model.theta({"mu": 1.0, "k": 2e6, "carcass_torsion.k_t": 10.0})
    torque = simulate(model, kinked_signals(), np.array([1.0, 2e6, 0.1]), GEOMETRY).M_z

    np.testing.assert_array_equal(simulate(model, kinked_signals(), given, GEOMETRY).M_z, torque)
    with pytest.raises(InvalidInputError, match=r"at least 10 N m/rad, got .*1/k_t = 400; model\.theta"):
        simulate(model, kinked_signals(), np.array([1.0, 2e6, 400.0]), GEOMETRY)


@pytest.mark.parametrize("name", [None, "pretwist", "contact_length", "carcass_torsion", "sensor_delay"])
def test_derivatives_by_the_rig(name: str | None) -> None:
    model = Model(effects=() if name is None else (EFFECTS[name],), corners=8, bristles=20)
    values = {} if name is None else flat({name: VALUES[name]})
    theta = theta_of(model, values)
    samples, p = kinked_signals(), theta.size
    found = simulate(model, samples, theta, GEOMETRY, np.eye(p + 3)[:, [0, p, p + 1, p + 2]])

    def torque(a: float = 0.0, e: float = 0.0, load: float = 1.0) -> Array:
        changed = samples * np.array([1, 1, load, 1])[:, None]
        return simulate(model, changed, theta, GEOMETRY + np.array([a, e])).M_z

    h = 1e-7
    expected = [
        central_difference(model, samples, theta, 0),
        (torque(a=h) - torque(a=-h)) / (2 * h),
        (torque(e=h) - torque(e=-h)) / (2 * h),
        (torque(load=1 + h) - torque(load=1 - h)) / (2 * h),
    ]
    for column, reference in zip(found.sensitivities.T, expected, strict=True):
        off = np.abs(column - reference) > 2e-4 * np.abs(reference).max()
        assert off.mean() < 0.02  # a sample at a kink has a derivative from one side


def test_directions_of_the_rig_are_all_or_none() -> None:
    samples, theta = kinked_signals(), theta_of(Model(corners=8), {})
    with pytest.raises(InvalidInputError, match=r"directions must have leading shape \(2,\), or \(5,\)"):
        simulate(Model(corners=8), samples, theta, GEOMETRY, np.eye(4))
