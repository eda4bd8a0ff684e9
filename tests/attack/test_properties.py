"""What holds for any recording, any gaps in it, any model file and any instant of a pickle."""

import json
import math
import pickle
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from identification import SignalMap, SignalSource, read_model, read_recording, read_signals
from identification.reading.rigfile import signals_section
from observers import Estimates, Loop, Sample, run
from symbolic import EFFECTS, InvalidInputError, Model, Tyre, effects_named, parameter_name, units_of
from tests.attack.long_runs import RIG, K, observers

pytestmark = pytest.mark.usefixtures("interpreted")

N = 40
MISSING = (math.nan, math.inf, -math.inf, 1e300)
"""What observers take for no measurement, in any channel."""
CHANNELS = ("psi", "F_N", "M_z", "psi_dot")


def turning() -> dict[str, np.ndarray]:
    t = np.arange(N) * 0.02
    psi = 0.3 * np.sin(2 * np.pi * t / 0.5)
    M_z = -7 * np.tanh(20 * psi) + 0.05 * np.cos(40 * t)
    return {"t": t, "psi": psi, "F_N": np.full(N, 400.0), "M_z": M_z, "psi_dot": np.gradient(psi, t)}


@st.composite
def gaps(draw: st.DrawFn) -> dict[str, np.ndarray]:
    """A recording in which stretches of any channel hold no measurement, or a load that is none."""
    columns = turning()
    for _ in range(draw(st.integers(0, 6))):
        name = draw(st.sampled_from(CHANNELS))
        start = draw(st.integers(0, N - 1))
        stop = start + draw(st.integers(1, N))
        odd = (*MISSING, 0.0, -5.0) if name == "F_N" else MISSING
        columns[name][start:stop] = draw(st.sampled_from(odd))
    return columns


def estimated(name: str, columns: dict[str, np.ndarray], **settings: Any) -> Estimates | None:
    """The estimates; None where the recording holds nothing to estimate from."""
    try:
        return run(observers()[name], **columns, **settings)
    except InvalidInputError as error:
        if "in at least one sample" not in str(error):
            raise
        return None


@settings(max_examples=10)
@given(gaps(), st.sampled_from(["ekf", "mhe", "root"]))
def test_estimates_stay_finite_whatever_is_missing(columns: dict[str, np.ndarray], name: str) -> None:
    whole = estimated(name, columns)
    if whole is None:
        return
    assert np.isfinite(whole.mu).all()
    if name != "root":
        assert (whole.mu_std > 0).all()
        assert np.isfinite(whole.mu_std).all()
    one_by_one = estimated(name, columns, one_by_one=True)
    assert one_by_one is not None
    np.testing.assert_allclose(one_by_one.mu, whole.mu, rtol=1e-9)


@settings(max_examples=10)
@given(gaps(), st.integers(1, N - 1), st.sampled_from(["ekf", "mhe"]))
def test_nothing_before_a_sample_depends_on_it(
    columns: dict[str, np.ndarray], first: int, name: str
) -> None:
    whole = estimated(name, columns)
    changed = {channel: values.copy() for channel, values in columns.items()}
    for channel in CHANNELS:
        changed[channel][first:] = math.nan
    early = estimated(name, changed)

    if whole is not None and early is not None:
        np.testing.assert_array_equal(early.mu[:first], whole.mu[:first])


@settings(max_examples=6)
@given(gaps(), st.integers(0, N), st.sampled_from(["ekf", "mhe", "root"]))
def test_a_loop_goes_on_where_it_is_pickled(columns: dict[str, np.ndarray], cut: int, name: str) -> None:
    rows = zip(*(columns[channel].tolist() for channel in CHANNELS), strict=True)
    samples = [
        Sample(psi=psi, F_N=F_N, dt=0.02, M_z=M_z, psi_dot=psi_dot) for psi, F_N, M_z, psi_dot in rows
    ]
    whole = Loop(observers()[name])
    expected = [whole(sample) for sample in samples]
    before = Loop(observers()[name])
    found = [before(sample) for sample in samples[:cut]]
    after = pickle.loads(pickle.dumps(before))
    found += [after(sample) for sample in samples[cut:]]

    assert list(map(repr, found)) == list(map(repr, expected))
    assert all(math.isfinite(estimate.mu) for estimate in found)


