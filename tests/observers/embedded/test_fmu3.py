"""The FMU of FMI 3.0 builds from its sources and gives what that of 2.0 and libcosim give."""

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from observers import ESTIMATE, AligningTorque, Ekf
from observers.embedded import DOUBLE, generate_fmu
from observers.embedded.fmu import is_host
from symbolic import InvalidInputError, compiler
from tests.observers.embedded.conftest import Unpacked
from tests.observers.embedded.fmu_instance import instances
from tests.observers.embedded.generated_code import (
    DECLARED,
    STRICT,
    needs_compiler,
    observer_of,
    swinging,
)

fmpy = pytest.importorskip("fmpy", reason="FMPy is not installed: pip install 'brushgrip[dev]'")
pytestmark = [
    pytest.mark.long,
    needs_compiler,
    pytest.mark.skipif(not is_host(), reason="FMUs are built on Linux x86_64 alone"),
]
EKF = observer_of(Ekf, DECLARED, AligningTorque())


def test_both_versions_give_the_same(unpacked: Unpacked) -> None:
    rows = swinging(300)[:, :4]
    rows[100:104, 2] = np.nan
    with instances(unpacked(EKF, DOUBLE)) as (two,), instances(unpacked(EKF, DOUBLE, 3)) as (three,):
        expected, seen = two.steps(rows), three.steps(rows)

    np.testing.assert_array_equal(seen, expected)
    assert np.ptp(expected[:, 0]) > 0.01


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # FMPy's folder
def test_an_importer_builds_it_from_its_sources(unpacked: Unpacked, tmp_path: Path) -> None:
    if shutil.which("cmake") is None:
        pytest.skip("no CMake installed")
    from fmpy.build import build_platform_binary

    folder, built, rows = unpacked(EKF, DOUBLE, 3), tmp_path / "built", swinging(300)[:, :4]
    shutil.copytree(folder, built, ignore=shutil.ignore_patterns("binaries"))
    build_platform_binary(built, configuration="Release", generator="Unix Makefiles")
    with instances(folder) as (ours,), instances(built) as (theirs,):
        np.testing.assert_array_equal(theirs.steps(rows), ours.steps(rows))


def test_interface_is_the_standards(unpacked: Unpacked, tmp_path: Path) -> None:
    folder, standard = unpacked(EKF, DOUBLE, 3), Path(fmpy.__file__).parent / "c-code"
    sources = folder / "sources"
    seen = subprocess.run(["nm", "-D", "--defined-only", folder / "binaries/x86_64-linux/brushgrip.so"],
                          capture_output=True, text=True, check=True).stdout  # fmt: skip
    names = set(re.findall(r"fmi3FullName\((fmi3\w+)\)", (standard / "fmi3Functions.h").read_text()))
    assert names == set(re.findall(r" T (fmi3\w+)", seen))
    # Their declarations before our definitions: a compiler refuses what differs.
    unit = tmp_path / "unit.c"
    unit.write_text('#include "fmi3Functions.h"\n#include "brushgrip_fmu.c"\n')
    ours = (sources / "fmi3.h").read_text()
    bridge = tmp_path / "fmi3.h"
    bridge.write_text(ours[ours.index("/* FMI3(fmi3Status, DoStep)") : ours.rindex("#endif")])
    for name in ("brushgrip_fmu.c", "brushgrip.h"):
        shutil.copy(sources / name, tmp_path)
    command = [str(compiler()), *STRICT, "-Wno-strict-prototypes", f"-I{tmp_path}", f"-I{standard}"]
    subprocess.run([*command, "-fsyntax-only", unit], check=True)


def test_another_version_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidInputError, match=r"version of FMI must be one of \[2, 3\], got 1"):
        generate_fmu(EKF, tmp_path, version=1)


@pytest.mark.parametrize("version", [2, 3])
def test_licence_and_documentation_are_inside(
    unpacked: Unpacked, repository_root: Path, version: int
) -> None:
    folder = unpacked(EKF, DOUBLE, version)
    documentation = folder / "documentation"

    assert (documentation / "licenses" / "license.txt").read_text() == (
        repository_root / "LICENSE"
    ).read_text()
    page = (documentation / "index.html").read_text()
    assert all(f"<code>{name}</code>" in page for name in ("psi", "F_N", *ESTIMATE))


def test_libcosim_gives_the_same(unpacked: Unpacked, tmp_path: Path) -> None:
    cosim = pytest.importorskip("libcosimpy.CosimExecution", reason="pip install libcosimpy")
    from libcosimpy.CosimManipulator import CosimManipulator
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    archive = generate_fmu(EKF, tmp_path, DOUBLE, name="grip")
    execution = cosim.CosimExecution.from_step_size(step_size=10_000_000)
    slave = execution.add_local_slave(CosimLocalSlave(fmu_path=str(archive), instance_name="one"))
    seen, hand = CosimObserver.create_last_value(), CosimManipulator.create_override()
    execution.add_observer(observer=seen)
    execution.add_manipulator(manipulator=hand)
    outputs, rows = [], swinging(300)[:, :4]
    for row in rows:
        hand.slave_real_values(slave_index=slave, variable_references=[0, 1, 2, 3], values=list(row))
        execution.step()
        outputs.append(seen.last_real_values(slave_index=slave, variable_references=[4, 5, 6]))
    with instances(unpacked(EKF, DOUBLE)) as (ours,):
        expected = ours.steps(rows)[:, :3]

    # Its communication points are whole nanoseconds.
    np.testing.assert_allclose(outputs, expected, rtol=0, atol=1e-11)
