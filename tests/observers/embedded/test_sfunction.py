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
from symbolic import compiler
from tests.observers.embedded.conftest import Generate
from tests.observers.embedded.generated_code import DECLARED, NO_COMPILER, STRICT, observer_of

pytestmark = pytest.mark.skipif(compiler() is None, reason=NO_COMPILER)
STUB = Path(__file__).with_name("simulink")
MEX = ("-O1", "-ffp-contract=off", "-fPIC", "-DMATLAB_MEX_FILE", f"-I{STUB}")


@pytest.mark.parametrize(
    "measurement_model", [AligningTorque(), SteeringTorque()], ids=["aligning", "steering"]
)
@pytest.mark.parametrize("real", [SINGLE, DOUBLE], ids=["float", "double"])
def test_block_outputs_what_the_c_estimates(
    generated: Generate, real: Any, measurement_model: Any
) -> None:
    code = generated(observer_of(Ekf, DECLARED, measurement_model), real)
    sources = ("brushgrip_sfun.c", "brushgrip.c")
    block = code.compile(*STRICT, *MEX, "-shared", sources=sources, out="block.so")
    simulate = ctypes.CDLL(str(block)).simulate
    simulate.restype = ctypes.c_int64
    t = 0.01 * np.arange(300)
    psi = 0.2 * np.sin(5 * t)
    inputs = np.column_stack([psi, np.gradient(psi, 0.01), -8 * np.sin(5 * t), 400 + 0 * t])
    inputs[100:110, 2] = np.nan
    outputs = np.zeros((300, len(ESTIMATE)))
    arguments = [ctypes.c_void_p(array.ctypes.data) for array in (inputs, outputs)]

    assert simulate(ctypes.c_int64(300), ctypes.c_double(0.01), *arguments) == 300
    # Outputs are the C's estimates, one step late.
    expected = code.run(np.column_stack([inputs, np.full(300, 0.01)]))
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
