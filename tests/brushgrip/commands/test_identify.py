import json
import re
import tomllib
from pathlib import Path
from typing import Any

import pytest

from identification import read_rig
from identification.free_decay.stiffness_and_damping_by_likelihood import identify_free_decay
from reference_rig import THESIS_DAMPING as B_T
from reference_rig import THESIS_TYRE as TYRE
from reference_rig import impact_rig_toml, make_impacts, write_impacts
from tests.brushgrip.helpers import Run, contents

LENGTHS = (0.036, 0.050)


@pytest.fixture
def struck(tmp_path: Path) -> list[Path]:
    """Two impacts at each of two contact lengths."""
    folder = tmp_path / "impacts"
    folder.mkdir()
    return write_impacts(folder, make_impacts(2, lengths=LENGTHS, impacts=2, duration=1.2))


@pytest.fixture
def rig(tmp_path: Path) -> Path:
    path = tmp_path / "rig.toml"
    toleranced = r"\1 = { value = \2, tolerance = 0 }"
    exact = re.sub(r"^([ae]) = (\S+)", toleranced, impact_rig_toml(), flags=re.M)
    path.write_text(exact)
    return path


def test_identifies(run: Run, rig: Path, struck: list[Path]) -> None:
    out = Path("new/id.json")
    written = Path("identified.toml")
    arguments = ["--rig", rig, "--free-decay", *struck, "--out", out, "--write-rig", written]
    outcome = run("identify", *arguments)
    content = json.loads(out.read_text())
    declared, found = tomllib.loads(rig.read_text()), tomllib.loads(written.read_text())

    assert outcome.status == 0
    assert found["tyre"]["k"]["value"] == content["k"]["value"]
    # A tolerance is of an even distribution.
    assert found["tyre"]["k"]["tolerance"] / 3**0.5 == pytest.approx(content["k"]["std"], rel=1e-12)
    assert read_rig(written)[0].tolerances.k == found["tyre"]["k"]["tolerance"]
    assert found["rig"]["b_t"] == content["b_t"]["value"]
    for key in ("a", "e", "J_A"):
        assert found["rig"][key] == declared["rig"][key]
    assert outcome.err == ""
    assert content["converged"] is True
    for name, true, unit in (("k", TYRE.k, "N/m^2"), ("b_t", B_T, "N m s/rad")):
        found = content[name]
        assert abs(found["value"] - true) < 4 * found["std"]
        assert found["std"] < 0.005 * true
        assert found["unit"] == unit
    assert [recording["a"] for recording in content["recordings"]] == sorted(LENGTHS * 2)
    assert [recording["name"] for recording in content["recordings"]] == [path.stem for path in struck]
    assert content["source"]["b_t_printed"]["unit"] == "1/s"
    assert content["recordings_units"].keys() < content["recordings"][0].keys()
    assert all(0.005 < recording["source_zeta"] < 0.2 for recording in content["recordings"])
    assert out.with_suffix(".png").read_bytes().startswith(b"\x89PNG")
    assert sorted(path.name for path in out.parent.iterdir()) == ["id.json", "id.png"]
    for words in ("maximum likelihood", "(2.4", "FFT and decrement", "1/s", "4 recordings at 2 contact"):
        assert words in outcome.out
    assert outcome.out.endswith(f"wrote {out}, {out.with_suffix('.png')} and {written}\n")


def test_a_recording_knows_its_rig(run: Run, struck: list[Path]) -> None:
    top = "# e = 0.009\n# J_A = 0.151764\n# k = 2e6\n"
    for path in struck:
        path.write_text(top + path.read_text())
    before = contents(Path())
    outcome = run("identify", "--free-decay", *struck, "--json")

    assert json.loads(outcome.out)["k"]["value"] == pytest.approx(TYRE.k, rel=0.005)
    assert contents(Path()) == before, "without a file to write the result is printed alone"


def test_no_result_without_a_solution(
    run: Run, rig: Path, struck: list[Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    def unsolved(*arguments: Any) -> Any:
        result = identify_free_decay(*arguments)
        changed = vars(result) | {"converged": False, "status": "not solved", "remedy": "strike harder"}
        return type(result)(**changed)

    monkeypatch.setattr("identification.identify_free_decay", unsolved)

    outcome = run("identify", "--rig", rig, "--out", "id.json", "--free-decay", *struck)
    outcome.refused("not solved: strike harder", status=1)
    assert not Path("id.json").exists()
