import json
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

from observers import Ekf, from_files
from observers.embedded import generate
from observers.embedded.fmu import is_supported_host
from symbolic import InvalidInputError, compiler
from tests.brushgrip.helpers import Outcome, Run, table_of, with_defaults, write_model

pytestmark = pytest.mark.usefixtures("interpreted")
NEEDS_COMPILER = pytest.mark.skipif(compiler() is None, reason="no C compiler at hand")
NEEDS_HOST = pytest.mark.skipif(not is_supported_host(), reason="FMUs are built on Linux x86_64 alone")
GENERATED = ["grip.c", "grip.h", "grip.hpp", "grip.json", "grip_vector.csv", "grip_sfun.c"]
FILES = ["CMakeLists.txt", "check.c", "main.c", *GENERATED]


@pytest.fixture
def out(tmp_path: Path) -> Path:
    """The folder that the command writes to."""
    return tmp_path / "c"


@pytest.fixture
def codegen(run: Run, rig: Path, out: Path) -> Run:
    """The command for an EKF; an option given again goes before its default."""
    usual = ("--rig", rig, "--observer", "ekf", "--out", out, "--name", "grip")
    return lambda *options: run("codegen", *with_defaults(usual, options))


def test_that_directions_differ_is_told_beside_the_code(codegen: Run, out: Path) -> None:
    assert "less than mu_eff" not in codegen("--model", write_model()).out
    unlike = write_model({"asymmetric_friction.ratio": 0.85})

    assert "8 % less than mu_eff turning to positive psi: " in codegen("--model", unlike).out
    share = (out / "grip.h").read_text().partition("#define GRIP_WEAKER ")[2].split()[0]
    assert float(share.removesuffix("f")) == pytest.approx(0.15 / 1.85)


@NEEDS_COMPILER
@NEEDS_HOST
def test_writes_an_fmu(codegen: Run, out: Path) -> None:
    outcome = codegen("--target", "fmu")
    with zipfile.ZipFile(out / "grip.fmu") as archive:
        names = set(archive.namelist())

    assert outcome.status == 0
    assert [path.name for path in (out).iterdir()] == ["grip.fmu"]
    assert {"modelDescription.xml", "binaries/linux64/grip.so", "sources/grip_fmu.c"} < names


