"""FMUs: valid, equal to the C to the last bit, with independent instances and accessible states."""

import ctypes
import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from identification import read_recording
from observers import ESTIMATE, AligningTorque, Ekf, Mhe, Status, SteeringTorque
from observers.embedded import DOUBLE, SINGLE, Real, generate_fmu
from observers.embedded.fmu import is_supported_host
from symbolic import InvalidInputError, Tyre, compiler
from symbolic.float_array_type import Array
from symbolic.rig_and_tyre import STIFFNESS
from tests.observers.conftest import RIG, K
from tests.observers.embedded.conftest import Generate, Unpacked
from tests.observers.embedded.fmu_instance import instances
from tests.observers.embedded.generated_code import (
    DECLARED,
    EFFECTS,
    FEW_BRISTLES,
    STRICT,
    needs_compiler,
    observer_of,
    python_estimates,
    swinging,
)

fmpy = pytest.importorskip("fmpy", reason="FMPy is not installed: pip install 'brushgrip[dev]'")
FMICallException = pytest.importorskip("fmpy.fmi1").FMICallException
pytestmark = [
    pytest.mark.long,
    needs_compiler,
    pytest.mark.skipif(not is_supported_host(), reason="FMUs are built on Linux x86_64 alone"),
]
MASTER = Path(__file__).with_name("master.c")
STEP = 0.01
CASES = [
    pytest.param(Ekf, DECLARED, SINGLE, id="ekf-float"),
    pytest.param(Ekf, DECLARED, DOUBLE, id="ekf-double"),
    pytest.param(Mhe, DECLARED, SINGLE, id="mhe-float"),
    pytest.param(Ekf, FEW_BRISTLES, DOUBLE, id="ekf-effects-few-double"),
    pytest.param(Ekf, EFFECTS, DOUBLE, id="ekf-effects-double", marks=pytest.mark.long),
]
EKF = observer_of(Ekf, DECLARED, AligningTorque())
versions = pytest.mark.parametrize("version", [2, 3])


@pytest.fixture(scope="module")
def samples(repository_root: Path) -> Array:
    """An embedded recording, rows psi, psi_dot, M_z, F_N; some values are missing."""
    path = repository_root / "examples" / "recordings" / "train_a.csv"
    recording = read_recording(path, (RIG, Tyre(k=K, mu=1.2)))
    silent = np.full(recording.t.size, np.nan)
    rows = np.column_stack([recording.psi, silent, recording.M_z, recording.F_N])
    rows[8::9, 2] = np.nan
    rows[40:44, 0], rows[60:63, 3] = np.nan, -1.0
    return rows


@versions
@pytest.mark.parametrize(
    ("kind", "measurement_model"),
    [(Ekf, AligningTorque()), (Ekf, SteeringTorque()), (Mhe, SteeringTorque())],
)
def test_fmpy_validates(tmp_path: Path, kind: Any, measurement_model: Any, version: int) -> None:
    from fmpy.validation import validate_fmu

    observer = observer_of(kind, DECLARED, measurement_model)
    archive = generate_fmu(observer, tmp_path, name="grip", version=version)
    description = fmpy.read_model_description(str(archive))
    units = {v.name: v.unit for v in description.modelVariables if v.causality == "input"}
    outputs = tuple(v.name for v in description.modelVariables if v.causality == "output")
    ours = {"psi": "rad", "psi_dot": "rad/s", "M_z": "N.m", "F_N": "N"}
    steered = {"psi": "rad", "M": "N.m", "F_N": "N"}

    assert validate_fmu(str(archive)) == []
    assert description.fmiVersion == f"{version}.0"
    assert units == (steered if "M" in measurement_model.channels else ours)
    assert outputs == (*ESTIMATE, "weaker")
    assert set(fmpy.supported_platforms(str(archive))) == {"c-code", "linux64"}


def test_the_same_observer_makes_the_same_bytes(tmp_path: Path) -> None:
    changed = observer_of(Ekf, DECLARED, AligningTorque(), mu=0.9)
    observers = {"one": EKF, "again": EKF, "other": changed}
    one, again, other = (generate_fmu(observers[name], tmp_path / name) for name in observers)
    guids = {fmpy.read_model_description(archive).guid for archive in (one, again, other)}

    assert one.read_bytes() == again.read_bytes()
    assert len(guids) == 2


@pytest.mark.parametrize(("kind", "model", "real"), CASES)
def test_equals_the_c(
    generated: Generate, unpacked: Unpacked, samples: Array, kind: Any, model: Any, real: Real
) -> None:
    observer = observer_of(kind, model, AligningTorque())
    rows = samples[:600] if model is not DECLARED else samples
    printed_rows = printed_by_main(generated, observer, real, rows)
    names = ["time", "psi", "psi_dot", "M_z", "F_N"]
    given = np.rec.fromarrays([STEP * np.arange(len(rows)), *rows.T], names=names)
    simulated = {"stop_time": STEP * len(rows), "output_interval": STEP, "output": ESTIMATE}
    estimates = fmpy.simulate_fmu(str(unpacked(observer, real)), input=given, **simulated)

    assert len(estimates) == len(printed_rows) + 1
    # The estimate of a sample is the output at the end of its step.
    for name in ESTIMATE:
        ours, theirs = (seen.astype(real.dtype) for seen in (estimates[name][1:], printed_rows[name]))
        np.testing.assert_array_equal(ours, theirs)
    assert np.ptp(estimates["mu"]) > 0.1
    assert (estimates["status"][1:][rows[:, 3] < 0] & Status.HELD).all()


