"""The FMU: valid, the same as the C to the last bit, each instance on its own, its state to be had."""

import ctypes
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from identification import read_recording
from observers import AligningTorque, Ekf, Mhe, SteeringTorque
from observers.embedded import DOUBLE, SINGLE, Real, generate_fmu
from observers.embedded.fmu import is_host
from symbolic import InvalidInputError, Tyre
from symbolic.compiled import compiler
from tests.observers.conftest import RIG, K
from tests.observers.embedded.building import DECLARED, FOUND, NO_COMPILER, STRICT, observer_of
from tests.observers.embedded.conftest import Build
from tests.observers.embedded.driving import OUTPUTS, driven, initialise

fmpy = pytest.importorskip("fmpy", reason="FMPy is not installed: pip install 'brushgrip[dev]'")
FMICallException = pytest.importorskip("fmpy.fmi1").FMICallException
pytestmark = [
    pytest.mark.skipif(compiler() is None, reason=NO_COMPILER),
    pytest.mark.skipif(not is_host(), reason="FMUs are built on Linux x86_64 alone"),
]
Array = NDArray[np.float64]
Unpacked = Callable[[Any, Real], Path]
MASTER = Path(__file__).with_name("master.c")
STEP = 0.01
MISSING, NO_LOAD = 1, 2
CASES = [
    pytest.param(Ekf, DECLARED, SINGLE, id="ekf-float"),
    pytest.param(Ekf, DECLARED, DOUBLE, id="ekf-double"),
    pytest.param(Mhe, DECLARED, SINGLE, id="mhe-float"),
    pytest.param(Ekf, FOUND, DOUBLE, id="ekf-effects-double"),
]
EKF = observer_of(Ekf, DECLARED, AligningTorque())


@pytest.fixture(scope="module")
def unpacked(tmp_path_factory: pytest.TempPathFactory) -> Unpacked:
    """Generates an FMU and unpacks it, each once."""
    made: dict[Any, Path] = {}

    def once(observer: Any, real: Real) -> Path:
        key = (repr(observer), real)
        if key not in made:
            folder = tmp_path_factory.mktemp("fmu")
            made[key] = Path(fmpy.extract(generate_fmu(observer, folder, real), folder / "unpacked"))
        return made[key]

    return once


@pytest.fixture(scope="module")
def samples(repository_root: Path) -> Array:
    """An embedded recording, rows psi, psi_dot, M_z, F_N; now and then a sensor is silent."""
    path = repository_root / "examples" / "recordings" / "train_a.csv"
    made = read_recording(path, (RIG, Tyre(k=K, mu=1.2)))
    rows = np.column_stack([made.psi, np.full(made.t.size, np.nan), made.M_z, made.F_N])
    rows[8::9, 2] = np.nan
    rows[40:44, 0], rows[60:63, 3] = np.nan, -1.0
    return rows


@pytest.mark.parametrize(
    ("kind", "sensing"), [(Ekf, AligningTorque()), (Ekf, SteeringTorque()), (Mhe, AligningTorque())]
)
def test_fmpy_has_no_complaint(tmp_path: Path, kind: Any, sensing: Any) -> None:
    from fmpy.validation import validate_fmu

    observer = observer_of(kind, DECLARED, sensing)
    made = generate_fmu(observer, tmp_path, name="grip")
    described = fmpy.read_model_description(made)
    units = {v.name: v.unit for v in described.modelVariables if v.causality == "input"}
    ours = {"psi": "rad", "psi_dot": "rad/s", "M_z": "N.m", "F_N": "N"}

    assert validate_fmu(str(made)) == []
    assert units == ({"psi": "rad", "M": "N.m", "F_N": "N"} if "M" in sensing.channels else ours)
    assert tuple(v.name for v in described.modelVariables if v.causality == "output") == OUTPUTS
    assert fmpy.supported_platforms(str(made)) == ["c-code", "linux64"]


