"""Generated code stays sound whatever it is given, and keeps to itself."""

import shutil
import subprocess
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from observers import AligningTorque, Ekf, Mhe, SteeringTorque
from observers.embedded import DOUBLE, SINGLE
from symbolic.compiled import compiler
from tests.observers.embedded.building import (
    DECLARED,
    FOUND,
    NO_COMPILER,
    STRICT,
    Built,
    observer_of,
)
from tests.observers.embedded.conftest import Build

pytestmark = pytest.mark.skipif(compiler() is None, reason=NO_COMPILER)
REFUSED, MISSING = 128, 1
USUAL = [0.3, 1.0, 8.0, 400.0, 0.01]
ADDRESSES = ("-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
HOUR = 360_000
"""Samples of an hour at 100 Hz."""
WATCHED = [
    pytest.param(Ekf, DECLARED, AligningTorque(), HOUR, id="ekf-declared-aligning"),
    pytest.param(Ekf, DECLARED, SteeringTorque(), HOUR, id="ekf-declared-steering"),
    pytest.param(Mhe, DECLARED, AligningTorque(), HOUR // 4, id="mhe-declared-aligning"),
    pytest.param(Ekf, FOUND, SteeringTorque(), 3000, id="ekf-effects-steering"),
    pytest.param(Ekf, FOUND, AligningTorque(), 1000, id="ekf-effects-aligning"),
]
CASES = [
    pytest.param(Ekf, DECLARED, AligningTorque(), id="ekf-declared-aligning"),
    pytest.param(Ekf, FOUND, SteeringTorque(), id="ekf-effects-steering"),
    pytest.param(Ekf, DECLARED, SteeringTorque(zero=True, stiffness=True), id="ekf-steering-5"),
    pytest.param(Mhe, DECLARED, AligningTorque(stiffness=True), id="mhe-declared-aligning"),
    pytest.param(Mhe, DECLARED, SteeringTorque(), id="mhe-declared-steering"),
    pytest.param(Mhe, FOUND, AligningTorque(), id="mhe-effects-aligning"),
]
each_case = pytest.mark.parametrize(("kind", "model", "sensing"), CASES)


@each_case
@pytest.mark.parametrize("real", [SINGLE, DOUBLE], ids=["float", "double"])
def test_random_bytes_leave_an_estimate(
    built: Build, kind: Any, model: Any, sensing: Any, real: Any
) -> None:
    code = built(observer_of(kind, model, sensing), real)
    count = 20_000 if kind is Ekf else 3_000
    unsound, refused = code.fuzz(count, 1, USUAL)

    assert unsound == 0
    # A third of the samples has random bytes in half of its fields, and few bytes are a time.
    assert 0.02 * count < refused < 0.3 * count


@each_case
def test_two_do_not_disturb_each_other(built: Build, kind: Any, model: Any, sensing: Any) -> None:
    code = built(observer_of(kind, model, sensing), SINGLE)
    t = np.arange(120) / 100
    psi = 0.2 * np.sin(5 * t)
    rows = np.column_stack([psi, psi, -8 * np.sin(5 * t), 400 + 0 * t, 0.01 + 0 * t])
    one, two = code.follow_two(rows)

    np.testing.assert_array_equal(one, code.follow(rows))
    np.testing.assert_array_equal(two, code.follow(rows[::-1]))
    assert np.abs(one - two)[:, 0].max() > 1e-3


def test_times_out_of_range_are_refused_and_change_nothing(built: Build) -> None:
    code = built(observer_of(Ekf, DECLARED, AligningTorque()), SINGLE)
    good = [0.01, 0.5, -1.0, 400.0, 0.01]
    bad = [[*good[:4], dt] for dt in (0.0, -1.0, np.nan, np.inf, 4000.0)]
    rows = np.array([good, [0.05, *good[1:]], *bad, [0.09, *good[1:]]])
    said = code.follow(rows)

    assert (said[2:7, 4] == REFUSED).all()
    np.testing.assert_array_equal(said[2:7, :4], np.tile(said[1, :4], (5, 1)))
    np.testing.assert_array_equal(said[7], code.follow(rows[[0, 1, 7]])[2])


@pytest.mark.parametrize("nothing", [np.nan, np.inf, -np.inf, 1e20])
@pytest.mark.parametrize("column", [0, 1, 2, 3])
def test_what_a_sensor_does_not_give_is_flagged(built: Build, column: int, nothing: float) -> None:
    code = built(observer_of(Ekf, DECLARED, AligningTorque()), SINGLE)
    rows = np.tile([0.05, 0.0, -1.0, 400.0, 0.01], (4, 1))
    rows[2, column] = nothing
    said = code.follow(rows)

    assert np.isfinite(said).all()
    # The angle takes the torque with it; a missing rate is taken from the angle and needs no flag.
    assert said[2, 4] == {0: 3, 1: 0, 2: 1, 3: 2}[column]
    assert said[3, 4] == 0


def test_before_the_first_usable_sample_the_prior_stands(built: Build) -> None:
    code = built(observer_of(Ekf, DECLARED, AligningTorque(), mu=0.8, mu_std=0.3), SINGLE)
    said = code.follow(
        np.array([[np.nan, 0, 1, 400, 0.01], [0.1, 0, 1, -5, 0.01], [0.1, 0, 1, 400, 0.01]])
    )

    np.testing.assert_allclose(said[:2, :2], [[0.8, 0.3]] * 2, rtol=1e-6)
    assert np.isnan(said[:2, 2]).all()
    assert said[:, 4].tolist() == [MISSING, MISSING, 0]


def test_core_needs_nothing_but_mathematics(built: Build) -> None:
    if (nm := shutil.which("nm")) is None:
        pytest.skip("no nm at hand to list symbols")
    for kind, model in product((Ekf, Mhe), (DECLARED, FOUND)):
        code = built(observer_of(kind, model, AligningTorque()), SINGLE)
        code.compile("-O1", "-c", sources=("brushgrip.c",), out="bare.o")
        listed = subprocess.run(
            [nm, "bare.o"], cwd=code.folder, capture_output=True, text=True, check=True
        )
        symbols = [line.split()[-2:] for line in listed.stdout.splitlines()]
        asked = {name for mark, name in symbols if mark == "U"}
        given = {name for mark, name in symbols if mark == "T"}

        # The compiler may copy and clear by calls, as a freestanding target must offer too.
        assert asked <= {
            "expf",
            "logf",
            "log1pf",
            "powf",
            "sqrtf",
            "fmaxf",
            "fminf",
            "memcpy",
            "memset",
            "memmove",
        }
        assert given == {
            f"brushgrip_{name}" for name in ("init", "step", "estimate", "reset", "version")
        }
        assert not {mark for mark, _ in symbols} & set("DdBbC"), "data that can be written to"


@pytest.mark.parametrize(("kind", "model", "sensing", "count"), WATCHED)
def test_sanitisers_find_nothing(
    built: Build, repository_root: Path, kind: Any, model: Any, sensing: Any, count: int
) -> None:
    code = built(observer_of(kind, model, sensing), SINGLE)
    made = watched(code, "follow.c", "-DALONE", *ADDRESSES)
    fuzzed = subprocess.run([made, str(count), *map(str, USUAL)], capture_output=True, text=True)
    assert fuzzed.returncode == 0, fuzzed.stdout + fuzzed.stderr
    if "M" not in sensing.channels:
        example = code.compile(*ADDRESSES, sources=("brushgrip.c", "main.c"), out="watched_example")
        for recording in sorted((repository_root / "examples" / "recordings").glob("*.csv")):
            seen = subprocess.run([example, recording], capture_output=True, text=True)
            assert seen.returncode == 0, seen.stderr
            assert seen.stderr == ""
            assert seen.stdout.count("\n") > 1000


@pytest.mark.parametrize(("kind", "model"), [(Ekf, DECLARED), (Mhe, DECLARED), (Ekf, FOUND)])
def test_threads_share_nothing(built: Build, kind: Any, model: Any) -> None:
    code = built(observer_of(kind, model, AligningTorque()), SINGLE)
    made = watched(code, "threads.c", "-O1", "-g", "-pthread", "-fsanitize=thread")
    seen = subprocess.run([made], capture_output=True, text=True)
    if "unexpected memory mapping" in seen.stderr:
        pytest.skip("the thread sanitiser does not run on this kernel")

    assert seen.returncode == 0, seen.stdout + seen.stderr
    assert seen.stderr == ""


def watched(code: Built, driver: str, *flags: str) -> Path:
    """The code with a driver, under a sanitiser."""
    sources = ("brushgrip.c", str(Path(__file__).with_name(driver)))
    try:
        return code.compile(*flags, sources=sources, out="watched")
    except subprocess.CalledProcessError:
        pytest.skip("the compiler has no such sanitiser")


@pytest.mark.parametrize("real", [SINGLE, DOUBLE], ids=["float", "double"])
@each_case
def test_clang_has_nothing_to_say(built: Build, kind: Any, model: Any, sensing: Any, real: Any) -> None:
    if (clang := shutil.which("clang")) is None:
        pytest.skip("no clang at hand")
    code = built(observer_of(kind, model, sensing), real)
    code.compile(*STRICT, "-fsyntax-only", sources=("brushgrip.c",), out="none", command=clang)


def test_cppcheck_finds_nothing(built: Build) -> None:
    if (cppcheck := shutil.which("cppcheck")) is None:
        pytest.skip("no cppcheck at hand")
    asked = ["--std=c99", "--enable=warning,performance,portability", "--error-exitcode=1", "--quiet"]
    for kind in (Ekf, Mhe):
        code = built(observer_of(kind, DECLARED, AligningTorque()), SINGLE)
        found = subprocess.run(
            [cppcheck, *asked, "brushgrip.c", "main.c", "check.c"],
            cwd=code.folder,
            capture_output=True,
            text=True,
        )
        assert found.returncode == 0, found.stderr