def printed_by_main(generated: Generate, observer: Any, real: Real, rows: Array) -> Array:
    """The estimates that the generated example prints."""
    code = generated(observer, real)
    table = "\n".join(",".join(repr(float(v)) for v in (STEP * i, *row)) for i, row in enumerate(rows))
    (code.folder / "given.csv").write_text(f"t,psi,psi_dot,M_z,F_N\n{table}\n")
    program = code.compile("-O1", sources=("brushgrip.c", "main.c"), out="example")
    caught = {"capture_output": True, "text": True, "check": True}
    printed = subprocess.run([program, "given.csv"], cwd=code.folder, **caught)
    return np.genfromtxt(printed.stdout.splitlines(), delimiter=",", names=True)


def test_steps_may_vary(generated: Generate, unpacked: Unpacked, samples: Array) -> None:
    steps = np.random.default_rng(4).uniform(0.002, 0.05, 300)
    # The time of a sample is that since the one before it, which the first does not have.
    since = np.concatenate([steps[:1], steps[:-1]])
    expected = generated(EKF, DOUBLE).run(np.column_stack([samples[:300], since]))
    with instances(unpacked(EKF, DOUBLE)) as (one,):
        estimates = [one.step(row, dt) for row, dt in zip(samples, steps, strict=False)]

    np.testing.assert_allclose(estimates, expected, rtol=0, atol=1e-9)
    assert np.ptp(expected[:, 0]) > 0.01


def test_two_instances_are_independent(unpacked: Unpacked, samples: Array) -> None:
    folder, rows = unpacked(EKF, SINGLE), samples[:400]
    with instances(folder) as (one,):
        alone = one.steps(rows)
    with instances(folder) as (one,):
        alone_backwards = one.steps(rows[::-1])
    with instances(folder, 2) as (one, two):
        both = [(one.step(a), two.step(b)) for a, b in zip(rows, rows[::-1], strict=True)]

    np.testing.assert_array_equal([a for a, _ in both], alone)
    np.testing.assert_array_equal([b for _, b in both], alone_backwards)
    assert np.abs(alone - alone_backwards)[:, 0].max() > 1e-3


def test_reset_returns_to_the_prior(unpacked: Unpacked, samples: Array) -> None:
    with instances(unpacked(EKF, SINGLE)) as (one,):
        before, first = one.outputs(), one.steps(samples[:200])
        one.slave.reset()
        np.testing.assert_array_equal(one.outputs(), before)
        one.initialise()
        np.testing.assert_array_equal(one.steps(samples[:200]), first)


@pytest.mark.parametrize(("kind", "version"), [(Ekf, 2), (Mhe, 2), (Ekf, 3)])
def test_states_are_transferred(unpacked: Unpacked, samples: Array, kind: Any, version: int) -> None:
    folder = unpacked(observer_of(kind, DECLARED, AligningTorque()), SINGLE, version)
    with instances(folder, 2) as (one, other):
        one.steps(samples[:200])
        kept, time, estimates, sent = one.slave.getFMUState(), one.time, one.outputs(), one.saved()
        on = one.steps(samples[200:300])
        one.slave.setFMUState(kept)
        one.slave.freeFMUState(kept)
        one.time = time
        np.testing.assert_array_equal(one.outputs(), estimates)
        np.testing.assert_array_equal(one.steps(samples[200:300]), on)
        other.restore(sent, time)
        np.testing.assert_array_equal(other.steps(samples[200:300]), on)


@versions
def test_damaged_states_are_refused(unpacked: Unpacked, samples: Array, version: int) -> None:
    with instances(unpacked(EKF, SINGLE, version)) as (one,):
        one.steps(samples[:100])
        sent = one.saved()
        flipped = (
            bytes([*sent[:at], sent[at] ^ 0x10, *sent[at + 1 :]])
            for at in (*range(0, len(sent), 17), len(sent) - 1)
        )
        for damaged in (*flipped, sent[:-8], sent[:-1], sent + b"x", bytes(len(sent))):
            with pytest.raises(FMICallException):
                one.slave.deserializeFMUState(damaged)
        one.restore(sent, one.time)


def test_inputs_that_nobody_has_set_are_missing(unpacked: Unpacked) -> None:
    with instances(unpacked(EKF, SINGLE)) as (one,):
        one.slave.doStep(currentCommunicationPoint=-0.01, communicationStepSize=0.01)

        assert one.outputs()[-1] == Status.MISSING


