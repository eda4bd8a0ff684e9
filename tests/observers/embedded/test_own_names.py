"""Several observers compile as one translation unit, and give what each gives alone."""

from typing import Any

import numpy as np
import pytest

from observers import AligningTorque, Ekf, Mhe, SteeringTorque
from observers.embedded import SINGLE, generate
from observers.embedded.own_names import defined_names, with_prefix
from symbolic import Model, compiler, effects_named
from tests.compile_once import OPTIMISATION
from tests.observers.conftest import K
from tests.observers.embedded.conftest import Generate
from tests.observers.embedded.generated_code import (
    CREEP,
    DECLARED,
    NO_COMPILER,
    STRICT,
    GeneratedCode,
    observer_of,
)

CASADI: dict[str, Any] = {
    "model": Model(effects=effects_named(["carcass_torsion"])),
    "values": {"k": K, "carcass_torsion.k_t": 300.0},
}
"""A model for which the C is CasADi's own."""
OTHERS = {
    "window": (Mhe, DECLARED, SteeringTorque()),
    "creeping": (Ekf, CREEP, SteeringTorque()),
    "creeping_window": (Mhe, CREEP, AligningTorque()),
    "corners": (Mhe, DECLARED, AligningTorque()),
    "vectors": (Ekf, CASADI, AligningTorque()),
}
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
@pytest.mark.skipif(compiler() is None, reason=NO_COMPILER)
def test_one_translation_unit(generated: Generate, tmp_path: Any) -> None:
    alone = generated(observer_of(Ekf, DECLARED, AligningTorque()), SINGLE)
    generate(alone.observer, tmp_path, SINGLE)
    for name, of in OTHERS.items():
        generate(observer_of(*of), tmp_path, SINGLE, name=name)
    files = ["brushgrip", *OTHERS]
    (tmp_path / "unit.c").write_text("".join(f'#include "{name}.c"\n' for name in files))
    unit = GeneratedCode(alone.observer, SINGLE, tmp_path)
    unit.compile(*STRICT, OPTIMISATION, "-fPIC", "-c", sources=("unit.c",), out="core.o")
    vars(unit)["core"] = tmp_path / "core.o"
    t = 0.01 * np.arange(200)
    rows = np.column_stack(
        [0.2 * np.sin(5 * t), t * np.nan, -8 * np.sin(5 * t), 400 + 0 * t, 0.01 + 0 * t]
    )

    np.testing.assert_array_equal(unit.run(rows), alone.run(rows))
