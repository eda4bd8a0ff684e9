"""Several observers compile as one translation unit, and give what each gives alone."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from observers.embedded import SINGLE, generate
from observers.embedded.own_names import defined_names, with_prefix
from tests.compile_once import OPTIMISATION
from tests.observers.embedded.conftest import Generate
from tests.observers.embedded.generated_code import (
    STRICT,
    GeneratedCode,
    needs_compiler,
    observer_named,
    swinging,
)

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
"""


def test_names_of_a_file_get_its_prefix() -> None:
    assert defined_names(TEXT) == {"LIMIT", "FIRST", "SECOND", "COUNT", "pair_t", "table", "twice"}
    seen = with_prefix(TEXT, "grip")

    assert "#define GRIP_LIMIT (1.0)" in seen
    assert "static const double grip_table[GRIP_COUNT] = {0.0}; /* table of LIMIT */" in seen
    assert "grip_twice(const grip_pair_t *pair) { return 2.0 * pair->table + now.twice; }" in seen
    assert "return grip_twice(0) + GRIP_LIMIT + grip_table[GRIP_FIRST]; /* twice */" in seen
    assert with_prefix(seen, "grip") == seen


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
