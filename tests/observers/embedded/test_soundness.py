"""Generated code gives valid estimates for any input and accesses only its own memory."""

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from observers.embedded import DOUBLE, SINGLE, Real
from tests.observers.embedded.conftest import Generate
from tests.observers.embedded.generated_code import (
    STRICT,
    GeneratedCode,
    RunningCode,
    cases,
    needs_compiler,
    observer_named,
)

pytestmark = needs_compiler
PLAIN = "ekf declared aligning"
REFUSED, MISSING = 128, 1
USUAL = [0.3, 1.0, 8.0, 400.0, 0.01]
ADDRESSES = ("-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
HOUR = 360_000
"""Samples of an hour at 100 Hz."""
LONG = pytest.mark.long
each_case = pytest.mark.parametrize(
    "name",
    cases(
        "ekf declared aligning; mhe few aligning",
        "ekf declared steering,k,M_0; ekf few steering; ekf effects steering; mhe declared aligning,k;"
        " mhe declared steering; mhe effects aligning; ekf relaxing aligning,k",
    ),
)
each_real = pytest.mark.parametrize(
    "real", [pytest.param(SINGLE, id="float"), pytest.param(DOUBLE, id="double", marks=LONG)]
)


@each_case
@each_real
def test_random_bytes_leave_a_valid_estimate(generated: Generate, name: str, real: Real) -> None:
    code = generated(observer_named(name), real)
    count = 20_000 if "ekf" in name else 3_000
    invalid, refused = RunningCode(code).fuzz(count, 1, USUAL)

    assert invalid == 0
    # A third of the samples has random bytes in half of its fields, and few bytes are a time.
    assert 0.02 * count < refused < 0.3 * count


def test_times_out_of_range_are_ignored(generated: Generate) -> None:
    code = generated(observer_named(PLAIN), SINGLE)
    good = [0.01, 0.5, -1.0, 400.0, 0.01]
    bad = [[*good[:4], dt] for dt in (0.0, -1.0, np.nan, np.inf, 4000.0)]
    rows = np.array([good, [0.05, *good[1:]], *bad, [0.09, *good[1:]]])
    estimates = code.run(rows)

    assert (estimates[2:7, -1] == REFUSED).all()
    np.testing.assert_array_equal(estimates[2:7, :-1], np.tile(estimates[1, :-1], (5, 1)))
    np.testing.assert_array_equal(estimates[7], code.run(rows[[0, 1, 7]])[2])


def test_a_time_that_is_refused_before_the_first_sample_is_forgotten(generated: Generate) -> None:
    code = generated(observer_named(PLAIN, acquire=False), SINGLE)
    good = [0.01, 0.5, -1.0, 400.0, 0.01]
    rows = np.array([[*good[:4], 0.0], [np.nan, *good[1:]], good])

    np.testing.assert_array_equal(code.run(rows)[:, -1], [REFUSED, MISSING, 0])


def test_the_estimate_is_the_prior_before_the_first_usable_sample(generated: Generate) -> None:
    code = generated(observer_named(PLAIN, acquire=False, mu=0.8, mu_std=0.3), SINGLE)
    good = [0.1, 0.0, 1.0, 400.0, 0.01]
    estimates = code.run(np.array([[np.nan, *good[1:]], [*good[:3], -5.0, 0.01], good]))

    np.testing.assert_allclose(estimates[:2, :2], [[0.8, 0.3]] * 2, rtol=1e-6)
    assert np.isnan(estimates[:2, 2]).all()
    assert estimates[:, -1].tolist() == [MISSING, MISSING, 0]


def test_what_is_not_there_is_refused(generated: Generate) -> None:
    code = generated(observer_named(PLAIN), SINGLE)

    assert code.library.brushgrip_step(None, None) == REFUSED
    code.library.brushgrip_estimate(None, None)


def test_fast_math_does_not_compile(generated: Generate) -> None:
    code = generated(observer_named(PLAIN), SINGLE)

    with pytest.raises(subprocess.CalledProcessError):
        code.compile("-fsyntax-only", "-ffast-math", sources=("brushgrip.c",), out="fast.o")


@pytest.mark.parametrize(
    "name",
    cases(
        "ekf declared aligning; ekf few aligning; mhe few aligning",
        "ekf creep aligning; mhe declared aligning; mhe creep aligning; mhe declared steering;"
        " ekf effects aligning; mhe effects aligning",
    ),
)
@each_real
def test_the_header_says_how_large_a_state_is(generated: Generate, name: str, real: Real) -> None:
    code = generated(observer_named(name), real)
    (said,) = re.findall(r"One observer, (\d+) bytes", (code.folder / "brushgrip.h").read_text())
    lines = f'_Static_assert(sizeof(brushgrip_state_t) == {said}, "state");\n'
    (code.folder / "size.c").write_text(f'#include "brushgrip.h"\n{lines}')

    code.compile("-std=c11", "-fsyntax-only", sources=("size.c",), out="size.o")


@pytest.mark.parametrize(
    "name",
    cases(
        "ekf declared aligning; ekf few aligning; mhe few aligning",
        "ekf declared steering,k,M_0; ekf few steering; ekf effects steering; mhe declared aligning,k;"
        " mhe declared steering; mhe effects aligning; ekf relaxing aligning,k; ekf effects aligning;"
        " mhe declared aligning",
    ),
)
def test_code_calls_only_the_mathematics_library(generated: Generate, name: str) -> None:
    if (nm := shutil.which("nm")) is None:
        pytest.skip("no nm installed to list symbols")
    code = generated(observer_named(name), SINGLE)
    listed = subprocess.run([nm, code.core], capture_output=True, text=True, check=True)
    symbols = [line.split()[-2:] for line in listed.stdout.splitlines()]
    undefined = {name for mark, name in symbols if mark == "U"}
    defined = {name for mark, name in symbols if mark == "T"}

    # The compiler may copy and clear by calls, as a freestanding target must offer too.
    functions = "expf logf log1pf powf sqrtf fmaxf fminf memcpy memset memmove"
    assert undefined <= set(functions.split())
    public = ("init", "step", "estimate", "reset", "restore", "version")
    assert defined == {f"brushgrip_{name}" for name in public}
    assert not {mark for mark, _ in symbols} & set("DdBbC"), "data that can be written to"


@pytest.mark.parametrize(
    ("name", "count"),
    [
        *cases("ekf declared aligning", "", HOUR // 10),
        *cases("mhe declared aligning", "ekf creep aligning", HOUR // 100),
        *(
            pytest.param(f"ekf {name}", HOUR, marks=LONG)
            for name in ("declared aligning", "declared steering", "creep aligning", "creep steering")
        ),
        *(
            pytest.param(f"mhe {model} aligning", HOUR // 4, marks=LONG)
            for model in ("creep", "declared")
        ),
        pytest.param("ekf effects steering", 3000, marks=LONG),
        pytest.param("ekf effects aligning", 1000, marks=LONG),
    ],
)
def test_sanitisers_have_no_finding(
    generated: Generate, repository_root: Path, name: str, count: int
) -> None:
    code = generated(observer_named(name), SINGLE)
    program = instrumented(code, "run.c", "-DALONE", *ADDRESSES)
    fuzzed = subprocess.run([program, str(count), *map(str, USUAL)], capture_output=True, text=True)
    assert fuzzed.returncode == 0, fuzzed.stdout + fuzzed.stderr
    if code.observer.channel == "M_z":
        example = code.compile(*ADDRESSES, sources=("instrumented.o", "main.c"), out="example")
        for recording in sorted((repository_root / "examples" / "recordings").glob("*.csv")):
            seen = subprocess.run([example, recording], capture_output=True, text=True)
            assert seen.returncode == 0, seen.stderr
            assert seen.stderr == ""
            assert seen.stdout.count("\n") > 1000


@pytest.mark.parametrize(
    "name",
    cases("ekf declared aligning", "mhe declared aligning; ekf few aligning; ekf effects aligning"),
)
def test_threads_share_nothing(generated: Generate, name: str) -> None:
    code = generated(observer_named(name, acquire=False), SINGLE)
    program = instrumented(code, "threads.c", "-O1", "-g", "-pthread", "-fsanitize=thread")
    seen = subprocess.run([program], capture_output=True, text=True)
    if "unexpected memory mapping" in seen.stderr:
        pytest.skip("the thread sanitiser does not run on this kernel")

    assert seen.returncode == 0, seen.stdout + seen.stderr
    assert seen.stderr == ""


def instrumented(code: GeneratedCode, driver: str, *flags: str) -> Path:
    """The code with a driver, under a sanitiser."""
    sources = ("instrumented.o", str(Path(__file__).with_name(driver)))
    try:
        code.compile(*flags, "-c", sources=("brushgrip.c",), out="instrumented.o")
        return code.compile(*flags, sources=sources, out="instrumented")
    except subprocess.CalledProcessError:
        pytest.skip("the compiler has no such sanitiser")


@each_real
@each_case
def test_clang_has_no_warning(generated: Generate, name: str, real: Real) -> None:
    if (clang := shutil.which("clang")) is None:
        pytest.skip("no clang installed")
    code = generated(observer_named(name), real)
    code.compile(*STRICT, "-fsyntax-only", sources=("brushgrip.c",), out="none", command=clang)


@pytest.mark.long
@pytest.mark.parametrize("model", ["declared", "few", "creep"])
def test_misra_findings_are_those_that_the_page_explains(
    generated: Generate, model: str, repository_root: Path
) -> None:
    if (cppcheck := shutil.which("cppcheck")) is None:
        pytest.skip("no cppcheck installed")
    page = (repository_root / "docs" / "reference" / "embedded.md").read_text("utf-8")
    explained = set(re.findall(r"^\| (\d+\.\d+) \|", page, re.MULTILINE))
    for kind in ("ekf", "mhe"):
        code = generated(observer_named(f"{kind} {model} aligning"), SINGLE)
        found = subprocess.run(
            [cppcheck, "--addon=misra", "--std=c99", "--quiet", "--template={id}", "brushgrip.c"],
            cwd=code.folder, capture_output=True, text=True, check=True,
        )  # fmt: skip
        rules = set(re.findall(r"misra-c2012-(\d+\.\d+)", found.stderr))

        assert rules
        assert rules <= explained, rules - explained


@pytest.mark.parametrize("acquire", [pytest.param(False, marks=LONG), pytest.param(True, marks=LONG)])
def test_cppcheck_has_no_finding(generated: Generate, acquire: bool) -> None:
    if (cppcheck := shutil.which("cppcheck")) is None:
        pytest.skip("no cppcheck installed")
    asked = ["--std=c99", "--enable=warning,performance,portability", "--error-exitcode=1", "--quiet"]
    for kind in ("ekf", "mhe"):
        code = generated(observer_named(f"{kind} declared aligning", acquire=acquire), SINGLE)
        command = [cppcheck, *asked, "brushgrip.c", "main.c", "check.c"]
        found = subprocess.run(command, cwd=code.folder, capture_output=True, text=True)
        assert found.returncode == 0, found.stderr
