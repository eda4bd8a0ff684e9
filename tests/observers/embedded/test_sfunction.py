"""The S-function against a stub of Simulink's interface: it compiles and says what the C says.

Simulink itself is not at hand, so that nothing here shows what it makes of the block.
"""

import ctypes
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from observers import AligningTorque, Ekf, SteeringTorque
from observers.embedded import DOUBLE, SINGLE
from symbolic import compiler
from tests.observers.embedded.building import DECLARED, NO_COMPILER, STRICT, observer_of
from tests.observers.embedded.conftest import Build

pytestmark = pytest.mark.skipif(compiler() is None, reason=NO_COMPILER)
STUB = Path(__file__).with_name("simulink")
MEX = ("-O1", "-ffp-contract=off", "-fPIC", "-DMATLAB_MEX_FILE", f"-I{STUB}")


@pytest.mark.parametrize("sensing", [AligningTorque(), SteeringTorque()], ids=["aligning", "steering"])
@pytest.mark.parametrize("real", [SINGLE, DOUBLE], ids=["float", "double"])
def test_block_says_what_the_c_says(built: Build, real: Any, sensing: Any) -> None:
    code = built(observer_of(Ekf, DECLARED, sensing), real)
    sources = ("brushgrip_sfun.c", "brushgrip.c")
    made = code.compile(*STRICT, *MEX, "-shared", sources=sources, out="block.so")
    simulate = ctypes.CDLL(str(made)).simulate
    simulate.restype = ctypes.c_int64
    t = 0.01 * np.arange(300)
    psi = 0.2 * np.sin(5 * t)
    given = np.column_stack([psi, np.gradient(psi, 0.01), -8 * np.sin(5 * t), 400 + 0 * t])
    given[100:110, 2] = np.nan
    said = np.zeros((300, 5))
    arguments = [ctypes.c_void_p(array.ctypes.data) for array in (given, said)]

    assert simulate(ctypes.c_int64(300), ctypes.c_double(0.01), *arguments) == 300
    # Outputs hold the samples before: they are the C's, one step late.
    expected = code.follow(np.column_stack([given, np.full(300, 0.01)]))
    np.testing.assert_array_equal(said[1:], expected[:-1])
    assert np.ptp(said[:, 0]) > 0.01
    for refused in (0.0, -1.0, np.nan):
        assert simulate(ctypes.c_int64(1), ctypes.c_double(refused), *arguments) == 0


def test_clang_has_nothing_to_say(built: Build) -> None:
    code = built(observer_of(Ekf, DECLARED, AligningTorque()), SINGLE)
    if (clang := shutil.which("clang")) is None:
        pytest.skip("no clang at hand")
    flags = (*STRICT, *MEX, "-fsyntax-only")
    code.compile(*flags, sources=("brushgrip_sfun.c",), out="none", command=clang)
