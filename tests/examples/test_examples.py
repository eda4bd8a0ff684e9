"""Every example runs as a script, and prints the number that it claims."""

import os
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
NUMBER = r"([-+.\de]+)"


def printed_by(example: str, tmp_path: Path) -> str:
    """What the script prints, run from elsewhere against this checkout."""
    result = subprocess.run(
        [sys.executable, "-W", "error", ROOT / "examples" / example],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT), "PYTHONIOENCODING": "utf-8"},
        capture_output=True,
        text=True,
        encoding="utf-8",
        check=False,
        timeout=600,
    )
    assert result.returncode == 0, result.stderr
    assert result.stderr == ""
    assert list(tmp_path.iterdir()) == []
    return result.stdout


def truth_of(recording: str) -> float:
    """Friction that was planted, from the table beside the recordings."""
    text = (ROOT / "examples" / "recordings" / "TRUTH.md").read_text(encoding="utf-8")
    (mu,) = re.findall(rf"^\| {recording} \| {NUMBER} \|", text, flags=re.MULTILINE)
    return float(mu)


def test_estimate_in_a_loop(tmp_path: Path) -> None:
    *track, end = printed_by("estimate_in_a_loop.py", tmp_path).splitlines()
    matched = re.fullmatch(rf"friction at the end: mu = {NUMBER} ± {NUMBER}", end)

    assert matched, end
    mu, spread = map(float, matched.groups())
    assert abs(mu - truth_of("holdout_c")) < 3 * spread
    assert spread < 0.05
    assert "rests on the prior" in track[0]
    assert "rests on the prior" not in track[-1]


def test_find_the_missing_effect(tmp_path: Path) -> None:
    text = printed_by("find_the_missing_effect.py", tmp_path)
    values = dict(re.findall(rf"^(\w+: \w+) = {NUMBER}", text, flags=re.MULTILINE))
    before, after = (
        float(value)
        for value in re.findall(rf"torque error \w+: {NUMBER}% of range$", text, flags=re.MULTILINE)
    )

    assert set(values) == {"rate_friction: c", "carcass_torsion: k_t"}
    assert abs(float(values["rate_friction: c"]) - 0.04) < 0.002
    assert abs(float(values["carcass_torsion: k_t"]) - 400) < 30
    assert before > 1.5
    assert after < 0.45
