from functools import cache

import numpy as np
import pytest

from identification import Tow, TowedFriction, friction_by_towing
from reference_rig import TOWING_LOADS as LOADS
from reference_rig import Towing, make_tows
from symbolic import InvalidInputError
from tests.refusal import refused


@cache
def found(seed: int, towing: Towing) -> TowedFriction:
    return friction_by_towing([Tow(F_x=x, F_y=y, F_z=z) for x, y, z in make_tows(seed, towing, LOADS)])


@pytest.mark.parametrize(
    "towing", [Towing(), Towing(mu=1.9003, scatter=0.06), Towing(scatter=0.0, zero=3.0)]
)
def test_interval_covers_the_truth(towing: Towing) -> None:
    runs = [found(seed, towing) for seed in range(300)]
    inside = [low <= towing.mu <= high for low, high in (run.interval() for run in runs)]
    scores = [(run.mu.value - towing.mu) / (run.mu.std or 0.0) for run in runs]

    assert 0.92 <= np.mean(inside) <= 0.98
    assert abs(np.mean(scores)) < 0.25
    # Nor is the deviation merely large: Student's t of 9 degrees of freedom spreads by 1.13.
    assert 0.85 < np.std(scores) < 1.3


def test_exact_forces_give_exact_friction() -> None:
    clean = Towing(scatter=0.0, zero=0.0, judder=0.0, noise=0.0)
    made = found(1, clean)

    assert made.mu.value == pytest.approx(clean.mu, rel=1e-12)
    assert made.mu.std == pytest.approx(0.0, abs=1e-12)
    assert made.offset.value == pytest.approx(0.0, abs=1e-10)


def test_an_offset_is_seen_and_no_offset_rarely() -> None:
    sticky = Towing(adhesion=8.0)
    runs = [found(seed, sticky) for seed in range(100)]

    assert np.mean([run.offset.value for run in runs]) == pytest.approx(8.0, abs=0.5)
    assert np.mean([run.mu_with_offset.value for run in runs]) == pytest.approx(sticky.mu, rel=0.01)
    assert np.mean([run.mu.value for run in runs]) > 1.05 * sticky.mu
    assert np.mean([run.proportional for run in runs]) < 0.2
    assert np.mean([found(seed, Towing()).proportional for seed in range(300)]) > 0.91


def test_noise_makes_no_force() -> None:
    noisy = Towing(mu=0.05, scatter=0.0, zero=0.0, judder=0.0, noise=10.0, duration=8.0)
    rows = make_tows(3, noisy, LOADS)
    by_sample = np.array([np.hypot(x, y).mean() for x, y, _ in rows])
    loads = np.array(LOADS)

    assert found(3, noisy).mu.value == pytest.approx(0.05, rel=0.1)
    assert by_sample @ loads / (loads @ loads) > 2 * 0.05


@pytest.mark.parametrize(
    ("tows", "message"),
    [
        ([(1.0, 0.0, 10.0)] * 3, "at least 4 tows, got 3"),
        ([(1.0, 0.0, 10.0)] * 4, "loads must differ"),
        ([(1.0, 0.0, 10.0), (1.0, 0.0, -20.0), (1, 0, 30), (1, 0, 40)], "tow 2: F_z must be positive"),
        ([(1.0, 0.0, 10.0), (1.0, float("nan"), 20.0), (1, 0, 30), (1, 0, 40)], "tow 2: forces must"),
    ],
)
def test_bad_tows(tows: list[tuple[float, float, float]], message: str) -> None:
    channels = [Tow(F_x=np.full(5, x), F_y=np.full(5, y), F_z=np.full(5, z)) for x, y, z in tows]
    with pytest.raises(InvalidInputError, match=message):
        friction_by_towing(channels)


def test_channels_have_one_length_and_a_probability_lies_between_0_and_1() -> None:
    tow = Tow(F_x=np.ones(5), F_y=np.ones(4), F_z=np.ones(5))
    assert "tow 1: F_x, F_y and F_z must have the same shape" in refused(friction_by_towing, [tow] * 4)
    assert "probability must lie between 0 and 1" in refused(found(1, Towing()).interval, 1.0)
