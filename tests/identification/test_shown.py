"""What results show of themselves: a picture where it is asked for, a small table in a notebook."""

import subprocess
import sys
from collections.abc import Iterator
from dataclasses import fields, replace
from io import BytesIO
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import pyplot

from identification import Recording
from observers import Estimates, Status
from symbolic import Rig, Tyre
from tests.brushgrip.factories import make_diagnosis, make_estimates

EVIL = '<b onclick="x()">$a_b$ & \x1b[2J\udcff'


@pytest.fixture(autouse=True)
def no_figure_stays() -> Iterator[None]:
    mpl.use("Agg")
    yield
    pyplot.close("all")


@pytest.fixture
def recording() -> Recording:
    t = np.arange(50) * 0.1
    torque = -10 * np.sin(t)
    torque[3] = np.nan
    return Recording(
        name="fem1", t=t, psi=0.3 * np.sin(t), psi_dot=0.3 * np.cos(t), M_z=torque,
        F_N=np.full(50, 560.0), rig=Rig(a=0.045, e=0.009), tyre=Tyre(k=2.4e6),
    )  # fmt: skip


@pytest.fixture
def estimates() -> Estimates:
    t, status = np.arange(50) * 0.1, np.zeros(50, dtype=np.int64)
    status[[4, 7]], status[9] = int(Status.REJECTED), int(Status.HELD | Status.REJECTED)
    known, mu_std = t > 2, np.where(t > 2, 0.1, 5.0)
    return make_estimates(status, t=t, informed=known, usable=known, mu_std=mu_std)


def cells(shown: Any) -> tuple[str, dict[str, str]]:
    """Title and rows of a table, by a parser of XML; markup that is not ours is a fault."""
    table = ElementTree.fromstring(shown._repr_html_())
    assert {e.tag for e in table.iter()} == {"table", "caption", "tbody", "tr", "th", "td"}
    rows = {row[0].text or "": row[1].text or "" for row in table.iter("tr")}
    return table.findtext("caption") or "", rows


def test_a_recording_as_a_table(recording: Recording) -> None:
    title, rows = cells(replace(recording, ground="ice"))

    assert title == "Recording fem1 on ice"
    assert rows["samples"] == "50 in 4.9 s"
    assert rows["angle ψ"] == "-0.3 to 0.2999 rad"
    assert rows["aligning torque M_z"].endswith(" N m, 1 samples missing")
    assert rows["load F_N"] == "560 to 560 N"
    assert "steering torque M" not in rows


def test_estimates_as_a_table(estimates: Estimates) -> None:
    _, rows = cells(estimates)

    assert rows["friction coefficient"] == "mu 1.000 ± 0.100 at the end, informed"
    assert rows["usable"] == "from 2.1 s, 29 of 50 samples with a torque"
    assert rows["status"] == "HELD 1, REJECTED 3"
    changed = replace(estimates, status=np.where(estimates.t == 3.0, 8, estimates.status))
    usable = "on the ground since 3 s from 3 s, 29 of 50 samples with a torque"
    assert cells(changed)[1]["usable"] == usable
    none = Estimates(**{field.name: np.empty(0) for field in fields(Estimates)})
    assert "no sample" in none._repr_html_()


def test_a_diagnosis_as_a_table() -> None:
    title, rows = cells(make_diagnosis())

    assert title == "Diagnosis of 2 recordings, 3 held out"
    # Means of the factory's shares of the held-out recordings, 4.2, 4.3, 4.4 %, and 0.55 of them.
    assert rows["torque error, held out"] == "4.30 % → 2.37 % of range"
    assert rows["carcass_torsion"].startswith("k_t = 391.2 ± 4.2 N m/rad")
    assert rows["unexplained"] == "follows psi_dot <by> 0.4 & F_N"
    assert cells(make_diagnosis(found=False, unexplained=False))[1]["effects"] == "none is missing"


def test_a_diagnosis_tells_its_loads() -> None:
    """Those of every recording count, but for a lifted wheel and what is rare."""
    diagnosis = make_diagnosis(("a",), ("b",))
    assert diagnosis.basis.loads == (400.0, 400.0)
    F_N = np.full(600, 380.0)
    F_N[:200], F_N[200:210], F_N[300:400], F_N[400:410] = 0.0, np.nan, 900.0, 2000.0
    series = tuple(replace(one, F_N=F_N) if one.held_out else one for one in diagnosis.series)
    assert replace(diagnosis, series=series).basis.loads == (380.0, 900.0)
    assert replace(diagnosis, series=()).basis.loads is None


