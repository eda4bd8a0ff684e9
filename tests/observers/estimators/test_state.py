"""States and observers are values: not changed, copied, pickled and shared between threads at will."""

import copy
import pickle
import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np
import pytest

from observers import AligningTorque, Ekf, ObserverState, Sample, SteeringTorque, run
from observers.layout import Layout
from observers.quality.sample_screening import SCREEN
from reference_rig import RigRecording, SteeringRecording
from tests.observers.conftest import make
from tests.observers.factories import LONG, columns_of, kinds, samples_of, states_of

KINDS = kinds(marks=LONG)


@pytest.fixture
def samples(recording: RigRecording, steered: SteeringRecording) -> dict[type, list[Sample]]:
    return {
        AligningTorque: samples_of(columns_of(recording, slice(100, 250))),
        SteeringTorque: samples_of(columns_of(steered, slice(300, 450))),
    }


def last_of(observer: Any, samples: list[Sample]) -> ObserverState:
    *_, state = states_of(observer, samples)
    return state  # type: ignore[no-any-return]


@pytest.mark.parametrize(("kind", "settings"), KINDS)
def test_step_leaves_the_state_that_it_was_given(kind: Any, settings: Any, samples: Any) -> None:
    observer = make(kind, **settings)
    first, *rest = samples[type(observer.measurement_model)]
    start = observer.init(first)
    untouched = start.values.copy()
    state = last_of(observer, [first, *rest[:-1]])
    kept = state.values.copy()
    once, twice = (observer.step(state, rest[-1]) for _ in range(2))

    np.testing.assert_array_equal(once.values, twice.values)
    assert not np.shares_memory(once.values, twice.values)
    assert not np.shares_memory(once.values, state.values)
    np.testing.assert_array_equal(state.values, kept)
    np.testing.assert_array_equal(start.values, untouched)
    assert not np.array_equal(once.values, kept)


@pytest.mark.parametrize(("kind", "settings"), KINDS)
@pytest.mark.parametrize("way", ["equal", "deepcopy", "pickle"])
def test_an_equal_observer_says_the_same(kind: Any, settings: Any, way: str, samples: Any) -> None:
    observer = make(kind, **settings)
    mine = samples[type(observer.measurement_model)]
    before = last_of(observer, mine[:-1])
    other, state = {
        "equal": lambda: (make(kind, **settings), before),
        "deepcopy": lambda: copy.deepcopy((observer, before)),
        "pickle": lambda: pickle.loads(pickle.dumps((observer, before))),
    }[way]()

    assert other == observer
    assert other is not observer
    np.testing.assert_array_equal(state.values, before.values)
    assert state.layout == before.layout
    ours, theirs = other.step(state, mine[-1]), observer.step(before, mine[-1])
    np.testing.assert_array_equal(ours.values, theirs.values)


@pytest.mark.parametrize(("kind", "settings"), KINDS[:4])
def test_threads_share_an_observer(kind: Any, settings: Any, samples: Any) -> None:
    observer = make(kind, **settings)
    mine = samples[type(observer.measurement_model)]
    parts = [mine, [replace(s, F_N=0.9 * s.F_N) for s in mine]] * 2
    alone = [last_of(make(kind, **settings), part).values for part in parts[:2]] * 2
    begin = threading.Barrier(len(parts))

    def work(part: list[Sample]) -> np.ndarray:
        begin.wait()
        return last_of(observer, part).values

    with ThreadPoolExecutor(len(parts)) as threads:
        together = list(threads.map(work, parts))
    for one, other in zip(alone, together, strict=True):
        np.testing.assert_array_equal(one, other)
    assert not np.array_equal(alone[0], alone[1])


def test_threads_run_whole_recordings(recording: RigRecording) -> None:
    observer, columns = make(Ekf), columns_of(recording, slice(0, 450))
    alone = run(observer, **columns)
    with ThreadPoolExecutor(2) as threads:
        together = list(threads.map(lambda _: run(observer, **columns), range(2)))
    for made in together:
        np.testing.assert_array_equal(made.mu, alone.mu)


@pytest.mark.parametrize(("kind", "settings"), KINDS)
def test_parts_of_a_state(kind: Any, settings: Any, samples: Any) -> None:
    observer = make(kind, **settings)
    state = last_of(observer, samples[type(observer.measurement_model)][:5])
    n, window = len(observer.states), settings.get("window", 1)

    assert state.values.shape == (observer.layout.size + SCREEN.size,)
    assert state.values.dtype == np.float64
    assert state["x"].shape == ((n,) if kind is Ekf else (n, window))
    assert state["factor"].shape == (n, n)
    assert state["counts"].shape == (2,)
    sizes = [observer.screened_step.size1_in(i) for i in (0, 1)]
    assert sizes == [state.values.size, 6]
    assert observer.screened_step.name_in() == ["state", "sample", "constants"]
    assert observer.screened_step.name_out() == ["state_next", "output"]
    with pytest.raises(KeyError):
        state["no such part"]


def test_layout_joins_column_by_column() -> None:
    layout = Layout((("a", 2, 3), ("b", 2, 1), ("c", 1, 1)))
    a = np.arange(6.0).reshape(2, 3)
    joined = layout.join({"a": ca.MX(a), "b": ca.MX([7.0, 8.0]), "c": ca.MX(9.0)})
    vector = ca.evalf(joined).full().ravel()

    np.testing.assert_array_equal(vector, [0, 3, 1, 4, 2, 5, 7, 8, 9])
    np.testing.assert_array_equal(layout.part(vector, "a"), a)
    np.testing.assert_array_equal(layout.part(vector, "b"), [7.0, 8.0])
    assert layout.size == 9
    with pytest.raises(KeyError):
        layout.join({"a": ca.MX(a), "b": ca.MX([7.0, 8.0])})


def test_layout_fills_a_part_with_its_column_and_the_rest_with_zeros() -> None:
    layout = Layout((("a", 2, 3), ("b", 2, 1), ("c", 1, 1)))
    vector = ca.evalf(layout.join_missing_as_zero({"a": ca.MX([1.0, 2.0]), "c": 9.0})).full().ravel()

    np.testing.assert_array_equal(vector, [1, 2, 1, 2, 1, 2, 0, 0, 9])