@NEEDS_HOST
def test_an_fmu_needs_a_compiler(codegen: Run, out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("observers.embedded.fmu.compiler", lambda: None)

    codegen("--target", "fmu").refused("needs a C compiler")
    assert not (out).exists()


@NEEDS_COMPILER
@pytest.mark.usefixtures("steering_rig")
@pytest.mark.parametrize("torque", ["M_z", pytest.param("M", marks=pytest.mark.long), "model"])
def test_builds_and_agrees_with_python(codegen: Run, out: Path, tmp_path: Path, torque: str) -> None:
    if (cmake := shutil.which("cmake")) is None:
        pytest.skip("no cmake at hand")
    found = ["--torque", torque]
    if torque == "model":
        # As the demo finds it: bristles behind a compliance, which magnify rounding.
        values = {"k": 2489596.07, "rate_friction.c": 0.04043781, "carcass_torsion.k_t": 388.2496}
        found = ["--model", write_model(values)]
    assert codegen(*found).status == 0
    strict = "-DCMAKE_C_FLAGS=-Wall -Wextra -Wconversion -Wdouble-promotion -Werror"
    for command in (["-S", "c", "-B", "b", strict], ["--build", "b"]):
        subprocess.run([cmake, *command], cwd=tmp_path, check=True, capture_output=True)

    def told(program: str, content: str) -> Outcome:
        (tmp_path / "given.csv").write_text(content)
        command = [tmp_path / "b" / program, tmp_path / "given.csv"]
        done = subprocess.run(command, capture_output=True, text=True)
        return Outcome(done.returncode, done.stdout, done.stderr)

    vector = (out / "grip_vector.csv").read_text()
    checked, wrong = told("check", vector), vector.replace(",1.0", ",1.1")
    assert checked.status == 0, checked
    assert "400 samples" in checked.out
    assert "the same as in Python" in checked.out
    assert told("check", wrong).status == 1
    cut = wrong[: wrong.rindex(",")]
    for line, foreign in ((1, "t,psi,M_z,F_N\n0,0,0,400\n"), (wrong.count("\n"), cut), (0, "")):
        said = f"given.csv: line {line} is none of a grip_vector.csv; give the one"
        told("check", foreign).refused(said)
    german = told("example", "Zeit;Winkel\n0,0;0,1\n")
    assert (german.status, german.out.count("\n")) == (2, 1)
    assert "names no column t;" in german.err
    loadless = told("example", "t,psi,M_z,M\n0,0,0,0\n").err
    assert "names no column F_N;" in loadless
    assert "needs a column too, with its value [N] in every row" in loadless


@NEEDS_COMPILER
def test_example_is_as_estimate(codegen: Run, run: Run, tmp_path: Path, repository_root: Path) -> None:
    folder = repository_root / "examples" / "recordings"
    rig, recording = folder / "rig.toml", folder / "train_a.csv"
    codegen("--rig", rig, "--out", tmp_path, "--real", "double")
    run("estimate", "--rig", rig, "--observer", "ekf", recording, "--out", tmp_path / "mu.csv")
    sources = [tmp_path / "grip.c", tmp_path / "main.c"]
    command = [str(compiler()), "-O1", "-ffp-contract=off", *sources, "-o", tmp_path / "example", "-lm"]
    subprocess.run(command, check=True)
    shown = subprocess.run([tmp_path / "example", recording], capture_output=True, text=True, check=True)
    (tmp_path / "shown.csv").write_text(shown.stdout)
    ours, theirs = (table_of(tmp_path / f"{name}.csv") for name in ("shown", "mu"))

    assert [*ours] == [*theirs]
    for name in theirs:
        np.testing.assert_allclose(ours[name], theirs[name], rtol=0, atol=1e-9, err_msg=name)


def test_says_what_a_step_costs(codegen: Run, out: Path) -> None:
    cost, header = json.loads(codegen("--json").out)["cost"], (out / "grip.h").read_text()

    assert f"One observer, {cost['state_bytes']} bytes" in header
    assert (cost["instructions"], cost["vectors"]) == (2700, False)
    corners = cost["most_corners"] - cost["corners"]
    assert cost["at_most"] > cost["instructions"] + cost["corner"] * corners
    alone = ("--observer", "mhe", "--window", "1")
    said = codegen(*alone).out.splitlines()
    assert "more than 100,000 instructions of a Cortex-M4F a step: an MHE of two samples" in said[0]
    assert "the rig file's mu = 1.2 is not used, --tune mu=1.2" in said[1]
    assert "a tenth of it spread evenly from ice on: until friction is acquired" in said[1]


@NEEDS_COMPILER
def test_acquisition_left_out_as_in_python(codegen: Run, rig: Path, out: Path, tmp_path: Path) -> None:
    def made(*options: str) -> tuple[bool, int]:
        told = codegen("--json", *options).out
        acquire = json.loads((out / "grip.json").read_text())["acquire"]
        return acquire, json.loads(told)["cost"]["at_most"]

    (usual, most), (acquire, less) = made(), made("--no-acquire")
    assert (usual, acquire, less < most / 2) == (True, False, True)
    assert "from which friction is followed without acquisition" in codegen("--no-acquire").out
    generate(from_files(Ekf, rig, acquire=False), tmp_path / "python", name="grip")
    for name in ("grip.json", "grip_vector.csv"):
        assert (out / name).read_text() == (tmp_path / "python" / name).read_text()
    sources = [out / "grip.c", out / "check.c"]
    command = [str(compiler()), "-O1", "-ffp-contract=off", *sources, "-o", tmp_path / "check", "-lm"]
    subprocess.run(command, check=True)
    check = [tmp_path / "check", out / "grip_vector.csv"]
    checked = subprocess.run(check, capture_output=True, text=True)
    assert "the same as in Python" in checked.stdout


def test_k_may_be_a_state(codegen: Run, out: Path) -> None:
    fixed = json.loads(codegen("--json").out)["cost"]
    cost = json.loads(codegen("--stiffness-state", "--json").out)["cost"]

    assert fixed["instructions"] < cost["instructions"] < 1.5 * fixed["instructions"]
    assert "stiffness" in (out / "grip.c").read_text()
    refused = codegen("--stiffness-state", "--torque", "M")
    assert (refused.status, "needs M_z of a wheel" in refused.err) == (2, True)


def test_whoever_reads_the_first_line_alone_has_the_files(rig: Path, out: Path) -> None:
    command = [sys.executable, "-m", "brushgrip", "codegen", "--rig", str(rig), "--observer", "ekf"]
    command += ["--out", str(out), "--name", "grip"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        line = process.stdout.readline()
        process.stdout.close()

    assert "instructions of a Cortex-M4F a step" in line
    assert sorted(path.name for path in out.iterdir()) == sorted(FILES)


def test_tuning_and_window_are_in_the_code(codegen: Run, out: Path) -> None:
    tuned = ("--tune", "mu=0.7,psi_limit=2", "--observer", "mhe", "--window", "12")
    assert codegen(*tuned).status == 0
    parameters = json.loads((out / "grip.json").read_text())

    assert (parameters["beliefs"]["mu"], parameters["beliefs"]["psi_limit"]) == (0.7, 2.0)
    assert parameters["settings"]["window"] == 12
    vector = (out / "grip_vector.csv").read_text().splitlines()
    assert ",0.7,0.5," in vector[-400]


def test_what_is_tuned_by_hand_goes_before_the_error_of_the_model(codegen: Run, out: Path) -> None:
    error = {"spread": 0.02, "correlation_time": 1.0}
    by_hand = ("--tune", "error=0.2,explained=7")
    assert codegen("--model", write_model(model_error=error), *by_hand).status == 0
    tuning = json.loads((out / "grip.json").read_text())["beliefs"]

    assert (tuning["error"], tuning["explained"]) == (0.2, 7.0)
    assert tuning["noise"] == pytest.approx(0.002)


def test_a_folder_of_a_diagnosis_is_its_model(codegen: Run, out: Path) -> None:
    assert codegen("--model", write_model({"k": 2.1e6}).parent).status == 0
    parameters = json.loads((out / "grip.json").read_text())

    assert parameters["parameters"]["k"]["value"] == 2.1e6


class TestReplacing:
    """What is in the folder already."""

    @pytest.fixture(autouse=True)
    def there(self, out: Path) -> None:
        out.mkdir()

    def test_a_link_that_leads_nowhere_stays(self, codegen: Run, out: Path) -> None:
        (out / "main.c").symlink_to("elsewhere")

        assert codegen().status == 2
        assert [entry.name for entry in out.iterdir()] == ["main.c"]

    def test_files_of_an_earlier_codegen_are_renewed(self, codegen: Run, out: Path) -> None:
        (out / "notes.txt").write_text("mine")
        assert codegen("--name", "other").status == 0
        assert codegen().status == 0
        assert codegen("--real", "double", "--target", "c").status == 0
        parameters = json.loads((out / "grip.json").read_text())
        others = [name.replace("grip", "other") for name in GENERATED]

        assert sorted(path.name for path in out.iterdir()) == sorted([*FILES, *others, "notes.txt"])
        assert parameters["real"] == "double"
        assert parameters["parameters"]["k"] == {"value": 2.4e6, "unit": "N/m^2"}
        assert parameters["version"] in (out / "grip.h").read_text()
        assert '"grip.h"' in (out / "main.c").read_text()

    @pytest.mark.long
    @NEEDS_COMPILER
    @NEEDS_HOST
    def test_an_fmu_is_known_by_its_content(self, codegen: Run, out: Path) -> None:
        fmu = out / "grip.fmu"
        with zipfile.ZipFile(fmu, "w") as archive:
            archive.writestr("modelDescription.xml", '<fmiModelDescription generationTool="another">')
        for other in (fmu.read_bytes(), b"no archive", b""):
            fmu.write_bytes(other)
            outcome = codegen("--target", "fmu")
            assert outcome.status == 2
            assert "grip.fmu: is in the way" in outcome.err
            assert outcome.err.count("\n") == 1
            assert fmu.read_bytes() == other

        fmu.unlink()
        assert codegen("--target", "fmu").status == 0
        first = fmu.read_bytes()
        assert codegen("--target", "fmu", "--real", "double").status == 0
        assert fmu.read_bytes() != first

    def test_python_replaces_no_more_than_the_command(self, rig: Path, out: Path) -> None:
        (out / "main.c").write_text("mine")
        with pytest.raises(InvalidInputError, match=r"main\.c: is in the way"):
            generate(from_files(Ekf, rig), out)

        assert [entry.name for entry in out.iterdir()] == ["main.c"]


def test_parameters_at_run_time_are_described_and_an_earlier_description_goes(
    codegen: Run, out: Path
) -> None:
    outcome = codegen("--tunable", "tuning")

    assert outcome.status == 0, outcome.err
    assert "CHARACTERISTIC grip.noise" in (out / "grip.a2l").read_text()
    assert "grip.k " not in (out / "grip.a2l").read_text()
    outcome = codegen()
    assert outcome.status == 0, outcome.err
    assert not (out / "grip.a2l").exists()
    assert "removed grip.a2l" in outcome.out + outcome.err
