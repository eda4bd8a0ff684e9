"""The solution of the programme of free vibrations."""

import numpy as np
import pytest

from identification.free_decay import noise_continuation
from identification.free_decay.likelihood import Programme
from identification.free_decay.noise_continuation import solve
from identification.free_decay.onset import release
from reference_rig import FOURTEEN_BIT_STEP, make_impact
from tests.identification.factories import as_decay


def programme(noise: float = 0.0) -> Programme:
    return Programme([release(as_decay(make_impact(5, noise=noise * FOURTEEN_BIT_STEP)))])


@pytest.mark.parametrize("noise", [0.0, 0.5])
def test_nothing_near_is_likelier(noise: float) -> None:
    made = programme(noise)
    found = solve(made)
    std = np.sqrt(np.diag(np.linalg.inv(found.look.hessian)))
    rng = np.random.default_rng(1)

    assert found.converged
    assert found.look.cost == made.look(found.x, found.noise).cost
    assert (
        min(
            made.look(found.x + reach * std * rng.normal(size=std.size), found.noise).cost
            for reach in (0.1, 1.0, 10.0)
            for _ in range(20)
        )
        > found.look.cost - 1e-3
    )


@pytest.mark.parametrize("changes", [(0.6, 1.0), (1.6, 4.0), (0.8, 4.0), (2.5, 1.0)])
def test_start_does_not_matter(changes: tuple[float, float], monkeypatch: pytest.MonkeyPatch) -> None:
    made = programme()
    usual, start = solve(made), made.start()
    start[:2] *= changes
    monkeypatch.setattr(made, "start", lambda: start)

    found = solve(made)

    std = np.sqrt(np.diag(np.linalg.inv(usual.look.hessian)))
    assert found.converged
    assert (np.abs(found.x - usual.x) < 0.1 * std).all()


def test_says_when_the_scale_is_not_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(noise_continuation, "_MOST_STAGES", 2)

    assert not solve(programme()).converged


def test_says_when_a_stage_does_not_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(noise_continuation, "_SLOPE", 0.0)

    assert not solve(programme()).converged


def test_a_start_that_does_not_vibrate(monkeypatch: pytest.MonkeyPatch) -> None:
    made = programme()
    start = made.start()
    start[1] = 100.0
    monkeypatch.setattr(made, "start", lambda: start)

    with pytest.raises(np.linalg.LinAlgError, match="do not depend"):
        solve(made)
