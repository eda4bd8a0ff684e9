import json
import math

import numpy as np
import pytest

from brushgrip.wording.formatting import (
    add_degrees_behind_radians,
    candidate_reason,
    csv_text,
    json_text,
    listed,
    percent,
    residual_structure,
    sentence,
    torque_error_text,
    value_with_std,
    worse_recordings,
)
from identification import Candidate, ParameterEstimate
from tests.brushgrip.factories import make_diagnosis


@pytest.mark.parametrize(
    ("value", "std", "unit", "text"),
    [
        (391.234, 4.2, "N m/rad", "391.2 ± 4.2 N m/rad"),
        (391.234, 42.0, "N m/rad", "391 ± 42 N m/rad"),
        (391.234, 420.0, "N m/rad", "391 ± 420 N m/rad"),
        (0.0403, 0.00017, "1", "0.04030 ± 0.00017"),
        (-0.25, 0.1, "N m", "−0.25 ± 0.10 N m"),
        (2.4312e6, 1.2e4, "N/m^2", "(2.431 ± 0.012)·10⁶ N/m²"),
        (2.5e-5, 1e-6, "s", "(2.50 ± 0.10)·10⁻⁵ s"),
        (0.0, 0.02, "rad", "0.000 ± 0.020 rad"),
        (3.0, 1.5e6, "m/s", "not determined"),
        (1.2345, None, "1", "1.234"),
        (2.4e6, None, "N/m^2", "2.4·10⁶ N/m²"),
        (1.5, math.inf, "s", "1.5 s"),
        (0.0, None, "s", "0 s"),
        (math.inf, None, "N m/rad", "∞ N m/rad"),
        (math.nan, None, "1", "–"),
    ],
)
def test_quantity(value: float, std: float | None, unit: str, text: str) -> None:
    assert value_with_std(ParameterEstimate(value=value, std=std, unit=unit)) == text


def test_figures_sentences_and_lists() -> None:
    assert [percent(share) for share in (0.04371, None, math.nan)] == ["4.37 %", "–", "–"]
    assert [torque_error_text(value) for value in (0.35345, 1.0, None)] == ["0.353", "1.00", "–"]
    assert sentence("sensor_delay: delay is at the end") == "Sensor delay: delay is at the end."
    assert sentence("fem4_ident: k is at the end.") == "Fem4_ident: k is at the end."
    assert [listed([*words], "or") for words in ("", "a", "ab", "abc")] == [
        "",
        "a",
        "a or b",
        "a, b or c",
    ]


def test_residual_structure_and_recordings_that_got_worse() -> None:
    assert "The residual has structure" in residual_structure(make_diagnosis(unexplained=True))
    assert "no structure left" in residual_structure(make_diagnosis(unexplained=False))
    diagnosis = make_diagnosis(worse=("held_d",))
    assert worse_recordings(diagnosis) == ["held_d"]


@pytest.mark.parametrize(
    ("name", "bic", "reason"),
    [
        ("carcass_torsion", -400.0, "added, no. 1"),
        ("torque_offset", 0.3, "added, no. 2; useless alone, ΔBIC −55.1 beside the others"),
        ("patch_width", -300.0, "indistinguishable from carcass torsion"),
        ("iwan", -300.0, "no clear gain beside what was added"),
        ("pressure_shape", -300.0, "the same mechanism as carcass torsion; no clear gain beside it"),
        ("stribeck", 4.0, "alone not worth its parameters"),
    ],
)
def test_every_candidate_has_the_reason_of_its_outcome(name: str, bic: float, reason: str) -> None:
    candidate = Candidate(name=name, summary="", holdout_nrmse=0.03, delta_bic=bic)
    assert candidate_reason(make_diagnosis(), candidate) == reason


def test_floats_round_trip_truth_is_a_digit_and_what_is_missing_is_empty() -> None:
    values = np.random.default_rng(1).normal(size=100)
    header, *rows = csv_text({"t": np.arange(100), "M_z": values}).splitlines()

    assert header == "t,M_z"
    assert [float(row.split(",")[1]) for row in rows] == values.tolist()
    missing = {"informed": np.array([True, False]), "mu": np.array([np.nan, 1.0])}
    assert csv_text(missing) == "informed,mu\n1,\n0,1.0\n"


def test_json_is_strict() -> None:
    content = {"a": [math.nan, 1.5, {"b": math.inf}], "c": "μ", "d": (True, None, 3)}

    assert json.loads(json_text(content)) == {
        "a": [None, 1.5, {"b": None}],
        "c": "μ",
        "d": [True, None, 3],
    }


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("by ±0.049 rad, 8 times", "by ±0.049 rad (±2.8°), 8 times"),
        ("of −0.24, 0.60 rad, at 0.12 rad/s", "of −0.24, 0.60 rad (−14°, 34°), at 0.12 rad/s (6.9°/s)"),
        ("between −0.52 and 0.89 rad, 52 s", "between −0.52 and 0.89 rad (−30° and 51°), 52 s"),
        ("k_t = 3 N m/rad", "k_t = 3 N m/rad"),
    ],
)  # fmt: skip
def test_angles_are_told_in_degrees_too(text: str, words: str) -> None:
    assert add_degrees_behind_radians(text) == words