@pytest.mark.parametrize("name", [EVIL, "_hidden"])
def test_any_name_is_shown_as_it_is(recording: Recording, name: str) -> None:
    named = replace(recording, name=name, ground=name)
    title, _ = cells(named)
    legend = named.plot().get_legend()

    assert title.startswith("Recording <b onclick" if name == EVIL else "Recording _hidden on _hidden")
    assert title.isprintable()
    assert legend is not None
    assert len(legend.get_texts()) == 1
    pyplot.gcf().savefig(BytesIO(), format="svg")


def test_a_recording_draws_its_loop(recording: Recording) -> None:
    axes = recording.plot()
    again = replace(recording, name="fem2").plot(axes)
    (x, y), _ = (line.get_data() for line in axes.lines)

    assert again is axes
    np.testing.assert_array_equal(x, recording.psi)
    np.testing.assert_array_equal(y, recording.M_z)
    assert axes.get_xlabel() == "yaw angle ψ [rad]"
    assert axes.get_ylabel() == "aligning torque $M_z$ [N m]"
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["fem1", "fem2"]
    steered = replace(recording, M_z=np.full(50, np.nan), M=np.arange(50.0)).plot()
    assert steered.get_ylabel() == "steering torque $M$ [N m]"
    np.testing.assert_array_equal(steered.lines[0].get_ydata(), np.arange(50.0))


def test_estimates_draw_friction_with_its_band(estimates: Estimates) -> None:
    axes = estimates.plot()
    bold, pale = (line.get_ydata() for line in axes.lines)

    np.testing.assert_array_equal(np.isnan(bold), ~estimates.informed)
    np.testing.assert_array_equal(pale, estimates.mu)
    assert axes.get_xlabel() == "time t [s]"
    assert axes.get_ylabel() == "friction coefficient μ [1]"
    # The prior's band of ±10 is cut off, that of the informed estimate is whole.
    assert axes.get_ylim()[0] < 0.8
    assert 1.2 < axes.get_ylim()[1] < 2
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert labels == ["μ", "± 2 standard deviations"]
    # Into axes of one's own, whose limits and labels stay.
    own = pyplot.figure().add_subplot(ylim=(0, 7), ylabel="mine")
    assert replace(estimates, mu_std=np.full(50, np.nan)).plot(own, label="EKF") is own
    assert (own.get_ylim(), own.get_ylabel()) == ((0, 7), "mine")
    assert [text.get_text() for text in own.get_legend().get_texts()] == ["EKF"]


def test_a_diagnosis_draws_the_recording_of_median_error() -> None:
    diagnosis = make_diagnosis()
    axes = diagnosis.plot()
    shown = diagnosis.series[3]

    assert axes.get_title() == "held_d (held out), error 4.30 % → 2.37 % of range"
    for line, torque in zip(axes.lines, (shown.measured, shown.before, shown.after), strict=True):
        np.testing.assert_array_equal(line.get_ydata(), torque)
    assert len(axes.get_legend().get_texts()) == 3
    assert axes.get_xlabel().endswith("[rad]")
    assert axes.get_ylabel().endswith("[N m]")


@pytest.mark.long
def test_a_frame_comes_back_from_a_file_of_pandas(estimates: Estimates) -> None:
    pandas = pytest.importorskip("pandas", reason="needs brushgrip[pandas]")
    estimates.to_frame().to_csv(Path("mu.csv"))
    again = np.genfromtxt(Path("mu.csv"), delimiter=",", names=True, dtype=None, encoding="utf-8")

    assert again.dtype.names == tuple(field.name for field in fields(Estimates))
    for name in again.dtype.names:
        np.testing.assert_array_equal(again[name], getattr(estimates, name))
    frame = pandas.read_csv(Path("mu.csv"), index_col="t")
    pandas.testing.assert_frame_equal(frame, estimates.to_frame())


@pytest.mark.parametrize(
    ("imported", "absent"),
    [
        pytest.param(
            "identification.diagnosis.result_parts, identification.loop_plot, observers.estimates",
            "matplotlib", marks=pytest.mark.long,
        ),
        ("brushgrip.report.diagnosis_folder", "scipy.signal"),
    ],
)  # fmt: skip
def test_nothing_is_imported_before_it_is_needed(imported: str, absent: str) -> None:
    program = f"import sys, {imported}; print('{absent}' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)

    assert done.stdout == "False\n"


def test_a_diagnosis_is_shown_in_a_line() -> None:
    shown = "<Diagnosis of 2 recordings, 3 held out: carcass_torsion, torque_offset>"

    assert repr(make_diagnosis()) == shown
    assert repr(make_diagnosis(found=False)).endswith(": no effect>")
