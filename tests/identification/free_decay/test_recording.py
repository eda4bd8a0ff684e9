"""Recordings of free vibrations, from files and by hand."""

from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from identification.free_decay.recording import Decay, read_decay
from symbolic import InvalidInputError, Rig, Tyre
from tests.refusal import fault_of

RIG = (Rig(a=0.045, e=0.009, J_A=0.15), Tyre(k=2e6))
T = np.arange(20) / 1000
PSI = 0.005 * np.cos(33 * T)


def write(folder: Path, *top: str, header: str = "t,psi", rows: list[str] | None = None) -> Path:
    path = folder / "run.csv"
    usual = [f"{t:.6g},{psi:.8g}" for t, psi in zip(T, PSI, strict=True)]
    path.write_text("\n".join([*top, header, *(usual if rows is None else rows)]) + "\n")
    return path


def message_of(path: Path, rig: tuple[Rig, Tyre] | None = RIG) -> str:
    return fault_of(read_decay, path, rig)


def test_reads_time_and_angle_alone(tmp_path: Path) -> None:
    made = read_decay(write(tmp_path), RIG)

    assert made.name == "run"
    assert (made.rig, made.tyre) == RIG
    np.testing.assert_allclose(made.psi, PSI, rtol=1e-7)
    assert not made.psi.flags.writeable
    # Other columns are ignored, missing samples left out.
    rows = [
        f"{t:.6g},,{'' if i in (3, 4) else psi},400"
        for i, (t, psi) in enumerate(zip(T, PSI, strict=True))
    ]
    made = read_decay(write(tmp_path, header="t,M_z,psi,F_N", rows=rows), RIG)
    np.testing.assert_allclose(made.t, np.delete(T, [3, 4]), atol=1e-9)
    np.testing.assert_allclose(made.psi, np.delete(PSI, [3, 4]), rtol=1e-7)
    path = tmp_path / "run.mat"
    savemat(path, {"time": T, "Psi": PSI, "a": 0.05})
    made = read_decay(path, RIG)
    assert made.rig.a == 0.05
    np.testing.assert_allclose(made.psi, PSI)


def test_faults(tmp_path: Path) -> None:
    without_inertia = (Rig(a=0.045, e=0.009), RIG[1])

    assert message_of(write(tmp_path), without_inertia).startswith("J_A is not known, and a free vib")
    assert message_of(write(tmp_path), None).startswith("a and e and k not known; name a rig file")
    assert "channel psi missing" in message_of(write(tmp_path, header="t,angle"))
    assert "row 1: J_A must be" in message_of(write(tmp_path, "# J_A = -1"))
    assert "holds 3 samples" in message_of(write(tmp_path, rows=["0,1", "1,2", "2,3"]))
    missing = write(tmp_path, rows=[f"{i}," for i in range(12)])
    assert "every psi is missing" in fault_of(read_decay, missing, RIG)
    few = [f"{i},{i if i > 5 else ''}" for i in range(12)]
    assert "6 samples of psi, at least 10" in message_of(write(tmp_path, rows=few))
    missing = write(tmp_path, rows=[",1", *(f"{i},{i}" for i in range(12))])
    assert "t is missing" in fault_of(read_decay, missing, RIG)


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"psi": PSI[:-1]}, "psi has shape"),
        ({"t": T[::-1]}, "t must increase"),
        ({"psi": np.where(T > 0.01, np.nan, PSI)}, "must be finite"),
        ({"t": T[:5], "psi": PSI[:5]}, "5 samples of psi"),
        ({"rig": Rig(a=0.045, e=0.009)}, "J_A is not known"),
    ],
)
def test_by_hand(changes: dict[str, object], fault: str) -> None:
    values = {"name": "run", "t": T, "psi": PSI, "rig": RIG[0], "tyre": RIG[1]} | changes

    with pytest.raises(InvalidInputError, match=f"^run: .*{fault}"):
        Decay(**values)  # type: ignore[arg-type]
