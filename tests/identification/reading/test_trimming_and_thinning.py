"""Fewer samples of long recordings: the reversals stay, and so does the answer."""

from dataclasses import replace

import numpy as np
import pytest

from identification import Recording
from identification.reading.trimming_and_thinning import thin_recordings
from tests.identification.factories import recording


def recorded(psi: np.ndarray, M_z: np.ndarray) -> Recording:
    one = recording("long", psi=psi, period=1e-3)
    return replace(one, psi_recorded=psi < np.inf, M_z=M_z, F_N=400 + one.t, M=2 * M_z)


def test_what_is_short_stays_as_it_is() -> None:
    short = recorded(np.sin(np.arange(200.0)), np.arange(200.0))

    kept, line = thin_recordings([short, short], most=400)
    assert kept == [short, short]
    assert line is None


def test_every_reversal_is_kept_and_no_noise_of_the_encoder() -> None:
    rng = np.random.default_rng(5)
    turns = np.cumsum(rng.uniform(0.05, 0.2, 40) * np.resize([1, -1], 40))
    lengths = rng.integers(40, 90, 39)
    # Straight from turn to turn, each turn a sample; one step of the encoder up and down between them.
    psi = np.concatenate([np.linspace(a, b, n, endpoint=False) for a, b, n in
                          zip(turns[:-1], turns[1:], lengths, strict=True)])  # fmt: skip
    corners = np.cumsum(lengths)[:-1]
    noisy = psi.copy()
    noisy[::3] += 1e-5
    noisy[corners] = psi[corners] + 2e-5 * np.sign(psi[corners] - psi[corners - 1])
    long = recorded(noisy, np.arange(float(psi.size)))

    (kept,), line = thin_recordings([long], most=psi.size // 20)
    # Room for the corners, where the turning begins, and the ends.
    apart = -(-psi.size // (psi.size // 20 - (corners.size + 1) - 3))
    assert np.isin(corners * 1e-3, kept.t).all()
    assert kept.t.size <= psi.size // 20
    assert (kept.t[0], kept.t[-1]) == (long.t[0], long.t[-1])
    for name in ("psi", "psi_dot", "M_z", "F_N", "M"):
        at = np.round(kept.t / 1e-3).astype(int)
        np.testing.assert_array_equal(getattr(kept, name), getattr(long, name)[at])
    assert kept.psi_recorded is not None
    assert kept.psi_recorded.size == kept.t.size
    assert line == (
        f"the recordings have {psi.size:,} samples, more than the {psi.size // 20:,} that a diagnosis"
        f" takes: of every {apart} in a row one is used, and every reversal, so {apart} ms apart instead"
        " of 1 ms"
    )


@pytest.mark.parametrize("every", [7, 10])
def test_a_sparse_torque_is_not_missed(every: int) -> None:
    torque = np.full(1000, np.nan)
    torque[3::every] = 1.0
    long = recorded(np.linspace(0, 1, 1000), torque)

    (kept,), _ = thin_recordings([long], most=104)
    assert np.isfinite(kept.M_z).sum() == 100


def test_a_trembling_wheel_does_not_exceed_the_bound() -> None:
    # Every second sample reverses by 1.5 mrad; every fiftieth by 30 mrad.
    n = 2000
    psi = 0.75e-3 * np.resize([1.0, -1.0], n) + 0.015 * np.resize([1.0, -1.0], n // 50).repeat(50)
    long = recorded(psi, np.arange(float(n)))

    kept, line = thin_recordings([long, long], most=400)
    assert sum(r.t.size for r in kept) <= 400
    assert line is not None
    assert "every reversal of 0.002 rad or more" in line
    jumps = np.flatnonzero(np.abs(np.diff(psi)) > 0.02)
    for r in kept:
        sides = np.sign(np.interp(long.t[jumps[:-1] + 25], r.t, r.psi))
        np.testing.assert_array_equal(np.diff(sides) != 0, True)
