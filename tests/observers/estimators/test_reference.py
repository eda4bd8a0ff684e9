"""The real-time step, repeated until it settles, against IPOPT on the same window."""

from collections.abc import Callable
from math import inf
from typing import Any

import numpy as np
import pytest

from observers import AligningTorque, Mhe, SteeringTorque
from reference_rig import RigRecording, SteeringRecording
from symbolic import Model
from tests.observers.factories import CLEAN_RIG, columns_of, samples_of, sparse, states_of
from tests.observers.ipopt_window import solve_window

pytestmark = pytest.mark.usefixtures("interpreted")

Make = Callable[..., Mhe]
LONG = pytest.mark.long
SETTLED: dict[str, Any] = {"window": 20, "iterations": 15}
WALKING = {**CLEAN_RIG, "mu_walk": 0.01}


def compare(observer: Mhe, made: RigRecording | SteeringRecording, count: int, every: int) -> None:
    samples = sparse(samples_of(columns_of(made, slice(count))))
    for number, state in enumerate(states_of(observer, samples), start=1):
        if number % every:
            continue
        found = solve_window(observer, state)
        np.testing.assert_allclose(state["x"], found, rtol=0, atol=1e-8)
    assert abs(observer.estimate(state).mu - 1) > 0.1, "the comparison saw no correction"


@pytest.mark.parametrize(
    "settings",
    [
        pytest.param(WALKING, id="least squares", marks=LONG),
        pytest.param({**WALKING, "error": 0.01}, id="Huber's loss"),
        pytest.param(
            {**WALKING, "measurement_model": AligningTorque(stiffness=True)}, id="stiffness", marks=LONG
        ),
        pytest.param({**WALKING, "model": Model(discretised=True)}, id="bristles"),
        # Nothing disturbs the states: equalities hold them, to the arrival or to one another.
        pytest.param({**CLEAN_RIG, "mu_walk": 0.0, "zero_walk": 0.0}, id="nothing walks"),
        pytest.param(
            {**WALKING, "zero_std": 0.0, "zero_walk": 0.0}, id="a zero that is known", marks=LONG
        ),
    ],
)
def test_settled_equals_ipopt(mhe: Make, recording: RigRecording, settings: dict[str, Any]) -> None:
    compare(mhe(**SETTLED, **settings), recording, count=300, every=75)


@pytest.mark.long
@pytest.mark.parametrize("count", [400, pytest.param(800, marks=pytest.mark.long)])
def test_settled_equals_ipopt_with_the_steering_torque(
    mhe: Make, steered: SteeringRecording, count: int
) -> None:
    measurement_model = SteeringTorque(zero=True, stiffness=True)
    settings = {"noise": 0.005, "error": inf, "gate": inf, "mu_walk": 0.01}
    compare(
        mhe(**SETTLED, **settings, measurement_model=measurement_model),
        steered,
        count=count,
        every=200,
    )


def test_one_step_from_afar_is_not_the_minimum_yet(mhe: Make, recording: RigRecording) -> None:
    # What the comparison above would not notice if both sides stood still.
    observer = mhe(**{**SETTLED, "iterations": 1}, **WALKING)
    samples = samples_of(columns_of(recording, slice(120)))
    apart = [
        np.abs(state["x"] - solve_window(observer, state)).max()
        for state in list(states_of(observer, samples))[60::10]
    ]
    assert max(apart) > 1e-4
