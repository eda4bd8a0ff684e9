"""The FMU of FMI 3.0 is valid, builds from its sources, and gives what that of 2.0 and libcosim give."""

import re
import shutil
import subprocess
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from observers import ESTIMATE, AligningTorque, Ekf, Mhe, SteeringTorque
from observers.embedded import DOUBLE, SINGLE, generate_fmu
from observers.embedded.fmu import is_host
from symbolic import InvalidInputError, compiler
from tests.observers.embedded.fmu_instance import instances
from tests.observers.embedded.generated_code import DECLARED, NO_COMPILER, STRICT, observer_of

fmpy = pytest.importorskip("fmpy", reason="FMPy is not installed: pip install 'brushgrip[dev]'")
FMICallException = pytest.importorskip("fmpy.fmi1").FMICallException
pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(compiler() is None, reason=NO_COMPILER),
    pytest.mark.skipif(not is_host(), reason="FMUs are built on Linux x86_64 alone"),
]
EKF = observer_of(Ekf, DECLARED, AligningTorque())
INPUTS = (0, 1, 2, 3)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The FMU, unpacked."""
    made = tmp_path_factory.mktemp("fmu3")
    return Path(fmpy.extract(str(generate_fmu(EKF, made, DOUBLE, version=3)), str(made / "unpacked")))


def rows(count: int = 300) -> np.ndarray:
    t = 0.01 * np.arange(count)
    made = np.column_stack([0.2 * np.sin(5 * t), t * np.nan, -8 * np.sin(5 * t), 400 + 0 * t])
    made[100:104, 2] = np.nan
    return made


class Instance3:
    """One instance, as `fmu_instance.Instance` is of FMI 2.0."""

    def __init__(self, slave: Any) -> None:
        """Wrap a slave."""
        self.slave, self.time = slave, 0.0

    def step(self, row: Sequence[float], dt: float = 0.01) -> list[float]:
        self.slave.setFloat64(INPUTS, list(row))
        *_, last = self.slave.doStep(currentCommunicationPoint=self.time, communicationStepSize=dt)
        self.time += dt
        assert last == pytest.approx(self.time) == self.slave.getFloat64([13])[0]
        return self.outputs()

    def steps(self, samples: np.ndarray) -> np.ndarray:
        return np.array([self.step(row) for row in samples])

    def outputs(self) -> list[float]:
        numbers = self.slave.getFloat64([4, 5, 6, 9, 10, 11, 12])
        flags, status = self.slave.getBoolean([7, 14]), self.slave.getInt32([8])
        return [*numbers[:3], *flags, *numbers[3:], *status]


@contextmanager
def instance(folder: Path, *, initialised: bool = True) -> Iterator[Instance3]:
    from fmpy.fmi3 import FMU3Slave

    description = fmpy.read_model_description(str(folder))
    slave = FMU3Slave(
        guid=description.guid, unzipDirectory=str(folder), instanceName="one",
        modelIdentifier=description.coSimulation.modelIdentifier,
    )  # fmt: skip
    slave.instantiate()
    if initialised:
        slave.enterInitializationMode(startTime=0.0)
        slave.exitInitializationMode()
    try:
        yield Instance3(slave)
    finally:
        slave.freeInstance()


@pytest.mark.parametrize(
    ("kind", "measurement_model"), [(Ekf, AligningTorque()), (Mhe, SteeringTorque())]
)
def test_fmpy_validates(tmp_path: Path, kind: Any, measurement_model: Any) -> None:
    from fmpy.validation import validate_fmu

    observer = observer_of(kind, DECLARED, measurement_model)
    archive = generate_fmu(observer, tmp_path, name="grip", version=3)
    description = fmpy.read_model_description(str(archive))

    assert validate_fmu(str(archive)) == []
    assert description.fmiVersion == "3.0"
    assert tuple(v.name for v in description.modelVariables if v.causality == "output") == ESTIMATE
    assert {v.unit for v in description.modelVariables if v.causality == "input"} <= {
        "rad", "rad/s", "N.m", "N",
    }  # fmt: skip
    assert set(fmpy.supported_platforms(str(archive))) == {"c-code", "linux64"}


def test_both_versions_give_the_same(folder: Path, tmp_path: Path) -> None:
    other = fmpy.extract(str(generate_fmu(EKF, tmp_path, DOUBLE)), str(tmp_path / "unpacked"))
    with instances(Path(other)) as (two,), instance(folder) as three:
        expected, seen = two.steps(rows()), three.steps(rows())

    np.testing.assert_array_equal(seen, expected)
    assert np.ptp(expected[:, 0]) > 0.01


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # FMPy's folder
def test_an_importer_builds_it_from_its_sources(folder: Path, tmp_path: Path) -> None:
    if shutil.which("cmake") is None:
        pytest.skip("no CMake installed")
    from fmpy.build import build_platform_binary

    built = tmp_path / "built"
    shutil.copytree(folder, built, ignore=shutil.ignore_patterns("binaries"))
    build_platform_binary(built, configuration="Release", generator="Unix Makefiles")
    with instance(folder) as ours, instance(built) as theirs:
        np.testing.assert_array_equal(theirs.steps(rows()), ours.steps(rows()))


def test_a_state_can_be_saved_and_transferred_and_damage_is_refused(folder: Path) -> None:
    with instance(folder) as one:
        one.steps(rows()[:200])
        kept, time = one.slave.getFMUState(), one.time
        sent = one.slave.serializeFMUState(kept)
        on = one.steps(rows()[200:])
        one.slave.setFMUState(kept)
        one.slave.freeFMUState(kept)
        one.time = time
        np.testing.assert_array_equal(one.steps(rows()[200:]), on)
    with instance(folder) as other:
        state = other.slave.deserializeFMUState(sent)
        other.slave.setFMUState(state)
        other.slave.freeFMUState(state)
        other.time = time
        np.testing.assert_array_equal(other.steps(rows()[200:]), on)
        for at in (*range(0, len(sent), 29), len(sent) - 1):
            with pytest.raises(FMICallException):
                other.slave.deserializeFMUState(bytes([*sent[:at], sent[at] ^ 4, *sent[at + 1 :]]))
        for damaged in (sent[:-8], sent + b"x", bytes(len(sent))):
            with pytest.raises(FMICallException):
                other.slave.deserializeFMUState(damaged)


def test_calls_out_of_order_are_errors(folder: Path) -> None:
    with instance(folder, initialised=False) as one:
        for call in (
            lambda: one.step([0.0] * 4),
            lambda: one.slave.exitInitializationMode(),
            lambda: one.slave.setFloat64([4], [1.0]),
            lambda: one.slave.getFloat64([7]),
            lambda: one.slave.getInt32([7]),
            lambda: one.slave.setInt32([8], [1]),
        ):
            with pytest.raises(FMICallException):
                call()


def test_interface_is_the_standards(folder: Path, tmp_path: Path) -> None:
    standard = Path(fmpy.__file__).parent / "c-code"
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
    folder: Path, tmp_path: Path, repository_root: Path, version: int
) -> None:
    if version == 2:
        folder = Path(fmpy.extract(str(generate_fmu(EKF, tmp_path, SINGLE)), str(tmp_path / "un")))
    documentation = folder / "documentation"

    assert (documentation / "licenses" / "license.txt").read_text() == (
        repository_root / "LICENSE"
    ).read_text()
    page = (documentation / "index.html").read_text()
    assert all(f"<code>{name}</code>" in page for name in ("psi", "F_N", *ESTIMATE))


def test_libcosim_gives_the_same(tmp_path: Path) -> None:
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
    outputs = []
    for row in rows():
        hand.slave_real_values(slave_index=slave, variable_references=list(INPUTS), values=list(row))
        execution.step()
        outputs.append(seen.last_real_values(slave_index=slave, variable_references=[4, 5, 6]))
    with instances(Path(fmpy.extract(str(archive), str(tmp_path / "unpacked")))) as (ours,):
        expected = ours.steps(rows())[:, :3]

    # Its communication points are whole nanoseconds.
    np.testing.assert_allclose(outputs, expected, rtol=0, atol=1e-11)
