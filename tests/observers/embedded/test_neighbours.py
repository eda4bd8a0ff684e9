"""The class of C++17, the node of ROS 2, the S-function and a C Caller's function give what the C gives.

Neither ROS 2 nor Simulink is installed: node and S-function are compiled against stubs of what they use,
so that nothing here shows how they build or run there.
"""

import ctypes
import re
import shutil
import subprocess
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from observers import ESTIMATE, AligningTorque, Ekf, SteeringTorque
from observers.embedded import DOUBLE, SINGLE, generate_ros2
from tests.observers.embedded.conftest import Generate
from tests.observers.embedded.generated_code import (
    DECLARED,
    STRICT,
    GeneratedCode,
    needs_compiler,
    observer_of,
    swinging,
)

pytestmark = needs_compiler
needs_cpp = pytest.mark.skipif(shutil.which("g++") is None, reason="no g++ installed")
HERE = Path(__file__).parent
MEX = ("-O1", "-ffp-contract=off", "-fPIC", "-DMATLAB_MEX_FILE", f"-I{HERE / 'simulink'}")
STRICT_CPP = ("-std=c++17", "-O1", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-ffp-contract=off")
HEADERS = (
    "rcl_interfaces/msg/set_parameters_result.hpp", "rclcpp/rclcpp.hpp",
    "sensor_msgs/msg/joint_state.hpp", "std_msgs/msg/float64.hpp",
    "std_msgs/msg/float64_multi_array.hpp", "std_srvs/srv/trigger.hpp",
)  # fmt: skip


@pytest.fixture(scope="module")
def code(generated: Generate) -> GeneratedCode:
    return generated(observer_of(Ekf, DECLARED, AligningTorque()), DOUBLE)


def table() -> np.ndarray:
    t = 0.01 * np.arange(300)
    return np.column_stack([t, 0.2 * np.sin(5 * t), -8 * np.sin(5 * t)])


def printed_by(source: Path, code: GeneratedCode, folder: Path, *include: Path) -> np.ndarray:
    """What a program of C++, compiled with the C of an observer, prints of `table`."""
    program = folder / source.stem
    flags = [f"-I{path}" for path in (code.folder, *include)]
    command = ["g++", *STRICT_CPP, *flags, source, code.core, "-o", program]
    subprocess.run(command, check=True, timeout=300)
    rows = "\n".join(",".join(map(repr, row)) for row in table().tolist())
    process = subprocess.run([program], input=rows, text=True, capture_output=True, check=True)
    return np.array([line.split() for line in process.stdout.splitlines()], dtype=float)


def by_c(code: GeneratedCode, rows: np.ndarray, dt: np.ndarray) -> np.ndarray:
    silent, load = np.full(len(rows), np.nan), np.full(len(rows), 400.0)
    return code.run(np.column_stack([rows[:, 1], silent, rows[:, 2], load, dt]))


@needs_cpp
def test_class(code: GeneratedCode, tmp_path: Path) -> None:
    seen = printed_by(HERE / "observer.cpp", code, tmp_path)

    np.testing.assert_array_equal(seen, by_c(code, table(), np.full(300, 0.01))[:, [0, 1, -1]])
    assert np.ptp(seen[:, 0]) > 0.01


@needs_cpp
def test_node(code: GeneratedCode, tmp_path: Path) -> None:
    package, stubs = tmp_path / "package", tmp_path / "stubs"
    written = generate_ros2(code.observer, package, DOUBLE)
    for header in HEADERS:
        (stubs / header).parent.mkdir(parents=True, exist_ok=True)
        (stubs / header).write_text('#include "stub.hpp"\n')
    seen = printed_by(HERE / "ros2" / "drive.cpp", code, tmp_path, package, stubs, HERE / "ros2")

    times = table()[:, 0]
    # The first message has no predecessor.
    np.testing.assert_array_equal(seen[:, :-1], by_c(code, table()[1:], np.diff(times)))
    assert (seen[:, -1] == 0).all()
    assert ET.parse(package / "package.xml").findtext("name") == "brushgrip"
    assert {path.name for path in written} == {path.name for path in package.iterdir()}


def test_c_caller(generated: Generate, repository_root: Path) -> None:
    page = (repository_root / "docs" / "reference" / "targets.md").read_text("utf-8")
    function = re.search(r"```c\n(#include \"grip_caller.h\".*?)```", page, re.DOTALL)
    header = re.search(r"```c\n(#include \"grip.h\"\n\nvoid grip_caller.*?)```", page, re.DOTALL)
    assert function
    assert header
    code = generated(observer_of(Ekf, DECLARED, AligningTorque()), SINGLE)
    for name, text in (("caller.c", function[1]), ("brushgrip_caller.h", header[1])):
        own = text.replace("grip_", "brushgrip_").replace("grip.h", "brushgrip.h")
        (code.folder / name).write_text(own)
    sources = ("caller.c", code.core.name)
    library = ctypes.CDLL(str(code.compile("-fPIC", "-shared", sources=sources, out="caller.so")))
    call, seen = library.brushgrip_caller, np.empty((300, len(ESTIMATE)), np.float32)
    call.argtypes = [*[ctypes.c_float] * 5, ctypes.c_int32, ctypes.c_void_p]
    for i, (_, psi, torque) in enumerate(table()):
        call(psi, np.nan, torque, 400, 0.01, i == 0, seen[i].ctypes.data)

    np.testing.assert_array_equal(seen, by_c(code, table(), np.full(300, 0.01)).astype(np.float32))


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
    np.testing.assert_array_equal(outputs[1:], code.run(rows)[:-1])
    assert np.ptp(outputs[:, 0]) > 0.01
    for refused in (0.0, -1.0, np.nan):
        assert simulate(ctypes.c_int64(1), ctypes.c_double(refused), *arguments) == 0


def test_clang_has_no_warning(generated: Generate) -> None:
    code = generated(observer_of(Ekf, DECLARED, AligningTorque()), SINGLE)
    if (clang := shutil.which("clang")) is None:
        pytest.skip("no clang installed")
    flags = (*STRICT, *MEX, "-fsyntax-only")
    code.compile(*flags, sources=("brushgrip_sfun.c",), out="none", command=clang)
