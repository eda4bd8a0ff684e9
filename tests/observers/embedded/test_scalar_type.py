"""Text of generated C: one type of number, and names of its own."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from observers.embedded import generate
from observers.embedded.scalar_type import (
    DOUBLE,
    SINGLE,
    code_in_type,
    count_names,
    defined_names,
    prefix_own_c_names,
)
from tests.compile_once import OPTIMISATION
from tests.observers.embedded.conftest import Generate
from tests.observers.embedded.generated_code import (
    STRICT,
    GeneratedCode,
    needs_compiler,
    observer_named,
    swinging,
)
from tests.refusal import refused

CODE = """\
/* sqrt(2.) of a comment */ // 1.5 there too
static double f(double x1) {
  const char *text = "1.5 sqrt(";
  return sqrt(x1) + 2. * 1.5e-3 + .5 - 7 + 1e9 + x1*a0.w + 0x1F + 12u + casadi_fmax(x1, 3) + 1.5f;
}
"""


def test_literals_and_functions_are_of_the_type() -> None:
    once, expected = code_in_type(CODE, SINGLE), CODE.replace("sqrt(x1)", "sqrtf(x1)")
    for literal in (" 2.", "1.5e-3", " .5", " 1e9"):
        expected = expected.replace(f"{literal} ", f"{literal}f ")
    assert once == expected
    assert code_in_type(CODE, DOUBLE) == CODE
    assert code_in_type(once, SINGLE) == once


def test_names_in_comments_and_strings_do_not_count() -> None:
    assert count_names(CODE)["sqrt"] == 1


def test_a_constant_beyond_the_type_is_refused() -> None:
    assert "1e60" in refused(code_in_type, "x = 1e60;", SINGLE)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.1, "1.00000001e-01f"),
        (float("nan"), "(float)NAN"),
        (float("-inf"), "(float)-INFINITY"),
        (0.0, "0.00000000e+00f"),
    ],
)
def test_literals_of_a_type(value: float, text: str) -> None:
    assert SINGLE.literal(value) == text


def test_double_literals_round_trip() -> None:
    assert float(DOUBLE.literal(0.1)) == 0.1


OTHERS = {
    "window": observer_named("mhe declared steering"),
    "creeping": observer_named("ekf creep steering"),
    "creeping_window": observer_named("mhe creep aligning"),
    "corners": observer_named("mhe declared aligning"),
    "vectors": replace(observer_named("ekf declared aligning"), iterations=2),
}
"""The last one is CasADi's own C."""
TEXT = """\
#define LIMIT (1.0)
enum { FIRST, SECOND = 2, COUNT };
typedef struct {
    int limit, FIRST_of;
} pair_t;
static const double table[COUNT] = {0.0}; /* table of LIMIT */
static inline double twice(const pair_t *pair) { return 2.0 * pair->table + now.twice; }
double grip_public(void) { return twice(0) + LIMIT + table[FIRST]; /* twice */ }
// A pair.
pair_t grip_pair(void) { return now./* own */twice; }
"""


def test_names_of_a_file_get_its_prefix() -> None:
    assert defined_names(TEXT) == {"LIMIT", "FIRST", "SECOND", "COUNT", "pair_t", "table", "twice"}
    seen = prefix_own_c_names(TEXT, "grip")

    assert "#define GRIP_LIMIT (1.0)" in seen
    assert "static const double grip_table[GRIP_COUNT] = {0.0}; /* table of LIMIT */" in seen
    assert "grip_twice(const grip_pair_t *pair) { return 2.0 * pair->table + now.twice; }" in seen
    assert "// A pair.\ngrip_pair_t grip_pair(void) { return now./* own */twice; }" in seen
    assert "return grip_twice(0) + GRIP_LIMIT + grip_table[GRIP_FIRST]; /* twice */" in seen
    assert prefix_own_c_names(seen, "grip") == seen


@pytest.mark.long
@needs_compiler
def test_one_translation_unit(generated: Generate, tmp_path: Any) -> None:
    alone = generated(observer_named("ekf declared aligning"), SINGLE)
    generate(alone.observer, tmp_path, SINGLE)
    for name, observer in OTHERS.items():
        generate(observer, tmp_path, SINGLE, name=name)
    files = ["brushgrip", *OTHERS]
    (tmp_path / "unit.c").write_text("".join(f'#include "{name}.c"\n' for name in files))
    unit = GeneratedCode(alone.observer, SINGLE, tmp_path)
    unit.compile(*STRICT, OPTIMISATION, "-fPIC", "-c", sources=("unit.c",), out="core.o")
    vars(unit)["core"] = tmp_path / "core.o"
    rows = swinging(200)

    np.testing.assert_array_equal(unit.run(rows), alone.run(rows))
