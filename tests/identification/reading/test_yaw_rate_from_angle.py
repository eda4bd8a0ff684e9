"""The rate of an angle, and a measured one, which has its unit and sign or is refused with the map."""

from functools import partial
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import savgol_filter

from identification import read_recording, smoothed_rate
from symbolic import Rig, Tyre
from tests.columns import write_columns
from tests.refusal import fault_of

RIG = (Rig(a=0.045, e=0.009), Tyre(k=2.4e6))
T = 0.01 * np.arange(800)
PSI = 0.3 * np.sin(1.2 * T) + 0.1 * np.sin(3 * T)
RATE = 0.36 * np.cos(1.2 * T) + 0.3 * np.cos(3 * T)
RNG = np.random.default_rng(4)

read = partial(read_recording, rig=RIG)


def write(path: Path, psi: np.ndarray, rate: np.ndarray, rate_name: str = "psi_dot") -> Path:
    columns = {"t": T, "psi": psi, rate_name: rate, "M_z": -3 * np.cos(4 * T), "F_N": 400 + 0 * T}
    return write_columns(path / "run.csv", columns)


@pytest.mark.parametrize(
    ("psi", "rate", "scale", "named"),
    [
        (PSI, np.degrees(RATE), "57.3", "psi_dot=psi_dot:deg/s"),
        (PSI, -RATE, "-1", "psi_dot=-psi_dot"),
        (PSI, -np.degrees(RATE), "-57.3", "psi_dot=-psi_dot:deg/s"),
        (PSI, RATE * 30 / np.pi, "9.55", "psi_dot=psi_dot:rpm"),
        (np.degrees(PSI), RATE, "0.0175", "psi=psi:deg"),
        (PSI, 14.8 * RATE, "14.8", "psi_dot=0.0676*psi_dot"),
    ],
)
def test_another_unit_or_sign_is_refused_with_the_map_that_mends_it(
    tmp_path: Path, psi: np.ndarray, rate: np.ndarray, scale: str, named: str
) -> None:
    path = write(tmp_path, psi, rate + 1e-3 * np.std(rate) * RNG.standard_normal(T.size))
    message = fault_of(read, path)
    assert message.startswith(f"psi_dot is {scale} times")
    assert message.replace("'", "").endswith(f": --map {named}")

    mended = read_recording(path, RIG, signals=named)
    assert np.corrcoef(mended.psi_dot, np.gradient(mended.psi, T))[0, 1] > 0.95
    assert np.std(mended.psi_dot) == pytest.approx(np.std(RATE), rel=0.02)


def test_a_unit_that_the_file_states_is_doubted_too(tmp_path: Path) -> None:
    message = fault_of(read, write(tmp_path, PSI, RATE, "psi_dot [deg/s]"))
    assert message.startswith("psi_dot is 0.0175 times the derivative of psi, expected 0.8 to 1.25;")
    assert "psi_dot [deg/s]:rad/s" in message or "psi_dot:rad/s" in message


@pytest.mark.parametrize(
    ("psi", "rate"),
    [
        (PSI, RATE + 1.0 * RNG.standard_normal(T.size)),
        (PSI + 0.01 * RNG.standard_normal(T.size), RATE),
        (np.round(PSI / 0.02) * 0.02, RATE),
        (PSI, np.interp(T - 0.08, T, RATE)),
        (PSI, RATE + 0.1),
        (PSI, np.where(T < 4, np.nan, RATE)),
        (np.where(abs(T - 4) < 1, np.nan, PSI), RATE),
        (0.001 * PSI, -0.001 * RATE),
        (0.001 * RNG.standard_normal(T.size), 57 * np.sin(T)),
    ],
    ids=["noise", "noisy angle", "steps", "delay", "offset", "gap", "angle gap", "still", "noise alone"],
)
def test_what_noise_delay_offset_and_gaps_make_of_a_rate_is_read(
    tmp_path: Path, psi: np.ndarray, rate: np.ndarray
) -> None:
    for causal in (False, True):
        assert read(write(tmp_path, psi, rate), causal=causal).psi_dot_recorded


def test_is_savitzky_golay_where_sampling_is_uniform() -> None:
    # So long that it is worked through in blocks.
    t = np.arange(20_000) * 0.01
    psi = np.random.default_rng(0).normal(size=t.size)

    expected = savgol_filter(psi, 11, 2, deriv=1, delta=0.01)
    np.testing.assert_allclose(smoothed_rate(t, psi), expected, atol=1e-8)


@pytest.mark.parametrize("n", [3, 5, 10, 500])
def test_a_parabola_is_exact_on_any_grid(n: int) -> None:
    t = np.cumsum(np.random.default_rng(n).uniform(0.002, 0.03, n))
    psi = 0.3 - 2 * t + 5 * t**2

    np.testing.assert_allclose(smoothed_rate(t, psi), -2 + 10 * t, atol=1e-8)


def test_a_pause_of_the_clock_does_not_leak() -> None:
    t = np.concatenate([np.arange(100) * 0.01, 60 + np.arange(100) * 0.01])
    psi = np.where(t < 30, 0.2 * t, 5.0 - 0.1 * (t - 60))
    rate = smoothed_rate(t, psi)

    np.testing.assert_allclose(rate[:90], 0.2, atol=1e-6)
    np.testing.assert_allclose(rate[110:], -0.1, atol=1e-6)
    np.testing.assert_allclose(rate[90:100], 0.2, atol=0.01)
    np.testing.assert_allclose(rate[100:110], -0.1, atol=0.01)