def test_the_same_observer_makes_the_same_bytes(tmp_path: Path) -> None:
    one, again, other = (
        generate_fmu(observer, tmp_path / folder)
        for folder, observer in (
            ("one", EKF),
            ("again", EKF),
            ("other", observer_of(Ekf, DECLARED, AligningTorque(), mu=0.9)),
        )
    )
    guids = {fmpy.read_model_description(made).guid for made in (one, again, other)}

    assert one.read_bytes() == again.read_bytes()
    assert len(guids) == 2


@pytest.mark.parametrize(("kind", "model", "real"), CASES)
def test_says_what_the_c_says(
    built: Build, unpacked: Unpacked, samples: Array, kind: Any, model: Any, real: Real
) -> None:
    observer = observer_of(kind, model, AligningTorque())
    rows = samples[:600] if model is FOUND else samples
    shown = shown_by_main(built, observer, real, rows)
    given = np.rec.fromarrays(
        [STEP * np.arange(len(rows)), *rows.T], names=["time", "psi", "psi_dot", "M_z", "F_N"]
    )
    said = fmpy.simulate_fmu(
        str(unpacked(observer, real)),
        stop_time=STEP * len(rows),
        output_interval=STEP,
        input=given,
        output=OUTPUTS,
    )

    assert len(said) == len(shown) + 1
    # What is said of a sample stands at the end of its step.
    for name in OUTPUTS[:4]:
        np.testing.assert_array_equal(said[name][1:].astype(real.dtype), shown[name].astype(real.dtype))
    assert np.ptp(said["mu"]) > 0.1
    assert (said["status"][1:][rows[:, 3] < 0] & NO_LOAD).all()


def shown_by_main(built: Build, observer: Any, real: Real, rows: Array) -> Array:
    """What the generated example prints of samples."""
    code = built(observer, real)
    table = "\n".join(",".join(repr(float(v)) for v in (STEP * i, *row)) for i, row in enumerate(rows))
    (code.folder / "given.csv").write_text(f"t,psi,psi_dot,M_z,F_N\n{table}\n")
    made = code.compile("-O1", sources=("brushgrip.c", "main.c"), out="example")
    printed = subprocess.run(
        [made, "given.csv"], cwd=code.folder, capture_output=True, text=True, check=True
    )
    return np.genfromtxt(printed.stdout.splitlines(), delimiter=",", names=True)


def test_steps_may_vary(built: Build, unpacked: Unpacked, samples: Array) -> None:
    steps = np.random.default_rng(4).uniform(0.002, 0.05, 300)
    # The time of a sample is that since the one before it, which the first does not have.
    since = np.concatenate([steps[:1], steps[:-1]])
    expected = built(EKF, DOUBLE).follow(np.column_stack([samples[:300], since]))
    with driven(unpacked(EKF, DOUBLE)) as (one,):
        said = [one.step(row, dt) for row, dt in zip(samples, steps, strict=False)]

    np.testing.assert_allclose(said, expected, rtol=0, atol=1e-9)
    assert np.ptp(expected[:, 0]) > 0.01


def test_two_at_once_do_not_disturb_each_other(unpacked: Unpacked, samples: Array) -> None:
    folder, rows = unpacked(EKF, SINGLE), samples[:400]
    with driven(folder) as (one,):
        alone = one.steps(rows)
    with driven(folder) as (one,):
        alone_backwards = one.steps(rows[::-1])
    with driven(folder, 2) as (one, two):
        both = [(one.step(a), two.step(b)) for a, b in zip(rows, rows[::-1], strict=True)]

    np.testing.assert_array_equal([a for a, _ in both], alone)
    np.testing.assert_array_equal([b for _, b in both], alone_backwards)
    assert np.abs(alone - alone_backwards)[:, 0].max() > 1e-3


def test_reset_forgets(unpacked: Unpacked, samples: Array) -> None:
    with driven(unpacked(EKF, SINGLE)) as (one,):
        before, first = one.said(), one.steps(samples[:200])
        one.slave.reset()
        np.testing.assert_array_equal(one.said(), before)
        initialise(one.slave)
        np.testing.assert_array_equal(one.steps(samples[:200]), first)


