"""Any object with the members of `Method` is scored and timed, and any observer as a method."""

from dataclasses import dataclass, replace
from time import process_time

import numpy as np
import pytest

from brushgrip.comparison.error_and_calculation_time import PUBLISHED, compare_methods, summarise
from brushgrip.comparison.methods import ObserverMethod
from brushgrip.comparison.recordings_with_reference_friction import SETTLED, Case, make_case
from brushgrip.comparison.tables import comparison_dict, markdown_text
from identification import Recording
from reference_rig import Array
from symbolic import Tyre
from tests.identification.factories import recording
from tests.observers.factories import SampleRecorder

BUSY = 0.02
"""Time that the made-up method takes [s]."""
OFF = 0.25


def busy(seconds: float) -> None:
    """Keep the processor busy for so long [s]."""
    begin = process_time()
    while process_time() < begin + seconds:
        pass


@dataclass(frozen=True)
class Slow:
    """Takes its time and is always off by so much."""

    name: str = "neural network"
    works_beyond_five_zones: bool = True
    gives_deviation: bool = False

    def estimate_mu_eff(self, recording: Recording) -> Array:
        busy(BUSY)
        return np.full(recording.t.size, 1.3 + OFF)


@pytest.fixture
def case() -> Case:
    t = np.arange(1001) * 0.01
    psi = 0.3 * np.sin(t - 1) * (t > 1)
    made = recording("run", psi=psi, period=0.01, load=400.0, k=2.4e6)
    return make_case(replace(made, M_z=-8 * np.tanh(9 * psi)), None, 1.3)


def test_a_method_from_elsewhere_gets_its_row(case: Case) -> None:
    (row,) = summarise(compared := compare_methods([case], [Slow()]), [Slow()])

    assert (row.method, row.works_beyond_five_zones, row.gives_deviation) == (
        "neural network", True, False,
    )  # fmt: skip
    assert row.rmse == pytest.approx(OFF)
    assert row.spread == pytest.approx(0, abs=1e-12)
    assert row.theta == pytest.approx(BUSY / 10, rel=0.1)
    assert "| neural network | 0.250 | 0.000 | 2." in markdown_text(compared, [row])
    content = comparison_dict(compared, [row])
    assert content["recordings"][0]["scores"][0]["quantiles"] == pytest.approx([1.3 + OFF] * 5)


class Remembering(Slow):
    """Is slower in the first call, and right from the second on."""

    def estimate_mu_eff(self, recording: Recording) -> Array:
        if "called" in vars(self):
            return super().estimate_mu_eff(recording) - OFF
        vars(self)["called"] = True
        busy(9 * BUSY)
        return super().estimate_mu_eff(recording)


def test_an_observer_from_elsewhere_is_compared(case: Case) -> None:
    own = ObserverMethod(name="counting", factory=lambda *_: SampleRecorder())
    (summary,) = summarise(compare_methods([case], methods=[own]), [own])

    assert (summary.method, summary.works_beyond_five_zones, summary.gives_deviation) == (
        "counting", True, True,
    )  # fmt: skip
    assert summary.rmse == pytest.approx(case.rmse(np.arange(1.0, case.recording.t.size + 1)))


@pytest.mark.parametrize(
    ("name", "mu", "origin"),
    [
        ("fem9", 1.674, "the surface"),
        ("piros9", 1.9003, "the surface"),
        ("run", 1.2, "rig or recording"),
    ],
)
def test_where_the_reference_comes_from(case: Case, name: str, mu: float, origin: str) -> None:
    named = replace(case.recording, name=name, tyre=Tyre(k=2.4e6, mu=1.2))
    made = make_case(named, None)

    assert (made.declared, made.origin) == (mu, origin)


def test_the_first_estimate_counts_and_the_least_time(case: Case) -> None:
    ((score,),) = (one.scores for one in compare_methods([case], [Remembering()]))

    assert score.rmse == pytest.approx(OFF)
    assert score.theta == pytest.approx(BUSY / 10, rel=0.1)


def test_errors_count_from_when_the_wheel_has_turned_for_a_while(case: Case) -> None:
    first = int(np.argmax(np.abs(case.recording.psi) >= 0.02))
    mu = np.full(case.recording.t.size, 1.3)
    mu[: first + 189] = 99.0

    assert case.span.start == first
    assert SETTLED == 1.89
    assert case.rmse(mu) == 0
    mu[first + 189] = 1.3 + OFF
    assert case.rmse(mu) == pytest.approx(OFF / np.sqrt(case.settled.sum()))


def test_a_name_is_neither_html_nor_a_link(case: Case) -> None:
    odd = Slow(name="<img src=x>|[a](http://b.invalid)")
    text = markdown_text(compared := compare_methods([case], [odd]), summarise(compared, [odd]))

    assert "| &lt;img src=x&gt;/[a]\\(http://b.invalid) | " in text
    assert "<" not in text


def test_what_is_published() -> None:
    # [Györök 2022], Table 6.1, with the time of figure 5.13 as in (5.10).
    assert [(row.rmse, row.theta, row.works_beyond_five_zones) for row in PUBLISHED] == [
        (0.638, 0.525, False), (0.4794, 0.0085, True), (0.3837, 0.538, None),
    ]  # fmt: skip
