import numpy as np
import pytest

from identification import Recording
from identification.experiments.manoeuvre_in_recorded_range import (
    SAMPLE_PERIOD,
    RecordedRange,
    SampledManoeuvre,
    recorded_range,
)
from identification.experiments.manoeuvres import manoeuvres
from reference_rig import RigTyre, make_recording
from rig_recordings import as_read

REACH = RecordedRange(low=-0.3, high=0.4, speed=0.3, loads=(380.0, 400.0, 430.0))


@pytest.fixture(scope="module")
def library() -> tuple[SampledManoeuvre, ...]:
    return manoeuvres(REACH)


def the(library: tuple[SampledManoeuvre, ...], *words: str) -> SampledManoeuvre:
    [found] = [m for m in library if all(word in m.instruction for word in words)]
    return found


def reversals(psi: np.ndarray) -> np.ndarray:
    """Samples in whose middle the wheel turns back; where it stands, the last ones of the stop."""
    steps = np.diff(psi)
    moving = np.flatnonzero(np.abs(steps) > 1e-9)
    return moving[1:][np.diff(np.sign(steps[moving])) != 0]


def test_reach_is_what_the_recordings_used() -> None:
    made = [make_recording(seed, bristles=200, duration=6.0) for seed in (1, 2)]
    recordings: list[Recording] = [as_read(m, RigTyre()) for m in made]
    reach = recorded_range(recordings)

    assert reach.low == pytest.approx(min(m.psi.min() for m in made))
    assert reach.high == pytest.approx(max(m.psi.max() for m in made))
    true_speed = np.abs(np.concatenate([m.psi_dot_true for m in made]))
    assert np.quantile(true_speed, 0.9) < reach.speed <= 1.02 * true_speed.max()
    loads = np.concatenate([m.F_N_true for m in made])
    assert loads.min() - 1 < reach.loads[0] < reach.loads[1] < reach.loads[2] < loads.max() + 1


@pytest.mark.parametrize(
    "reach",
    [
        REACH,
        RecordedRange(low=-0.02, high=0.03, speed=0.4, loads=(300.0, 300.0, 300.0)),
        RecordedRange(low=0.1, high=1.1, speed=1.5, loads=(300.0, 400.0, 900.0)),
        RecordedRange(low=-0.1, high=0.1, speed=0.015, loads=(300.0, 310.0, 320.0)),
    ],
    ids=["hand", "small", "large", "slow"],
)
def test_manoeuvres_stay_within_any_reach(reach: RecordedRange) -> None:
    for m in manoeuvres(reach):
        assert reach.low - 1e-9 <= m.psi.min() < m.psi.max() <= reach.high + 1e-9, m.instruction
        assert np.abs(m.psi_dot).max() <= reach.speed * 1.001, m.instruction
        assert reach.loads[0] - 1e-9 <= m.F_N.min() <= m.F_N.max() <= reach.loads[2] + 1e-9
        assert 25 < m.seconds < 600


def test_arrays_belong_together(library: tuple[SampledManoeuvre, ...]) -> None:
    assert len({m.instruction for m in library}) == len(library) > 12
    for m in library:
        np.testing.assert_allclose(np.diff(m.t), SAMPLE_PERIOD)
        steps = (m.psi_dot[1:] + m.psi_dot[:-1]) / 2 * SAMPLE_PERIOD
        turned = m.psi[0] + np.append(0.0, np.cumsum(steps))
        np.testing.assert_allclose(turned, m.psi, atol=1e-3)
        assert m.psi[0] == pytest.approx(REACH.centre)
        assert m.psi_dot[0] == 0
        assert m.signals.shape == (4, m.t.size)


def test_the_wheel_stands_where_it_turns_back(library: tuple[SampledManoeuvre, ...]) -> None:
    for m in library:
        turned_back = reversals(m.psi)
        assert turned_back.size > 1
        standing = [np.abs(m.psi_dot[max(i - 4, 0) : i + 1]).min() for i in turned_back]
        assert max(standing) < 1e-3, m.instruction


def test_they_do_what_they_say(library: tuple[SampledManoeuvre, ...]) -> None:
    rests = the(library, "rests of 3 s", "load 400 N")
    standing = np.mean(np.abs(rests.psi_dot) < 1e-9)
    assert 0.4 < standing < 0.7
    assert np.mean(np.abs(the(library, "sweep between", "each time slower").psi_dot) < 0.05) > 0.4
    slowing = the(library, "slow down to 0.02")
    assert {0.02, 0.3} <= set(np.round(np.abs(slowing.psi_dot), 3))
    one_sided = the(library, "turn to and fro")
    assert one_sided.psi.min() >= REACH.centre - 1e-9
    stepped = the(library, "sweep", "load in steps", "rests")
    held = np.abs(stepped.psi_dot) < 1e-9
    assert np.ptp(stepped.F_N[held]) == pytest.approx(50)
    growing = the(library, "grows")
    size = np.abs(growing.psi - REACH.centre)
    assert size[growing.t < 3].max() < 0.1 * size.max()
    about = the(library, "oscillate by", "8 times")
    assert len(reversals(about.psi)) >= 3 * (2 * 8 - 1)
    unsteady = the(library, "sweep between −0.30 and 0.40 rad at 0.3 rad/s, load")
    np.testing.assert_array_equal(unsteady.F_N, 400.0)
