"""The programme of free vibrations: what depends on what, and its derivatives."""

from dataclasses import replace

import numpy as np
import pytest

from identification.free_decay.likelihood import Programme
from identification.free_decay.onset import release
from reference_rig import FOURTEEN_BIT_STEP, make_impacts
from tests.identification.factories import as_decay


@pytest.fixture(scope="module")
def programme() -> Programme:
    """Two contacts, of which the first has two recordings."""
    made = make_impacts(4, lengths=(0.036, 0.050), impacts=2)[:3]
    return Programme([release(as_decay(recording)) for recording in made])


def test_who_depends_on_what(programme: Programme) -> None:
    assert programme.shared == 4
    assert programme.columns(0) == [0, 1, 2, 4, 5, 6]
    assert programme.columns(1) == [0, 1, 2, 7, 8, 9]
    assert programme.columns(2) == [0, 1, 3, 10, 11, 12]
    assert Programme(programme.releases, sliding=False).columns(1) == [0, 1, 5, 6, 7]


def test_derivatives(programme: Programme) -> None:
    x, noise = programme.start(), FOURTEEN_BIT_STEP
    look = programme.look(x, noise)

    def difference(direction: np.ndarray) -> float:
        ahead, behind = (programme.look(x + step * direction, noise).cost for step in (1e-6, -1e-6))
        return (ahead - behind) / 2e-6

    slopes = [difference(axis) for axis in np.eye(x.size)]
    np.testing.assert_allclose(look.gradient, slopes, rtol=1e-3, atol=1e-3 * np.abs(slopes).max())
    assert (np.linalg.eigvalsh(look.hessian) > 0).all()
    # No recording knows of another one's own unknowns.
    assert not look.hessian[4:7, 7:].any()


def test_a_wheel_that_would_not_vibrate(programme: Programme) -> None:
    x = programme.start()
    x[1] = 100.0

    assert programme.look(x, FOURTEEN_BIT_STEP).cost == np.inf


@pytest.mark.parametrize("share", [0.1, 1.0, 5.0])
def test_likeliest_noise(programme: Programme, share: float) -> None:
    swings = programme.look(programme.start(), 1.0).swings
    rng = np.random.default_rng(2)
    noisy = []
    for of, made in zip(programme.releases, swings, strict=True):
        psi = of.decay.psi.copy()
        seen = made.psi + rng.logistic(0, share * of.step, made.psi.size)
        psi[of.first : of.last] = of.step * np.round(seen / of.step)
        noisy.append(replace(of, decay=replace(of.decay, psi=psi)))

    assert Programme(noisy).likeliest_noise(swings) == pytest.approx(share * FOURTEEN_BIT_STEP, rel=0.1)