@versions
def test_calls_out_of_order_are_errors(unpacked: Unpacked, version: int) -> None:
    with instances(unpacked(EKF, SINGLE, version), 2, initialised=False) as (one, other):
        other.initialise()
        for call in (
            lambda: one.step([0.0] * 4),
            lambda: one.slave.exitInitializationMode(),
            lambda: one.set([4], [1.0]),
            lambda: one.get([7]),
            lambda: one.integers([7]),
            lambda: one.set_integers([8], [1]),
            lambda: other.step([0.0] * 4, dt=0.0),
        ):
            with pytest.raises(FMICallException):
                call()
        other.slave.terminate()


def test_sources_compile_without_a_warning(unpacked: Unpacked, tmp_path: Path) -> None:
    for kind, real in ((Ekf, SINGLE), (Mhe, DOUBLE)):
        folder = unpacked(observer_of(kind, DECLARED, AligningTorque()), real) / "sources"
        core = tmp_path / f"{kind.__name__}.o"
        command = [str(compiler()), *STRICT, "-O1", "-fPIC"]
        subprocess.run([*command, "-c", folder / "brushgrip.c", "-o", core], check=True)
        for prefix in ("", "grip_"):
            library = tmp_path / f"{prefix}{kind.__name__}.so"
            options = [f"-DFMI2_FUNCTION_PREFIX={prefix}"] if prefix else []
            files = [folder / "brushgrip_fmu.c", core]
            subprocess.run([*command, *options, "-shared", *files, "-o", library, "-lm"], check=True)
            assert hasattr(ctypes.CDLL(str(library)), f"{prefix}fmi2DoStep")


@pytest.mark.parametrize("kind", [Ekf, Mhe])
def test_sanitisers_have_no_finding(unpacked: Unpacked, tmp_path: Path, kind: Any) -> None:
    folder = unpacked(observer_of(kind, DECLARED, AligningTorque()), SINGLE)
    guid = fmpy.read_model_description(folder).guid
    files = [folder / "sources" / "brushgrip.c", folder / "sources" / "brushgrip_fmu.c"]
    flags = ["-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all", f'-DGUID="{guid}"']
    command = [str(compiler()), *flags, f"-I{folder / 'sources'}", *files, MASTER, "-o", tmp_path / "m"]
    try:
        subprocess.run([*command, "-lm"], check=True, capture_output=True)
    except subprocess.CalledProcessError as error:
        if b"undefined reference" in error.stderr or b"cannot find" in error.stderr:
            pytest.skip("the compiler has no sanitisers")
        raise
    seen = subprocess.run([tmp_path / "m"], capture_output=True, text=True)

    assert seen.returncode == 0, seen.stdout + seen.stderr
    assert seen.stderr == ""


def test_parameters_can_be_tuned(tmp_path: Path, samples: Array) -> None:
    other = replace(EKF, tuning=replace(EKF.tuning, mu=0.7, noise=0.03), values={"k": 1.2 * K})
    archive = generate_fmu(EKF, tmp_path, DOUBLE, tunable="all")
    folder = Path(fmpy.extract(archive, tmp_path / "unpacked"))
    description = fmpy.read_model_description(str(folder))
    places = {v.name: v.valueReference for v in description.modelVariables if v.causality == "parameter"}
    named = {"parameters.k": 1.2 * K, "parameters.mu": 0.7, "parameters.noise": 0.03}
    rows = np.column_stack([samples[:100, :], np.full(100, 0.01)])
    with instances(folder, 2) as (usual, tuned):
        tuned.set([places[name] for name in named], list(named.values()))
        with pytest.raises(FMICallException):
            tuned.set([places["parameters.k"], places["parameters.mu"]], [2e6, 9.0])

        assert tuned.get([places["parameters.k"]]) == [1.2 * K]
        for one, observer in ((usual, EKF), (tuned, other)):
            expected = python_estimates(observer, rows)
            np.testing.assert_allclose(one.steps(samples[:100]), expected, rtol=1e-6, atol=1e-7)


@versions
def test_parameters_have_units_and_ranges(tmp_path: Path, version: int) -> None:
    archive = generate_fmu(EKF, tmp_path, SINGLE, version=version, tunable="all")
    description = fmpy.read_model_description(str(archive))
    named = {v.name: v for v in description.modelVariables if v.causality == "parameter"}
    k, zero_walk = named["parameters.k"], named["parameters.zero_walk"]
    bases = {unit.name: unit.baseUnit for unit in description.unitDefinitions}
    stiffness = bases["N/m^2"]

    assert all(variable.unit in bases and variable.min is not None for variable in named.values())
    assert (k.unit, float(k.min), float(k.max)) == ("N/m^2", *STIFFNESS)
    assert (stiffness.kg, stiffness.m, stiffness.s) == (1, -1, -2)
    assert zero_walk.unit == "1/sqrt(s)"
    assert float(named["parameters.mu"].min) > 0
    assert named["parameters.gate"].max is None
    for variable in named.values():
        assert float(variable.min) <= float(variable.start)


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
def test_licence_and_pages_are_inside(unpacked: Unpacked, repository_root: Path, version: int) -> None:
    folder = unpacked(EKF, DOUBLE, version)
    documentation = folder / "documentation"

    licence = documentation / "licenses" / "license.txt"
    assert licence.read_text() == (repository_root / "LICENSE").read_text()
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
