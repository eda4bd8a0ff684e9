"""The model error of residuals whose size and autocorrelation are known."""

from dataclasses import replace

import numpy as np
import pytest

from identification import Huber, Recording
from identification.diagnosis.error_stages import error_on_unseen
from symbolic import InvalidInputError, ModelError, Rig
from tests.identification.factories import first_order, recording

PERIOD, A = 0.01, 0.04


def turned(name: str, seconds: float = 400.0, load: float = 300.0) -> Recording:
    psi = 0.2 * np.sin(np.arange(round(seconds / PERIOD)) * PERIOD)
    return recording(name, psi=psi, period=PERIOD, load=load, rig=Rig(a=A, e=0.0))


def coloured(recording: Recording, share: float, time: float, seed: int = 0) -> np.ndarray:
    """A first-order process of this standard deviation, over full slide, and time constant."""
    rng = np.random.default_rng(seed)
    return share * 0.375 * recording.F_N * A * first_order(np.exp(-PERIOD / time), recording.t.size, rng)


def error_of(residuals: dict[str, np.ndarray], recordings: list[Recording], *loss: Huber) -> ModelError:
    found = error_on_unseen(residuals, recordings, *loss)
    assert found is not None
    return found


def test_spread_and_time_of_a_first_order_error() -> None:
    one = turned("one")
    found = error_of({"one": coloured(one, 0.05, 0.2)}, [one])

    assert found.spread == pytest.approx(0.05, rel=0.1)
    # The sum of the autocorrelation ends where that is below 0.05.
    assert found.correlation_time == pytest.approx(2 * 0.2 * 0.95, rel=0.15)


@pytest.mark.parametrize(("every", "other"), [(2, 200.0), (50, 1.0)], ids=["half", "lifted"])
def test_the_load_of_every_sample_counts_unless_the_wheel_is_lifted(every: int, other: float) -> None:
    one = turned("one")
    loads = np.where(np.arange(one.t.size) % every, 400.0, other)
    residual = 0.03 * 0.375 * A * (loads if every == 2 else np.full(one.t.size, 400.0))
    found = error_of({"one": residual}, [replace(one, F_N=loads)])

    assert found.spread == pytest.approx(0.03, rel=1e-12)


def test_friction_that_walks_from_slide_to_slide() -> None:
    one = turned("one", seconds=2000.0)
    slides = np.cos(np.arange(one.t.size) * PERIOD)
    count = np.cumsum(np.diff(np.sign(slides), prepend=1.0) != 0)
    walk = 0.03 * np.sqrt(np.pi) * np.random.default_rng(4).standard_normal(count[-1] + 1)
    torque = np.clip(-3 * slides, -1, 1)
    measured = torque * np.exp(np.cumsum(walk))[count]
    measured[::7] = np.nan
    found = error_of({"one": torque - measured}, [replace(one, M_z=measured)])
    short = error_of({"s": (torque - measured)[:700]}, [replace(turned("s", 7.0), M_z=measured[:700])])

    assert found.friction_walk == pytest.approx(0.03, rel=0.05)
    assert short.friction_walk is None


def test_recordings_count_alike_and_their_times_by_their_power() -> None:
    large, small = turned("large", load=1000.0), turned("small", seconds=200.0)
    residuals = {"large": coloured(large, 0.06, 0.5, 1), "small": coloured(small, 0.02, 0.05, 2)}
    both = error_of(residuals, [large, small])
    alone = [error_of(residuals, [r]) for r in (large, small)]

    assert both.spread == pytest.approx(np.hypot(alone[0].spread, alone[1].spread) / np.sqrt(2))
    power = [a.spread**2 for a in alone]
    times = [a.correlation_time for a in alone]
    assert both.correlation_time == pytest.approx(np.average(times, weights=power))


def test_missing_samples_change_nothing() -> None:
    one = turned("one")
    residual = coloured(one, 0.05, 0.2)
    whole = error_of({"one": residual}, [one])
    gaps = residual.copy()
    gaps[1::2] = np.nan
    half = error_of({"one": gaps}, [one])

    assert half.spread == pytest.approx(whole.spread, rel=0.02)
    assert half.correlation_time == pytest.approx(whole.correlation_time, rel=0.05)


def test_outliers_count_as_in_the_fit() -> None:
    one = turned("one")
    residual = coloured(one, 0.01, 0.02)
    spiked = residual.copy()
    spiked[::500] += 5.0
    found = [error_of({"one": r}, [one], Huber(threshold=0.2)) for r in (residual, spiked)]

    assert found[1].spread < 1.5 * found[0].spread


def test_nothing_seen_is_nothing_known() -> None:
    one = turned("one", seconds=1.0)
    assert error_on_unseen({}, []) is None
    exact = error_of({"one": np.zeros(one.t.size)}, [one])
    assert (exact.spread, exact.correlation_time) == (0.0, pytest.approx(PERIOD))


@pytest.mark.parametrize("values", [(-0.1, 1.0), (0.1, 0.0), (float("nan"), 1.0), (0.1, float("inf"))])
def test_ranges(values: tuple[float, float]) -> None:
    with pytest.raises(InvalidInputError, match=r"spread|correlation_time"):
        ModelError(spread=values[0], correlation_time=values[1])