NUMBER = st.floats(-1e3, 1e3) | st.sampled_from((0.0, -0.0, 5e-324, 1e-300))


@given(
    st.lists(st.tuples(st.floats(1e-6, 10), NUMBER | st.none(), NUMBER | st.none()), min_size=10),
    st.sampled_from(("\n", "\r\n", "\r")),
)
def test_what_is_written_as_csv_is_read_as_it_was(
    rows: list[tuple[float, float | None, float | None]], end: str
) -> None:
    t = np.cumsum([step for step, _, _ in rows])
    psi = [None if psi is None or abs(psi) > 100 else psi for _, psi, _ in rows]
    M_z = [torque for _, _, torque in rows]
    columns = zip(t.tolist(), psi, M_z, [400.0] * len(rows), strict=True)
    fields = [["" if value is None else repr(value) for value in row] for row in columns]
    lines = ["t,psi,M_z,F_N", *map(",".join, fields)]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.csv"
        path.write_bytes((end.join(lines) + end).encode())
        try:
            read = read_recording(path, (RIG, Tyre(k=K)), torque_required=False)
        except InvalidInputError as error:
            # Sums of short steps may differ by less than a step; nothing but the angle may lack.
            if "nearly still" not in str(error) and any(value is not None for value in psi):
                raise
            return
    np.testing.assert_array_equal(read.t, t)
    np.testing.assert_array_equal(read.M_z, [math.nan if value is None else value for value in M_z])
    known = [i for i, value in enumerate(psi) if value is not None]
    assert [read.psi[i] for i in known] == [psi[i] for i in known]
    for i, value in enumerate(read.psi.tolist()):
        before = max((j for j in known if j <= i), default=known[0])
        after = min((j for j in known if j >= i), default=known[-1])
        low, high = sorted((psi[before] or 0.0, psi[after] or 0.0))
        assert low - 1e-9 <= value <= high + 1e-9


UNITS = {"t": "ms", "psi": "deg", "M_z": "kN m", "F_N": "lbf", "psi_dot": "rpm", "M": None}
SOURCES = {
    column: st.builds(
        SignalSource,
        channel=st.text(min_size=1, max_size=12).filter(str.strip),
        unit=st.sampled_from((unit, None)),
        factor=st.floats(1e-6, 1e6) | st.floats(-1e6, -1e-6),
    )
    for column, unit in UNITS.items()
}


@given(st.fixed_dictionaries({}, optional=SOURCES), st.text(max_size=9))
def test_a_map_in_a_rig_file_is_read_as_written(sources: dict[str, SignalSource], name: str) -> None:
    dbc = None if {"/", "\0"} & set(name) or name in ("", ".", "..") else Path("/tmp", name)
    signals = SignalMap(signals=sources, dbc=dbc)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "rig.toml"
        path.write_bytes(f"a = 1\n{signals_section(signals)}".encode())
        assert read_signals(path) == signals


@st.composite
def model_documents(draw: st.DrawFn) -> dict[str, Any]:
    """A model file with any effects and any values within their bounds."""
    effects = draw(st.lists(st.sampled_from(sorted(EFFECTS)), unique=True, max_size=4))
    model = Model(effects=effects_named(effects))
    shared, own = {}, {}
    for effect, parameter in model.parameters:
        low, high = max(parameter.lower, -1e12), min(parameter.upper, 1e12)
        values = own if parameter.scope == "recording" else shared
        values[parameter_name(effect, parameter)] = draw(st.floats(low, high))
    recordings = {draw(st.text(max_size=8)): own}
    units = units_of(model)
    return {"version": 1, "effects": effects, "shared": shared, "recordings": recordings, "units": units}


@settings(max_examples=10)
@given(model_documents())
def test_a_model_file_is_read_as_it_was_written(document: dict[str, Any]) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "model.json"
        path.write_text(json.dumps(document))
        found = read_model(path)
    ((name, own),) = document["recordings"].items()

    assert [effect.name for effect in found.model.effects] == document["effects"]
    assert found.tyre == document["shared"]
    assert found.values_for_recording(name) == {**found.values_for_estimation(tared=True), **own}
    theta = np.asarray(found.model.theta(found.values_for_recording(name))).ravel()
    assert np.isfinite(theta).all()