@pytest.mark.parametrize("kind", [Ekf, Mhe])
def test_a_state_can_be_kept_and_sent(unpacked: Unpacked, samples: Array, kind: Any) -> None:
    folder = unpacked(observer_of(kind, DECLARED, AligningTorque()), SINGLE)
    with driven(folder) as (one,):
        one.steps(samples[:200])
        kept, time, said = one.slave.getFMUState(), one.time, one.said()
        sent = one.slave.serializeFMUState(kept)
        on = one.steps(samples[200:300])
        one.slave.setFMUState(kept)
        one.slave.freeFMUState(kept)
        one.time = time
        np.testing.assert_array_equal(one.said(), said)
        np.testing.assert_array_equal(one.steps(samples[200:300]), on)
    with driven(folder, state=sent) as (other,):
        state = other.slave.deserializeFMUState(sent)
        other.slave.setFMUState(state)
        other.slave.freeFMUState(state)
        other.time = time
        np.testing.assert_array_equal(other.steps(samples[200:300]), on)
        with pytest.raises(FMICallException):
            other.slave.deserializeFMUState(b"x" + sent[1:])


def test_what_a_sensor_does_not_give_is_flagged(unpacked: Unpacked) -> None:
    good = [0.05, 0.0, -1.0, 400.0]
    with driven(unpacked(EKF, SINGLE)) as (one,):
        # Nobody has set an input yet.
        one.slave.doStep(currentCommunicationPoint=-0.01, communicationStepSize=0.01)
        assert one.said()[4] == MISSING
        one.step(good)
        for at, expected in ((0, 3), (2, MISSING), (3, NO_LOAD)):
            for nothing in (np.nan, np.inf, 1e30):
                said = one.step([nothing if i == at else v for i, v in enumerate(good)])
                assert np.isfinite(said).all()
                assert said[4] == expected
        assert one.step(good)[4] == 0


def test_calls_out_of_order_are_refused(unpacked: Unpacked) -> None:
    with driven(unpacked(EKF, SINGLE), 2, state="none") as (one, other):
        for call in (
            lambda: one.step([0.0] * 4),
            lambda: one.slave.exitInitializationMode(),
            lambda: one.slave.setReal([4], [1.0]),
            lambda: one.slave.getReal([7]),
            lambda: one.slave.setInteger([8], [1]),
        ):
            with pytest.raises(FMICallException):
                call()
        initialise(other.slave)
        with pytest.raises(FMICallException):
            other.step([0.0] * 4, dt=0.0)
        other.slave.terminate()


def test_sources_build_without_a_word(unpacked: Unpacked, tmp_path: Path) -> None:
    for kind, real in ((Ekf, SINGLE), (Mhe, DOUBLE)):
        folder = unpacked(observer_of(kind, DECLARED, AligningTorque()), real) / "sources"
        files = [folder / "brushgrip.c", folder / "brushgrip_fmu.c"]
        for prefix in ("", "grip_"):
            made = tmp_path / f"{prefix}{kind.__name__}.so"
            given = [f"-DFMI2_FUNCTION_PREFIX={prefix}"] if prefix else []
            command = [str(compiler()), *STRICT, *given, "-O1", "-fPIC", "-shared", *files]
            subprocess.run([*command, "-o", made, "-lm"], check=True)
            assert hasattr(ctypes.CDLL(str(made)), f"{prefix}fmi2DoStep")


@pytest.mark.parametrize("kind", [Ekf, Mhe])
def test_sanitisers_find_nothing(unpacked: Unpacked, tmp_path: Path, kind: Any) -> None:
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


def test_without_a_compiler_there_is_one_line(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("observers.embedded.fmu.compiler", lambda: None)
    with pytest.raises(InvalidInputError, match="needs a C compiler") as told:
        generate_fmu(EKF, tmp_path / "none")

    assert "\n" not in str(told.value)
    assert not (tmp_path / "none").exists()
