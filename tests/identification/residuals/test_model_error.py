"""The model error of residuals whose size and autocorrelation are known."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from identification import Huber, Recording
from identification.residuals.model_error import model_error
from symbolic import InvalidInputError, ModelError, Rig, Tyre

PERIOD, A = 0.01, 0.04


def recording(name: str, seconds: float = 400.0, load: float = 300.0) -> Recording:
    t = np.arange(round(seconds / PERIOD)) * PERIOD
    psi = 0.2 * np.sin(t)
    rig, tyre = Rig(a=A, e=0.0), Tyre(k=2e6)
    loads = np.full(t.size, load)
    return Recording(
        name=name, t=t, psi=psi, psi_dot=0.2 * np.cos(t), M_z=-psi, F_N=loads, rig=rig, tyre=tyre
    )


def coloured(recording: Recording, share: float, time: float, seed: int = 0) -> np.ndarray:
    """A first-order process of this standard deviation, over full slide, and time constant."""
    phi = np.exp(-PERIOD / time)
    noise = np.random.default_rng(seed).normal(0, np.sqrt(1 - phi**2), recording.t.size)
    return share * 0.375 * recording.F_N * A * lfilter([1], [1, -phi], noise)


def test_spread_and_time_of_a_first_order_error() -> None:
    one = recording("one")
    found = model_error({"one": coloured(one, 0.05, 0.2)}, [one])

    assert found is not None
    assert found.spread == pytest.approx(0.05, rel=0.1)
    # The sum of the autocorrelation ends where that is below 0.05.
    assert found.correlation_time == pytest.approx(2 * 0.2 * 0.95, rel=0.15)


def test_the_load_of_every_sample_counts() -> None:
    one = recording("one")
    loads = np.where(np.arange(one.t.size) % 2, 200.0, 400.0)
    one = replace(one, F_N=loads)
    found = model_error({"one": 0.03 * 0.375 * A * loads}, [one])

    assert found is not None
    assert found.spread == pytest.approx(0.03, rel=1e-12)


def test_a_lifted_wheel_does_not_count() -> None:
    one = recording("one")
    loads = np.where(np.arange(one.t.size) % 50, 400.0, 1.0)
    found = model_error({"one": np.full(one.t.size, 0.03 * 0.375 * A * 400)}, [replace(one, F_N=loads)])

    assert found is not None
    assert found.spread == pytest.approx(0.03, rel=1e-12)


def test_recordings_count_alike_and_their_times_by_their_power() -> None:
    large, small = recording("large", load=1000.0), recording("small", seconds=200.0)
    residuals = {"large": coloured(large, 0.06, 0.5, 1), "small": coloured(small, 0.02, 0.05, 2)}
    both = model_error(residuals, [large, small])
    alone = [model_error(residuals, [r]) for r in (large, small)]

    assert both is not None
    assert alone[0] is not None
    assert alone[1] is not None
    assert both.spread == pytest.approx(np.hypot(alone[0].spread, alone[1].spread) / np.sqrt(2))
    power = [a.spread**2 for a in alone if a]
    times = [a.correlation_time for a in alone if a]
    assert both.correlation_time == pytest.approx(np.average(times, weights=power))


def test_missing_samples_change_nothing() -> None:
    one = recording("one")
    residual = coloured(one, 0.05, 0.2)
    whole = model_error({"one": residual}, [one])
    gaps = residual.copy()
    gaps[1::2] = np.nan
    half = model_error({"one": gaps}, [one])

    assert whole is not None
    assert half is not None
    assert half.spread == pytest.approx(whole.spread, rel=0.02)
    assert half.correlation_time == pytest.approx(whole.correlation_time, rel=0.05)


def test_outliers_count_as_in_the_fit() -> None:
    one = recording("one")
    residual = coloured(one, 0.01, 0.02)
    spiked = residual.copy()
    spiked[::500] += 5.0
    found = [model_error({"one": r}, [one], Huber(threshold=0.2)) for r in (residual, spiked)]

    assert found[0] is not None
    assert found[1] is not None
    assert found[1].spread < 1.5 * found[0].spread


def test_nothing_seen_is_nothing_known() -> None:
    one = recording("one", seconds=1.0)
    assert model_error({}, []) is None
    exact = model_error({"one": np.zeros(one.t.size)}, [one])
    assert exact is not None
    assert (exact.spread, exact.correlation_time) == (0.0, pytest.approx(PERIOD))


@pytest.mark.parametrize("values", [(-0.1, 1.0), (0.1, 0.0), (float("nan"), 1.0), (0.1, float("inf"))])
def test_ranges(values: tuple[float, float]) -> None:
    with pytest.raises(InvalidInputError, match=r"spread|correlation_time"):
        ModelError(spread=values[0], correlation_time=values[1])
