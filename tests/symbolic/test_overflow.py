"""More zones than there are places: the figures that the exact patch degrades to."""

import numpy as np
import pytest

from symbolic import Model
from tests.symbolic.oracles import (
    GO,
    LOAD,
    TYRE,
    Path,
    constant,
    grid_torque,
    masing_torque,
    run,
    straight,
    worst,
)

pytestmark = pytest.mark.usefixtures("interpreted")


def noise_path() -> Path:
    """A slide, a long rest with 1e-3 rad of angle noise, and a turn back through all of it."""
    rng = np.random.default_rng(11)
    psi = GO * straight(0.0, 2.0, 1.2, steps=20)
    rest = psi[-1] + 1e-3 * rng.standard_normal(300)
    return constant(np.concatenate([psi, rest, GO * straight(1.2, 1.9, -2.0, steps=30)]))


def decaying_path() -> Path:
    """A decaying swing, every half swing nested one deeper, and a turn back through all of it."""
    t = np.arange(400) * 0.01
    swing = 2.5 * np.exp(-t / 2.0) * np.sin(2 * np.pi * 4 * t)
    return constant(GO * np.concatenate([swing, straight(0.0, 2.4, -2.4, steps=50)]))


def creep_path() -> Path:
    """The load grows ever faster by half while the sliding wheel creeps on: a corner every sample."""
    legs = [np.linspace(0, 3, 60), np.linspace(3, 3.3, 200), np.linspace(3.3, -3, 100)]
    psi = GO * np.concatenate(legs)
    grown = 1 + 0.5 * np.linspace(0, 1, 200) ** 2
    F_N = LOAD * np.concatenate([np.ones(60), grown, np.full(100, 1.5)])
    return Path(psi=psi, F_N=F_N, tyre=TYRE)


def test_deep_nests_lose_little_where_dropping_a_loop_loses_much() -> None:
    corners = 8
    paths = {"noise": noise_path(), "decay": decaying_path()}
    exact = {name: masing_torque(path) for name, path in paths.items()}

    model = Model(corners=corners)
    merged = {name: worst(run(model, path).M_z, exact[name]) for name, path in paths.items()}
    dropped = [
        max(worst(masing_torque(p, most=corners, drop=drop), exact[name]) for name, p in paths.items())
        for drop in ("inner", "outer")
    ]

    assert merged["noise"] <= 5e-4
    assert merged["decay"] <= 6e-3
    assert min(dropped) > 50 * max(merged.values())


def test_error_of_overflow_falls_with_the_corners() -> None:
    path = decaying_path()
    exact = masing_torque(path)

    errors = [worst(run(Model(corners=corners), path).M_z, exact) for corners in (8, 16, 32, 48)]

    assert errors == sorted(errors, reverse=True)
    assert errors[2] <= 1e-3
    assert errors[3] <= 1e-12


def test_load_that_grows_while_creeping_costs_corners_and_little_torque() -> None:
    path = creep_path()
    (reference,) = grid_torque(path)

    errors = [worst(run(Model(corners=corners), path).M_z, reference) for corners in (8, 32)]

    assert errors[0] <= 1e-2
    assert errors[1] <= 5e-5
