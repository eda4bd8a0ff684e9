"""The S-function against a stub of Simulink's interface: it compiles and outputs what the C estimates.

Simulink itself is not installed, so nothing here shows how it runs the block.
"""

import ctypes
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from observers import ESTIMATE, AligningTorque, Ekf, SteeringTorque
from observers.embedded import DOUBLE, SINGLE
from tests.observers.embedded.conftest import Generate
from tests.observers.embedded.generated_code import (
    DECLARED,
    STRICT,
    needs_compiler,
    observer_of,
    swinging,
)

pytestmark = needs_compiler
STUB = Path(__file__).with_name("simulink")
MEX = ("-O1", "-ffp-contract=off", "-fPIC", "-DMATLAB_MEX_FILE", f"-I{STUB}")


@pytest.mark.parametrize(
    "measurement_model", [AligningTorque(), SteeringTorque()], ids=["aligning", "steering"]
)
@pytest.mark.parametrize(
    "real", [pytest.param(SINGLE, id="float", marks=pytest.mark.long), pytest.param(DOUBLE, id="double")]
)
def test_block_outputs_what_the_c_estimates(
    generated: Generate, real: Any, measurement_model: Any
) -> None:
    code = generated(observer_of(Ekf, DECLARED, measurement_model), real)
    sources = ("brushgrip_sfun.c", "brushgrip.c")
    block = code.compile(*STRICT, *MEX, "-shared", sources=sources, out="block.so")
    simulate = ctypes.CDLL(str(block)).simulate
    simulate.restype = ctypes.c_int64
    rows = swinging(300)
    rows[:, 1], rows[100:110, 2] = np.gradient(rows[:, 0], 0.01), np.nan
    inputs = np.ascontiguousarray(rows[:, :4])
    outputs = np.zeros((300, len(ESTIMATE)))
    arguments = [ctypes.c_void_p(array.ctypes.data) for array in (inputs, outputs)]

    assert simulate(ctypes.c_int64(300), ctypes.c_double(0.01), *arguments) == 300
    # Outputs are the C's estimates, one step late.
    expected = code.run(rows)
    np.testing.assert_array_equal(outputs[1:], expected[:-1])
    assert np.ptp(outputs[:, 0]) > 0.01
    for refused in (0.0, -1.0, np.nan):
        assert simulate(ctypes.c_int64(1), ctypes.c_double(refused), *arguments) == 0


def test_clang_has_no_warning(generated: Generate) -> None:
    code = generated(observer_of(Ekf, DECLARED, AligningTorque()), SINGLE)
    if (clang := shutil.which("clang")) is None:
        pytest.skip("no clang installed")
    flags = (*STRICT, *MEX, "-fsyntax-only")
    code.compile(*flags, sources=("brushgrip_sfun.c",), out="none", command=clang)
