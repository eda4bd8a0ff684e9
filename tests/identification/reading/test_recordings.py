import re
from dataclasses import replace
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from scipy.io import savemat

from identification.reading.recordings import Recording, read_recording
from symbolic import Rig, Tolerances, Tyre
from tests.refusal import fault_of, refused

RIG = (Rig(a=0.04, e=0.009, J_A=0.15), Tyre(k=2.4e6, mu=1.6))
N = 20
T = np.arange(N) / 100
PSI = 0.1 * np.sin(20 * T)
M_Z = -3 * PSI
F_N = np.linspace(400, 410, N)
AFTER_3 = np.arange(1, N + 1) > 3


def rows_of(*columns: Any, header: str = "t,psi,M_z,F_N") -> list[str]:
    samples = zip(*(columns or (T, PSI, M_Z, F_N)), strict=True)
    return [header, *(",".join(f"{value:.10g}" for value in sample) for sample in samples)]


def write(folder: Path, rows: list[str], *, end: str = "\n") -> Path:
    path = folder / "run.csv"
    path.write_bytes((end.join(rows) + end).encode())
    return path


def write_mat(folder: Path, **changes: Any) -> Path:
    path = folder / "run.mat"
    content = {"time": T, "Psi": PSI, "Mz": M_Z, "Fz": F_N, "a": 0.05, "e": 0.0, "k": 6e4}
    savemat(path, {k: v for k, v in (content | changes).items() if v is not None})
    return path


def message_of(path: Path, rig: tuple[Rig, Tyre] | None = RIG) -> str:
    return fault_of(read_recording, path, rig)


class TestCsv:
    @pytest.mark.parametrize(
        "start", ["9:59:59.95", "2026-03-29 23:59:59,95", "2026-01-01T05:30:00+0530"]
    )
    def test_clock_times_count_from_the_first(self, tmp_path: Path, start: str) -> None:
        date, clock = start[: -len(start.split(" ")[-1].split("T")[-1])], re.split("[ T]", start)[-1]
        begin = datetime.fromisoformat(f"{date or '2026-01-01 0'}{clock}")
        times = [begin + timedelta(seconds=float(t)) for t in T]
        texts = [str(one) if date else f"{one:%H:%M:%S.%f}" for one in times]
        table = rows_of([0] * N, PSI, M_Z, F_N, header="uhr;psi;M_z;F_N")
        rows = [
            ";".join([text, *row.split(",")[1:]]) for text, row in zip(texts, table[1:], strict=True)
        ]
        path = write(tmp_path, [table[0], *rows])

        np.testing.assert_allclose(read_recording(path, RIG, signals="t=uhr").t, T, atol=1e-9)
        assert "--map t=uhr" in message_of(path), "the proposed map is whole"
        assert "uhr: has a unit of its own" in refused(read_recording, path, RIG, signals="t=uhr:ms")
        rows[3] = f"0.03;{rows[3].partition(';')[2]}"
        mixed = write(tmp_path, [table[0], *rows])
        assert "in every row a clock time" in refused(read_recording, mixed, RIG, signals="t=uhr")

    def test_a_clock_that_passes_midnight_is_refused_with_a_remedy(self, tmp_path: Path) -> None:
        rows = rows_of([0] * N, PSI, M_Z, F_N)
        rows[1:] = [
            f"{'23:59:59' if i < 9 else '00:00:00'}.{i:02},{r[2:]}" for i, r in enumerate(rows[1:])
        ]

        assert "as a clock does at midnight (write dates" in message_of(write(tmp_path, rows))

    def test_reads(self, tmp_path: Path) -> None:
        recording = read_recording(write(tmp_path, rows_of()), RIG)

        assert (recording.name, recording.M, recording.ground) == ("run", None, None)
        assert repr(replace(recording, ground="ice")) == "<Recording run on ice: 20 samples, 0.19 s>"
        assert (recording.rig, recording.tyre) == RIG
        for name, given in {"t": T, "psi": PSI, "M_z": M_Z, "F_N": F_N}.items():
            read = getattr(recording, name)
            np.testing.assert_allclose(read, given, rtol=1e-9)
            assert read.dtype == np.float64
            assert not read.flags.writeable

    def test_any_order_with_rate_steering_torque_and_strangers(self, tmp_path: Path) -> None:
        rows = rows_of(F_N, PSI * 7, T, M_Z + 1, PSI, M_Z, header="F_N,psi_dot,t, M ,psi,M_z")
        rows = [row + (",note" if number == 0 else ",dry") for number, row in enumerate(rows)]
        recording = read_recording(write(tmp_path, rows), RIG)

        for name, given in {"t": T, "psi": PSI, "psi_dot": PSI * 7, "M": M_Z + 1}.items():
            np.testing.assert_allclose(getattr(recording, name), given, rtol=1e-9)

    @pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
    def test_byte_order_mark_line_ends_blank_lines_and_quotes(self, tmp_path: Path, end: str) -> None:
        quoted = [",".join(f'"{field}"' for field in row.split(",")) for row in rows_of()]
        rows = ["\ufeff# measured on Monday", "", *quoted, "", "  ", ""]
        plain = read_recording(write(tmp_path, rows_of()), RIG)
        recording = read_recording(write(tmp_path, rows, end=end), RIG)

        np.testing.assert_array_equal(recording.M_z, plain.M_z)

    def test_comment_lines_go_before_the_rig(self, tmp_path: Path) -> None:
        rows = ["# a = 0.045", "#k=7e4", "# b_t = 1.5", "# operator = B", *rows_of()]
        recording = read_recording(write(tmp_path, rows), RIG)
        alone = read_recording(write(tmp_path, ["# e = 0", *rows]))

        assert recording.rig == Rig(a=0.045, e=0.009, J_A=0.15, b_t=1.5)
        assert recording.tyre == Tyre(k=7e4, mu=1.6)
        assert (alone.rig, alone.tyre) == (Rig(a=0.045, e=0.0, b_t=1.5), Tyre(k=7e4))

    @pytest.mark.parametrize("sign", ["+-", "+/-", "±"])
    def test_tolerances_and_ground(self, tmp_path: Path, sign: str) -> None:
        lines = [f"# a = 0.05 {sign} 0.0025", f"#load=1{sign}0.01", "# ground = steel plate"]
        rig = replace(RIG[0], tolerances=Tolerances(a=0.001, e=0.002))
        read = read_recording(write(tmp_path, [*lines, *rows_of()]), (rig, RIG[1]))

        assert read.rig.a == 0.05
        assert read.rig.tolerances == Tolerances(a=0.0025, e=0.002, load=0.01)
        assert read.ground == "steel plate"

    @pytest.mark.parametrize("missing", ["", "NaN", " nan "])
    def test_gaps(self, tmp_path: Path, missing: str) -> None:
        rows = rows_of()
        rows[5] = f"{T[4]},{missing},{missing},{missing}"
        rows[1] = f"{T[0]},{missing},1,{missing}"
        rows[N] = f"{T[-1]},{missing},1,{missing}"
        recording = read_recording(write(tmp_path, rows), RIG)

        assert recording.psi[4] == pytest.approx((PSI[3] + PSI[5]) / 2)
        assert recording.F_N[4] == pytest.approx((F_N[3] + F_N[5]) / 2)
        assert recording.psi[0] == recording.psi[1]
        assert recording.F_N[-1] == recording.F_N[-2]
        assert np.flatnonzero(np.isnan(recording.M_z)).tolist() == [4]
        assert np.isfinite(recording.psi_dot).all()

    def test_empty_rate_column_is_derived(self, tmp_path: Path) -> None:
        derived = read_recording(write(tmp_path, rows_of()), RIG).psi_dot
        rows = [row + (",psi_dot" if number == 0 else ",") for number, row in enumerate(rows_of())]

        np.testing.assert_array_equal(read_recording(write(tmp_path, rows), RIG).psi_dot, derived)

    @pytest.mark.parametrize("header", ["t,psi,F_N", "t,psi,F_N,M_z"])
    def test_torque_may_be_dispensable(self, tmp_path: Path, header: str) -> None:
        columns = (T, PSI, F_N, M_Z * np.nan)[: header.count(",") + 1]
        path = write(tmp_path, rows_of(*columns, header=header))

        assert np.isnan(read_recording(path, RIG, torque_required=False).M_z).all()
        assert "M_z" in message_of(path)


@pytest.mark.parametrize(
    ("number", "row", "fault"),
    [
        (3, "t,psi,M_z,F_N,t", "two columns are named t; one allowed"),
        (9, "0.05,abc,0,400", "psi = 'abc' is not a number; allowed: a finite number"),
        (9, "0.05,0,1_0,400", "M_z = '1_0' is not a number"),
        (9, "0.05,0,0", "has 3 fields, the header has 4"),
        (9, "0,05,0,0,400", "has 5 fields, the header has 4"),
        (9, "", "has 0 fields, the header has 4"),
        (9, "0.01,0,0,400", "time runs backwards: t = 0.01 s after 0.04 s; t must"),
        (9, "0.04,0,0,400", "time repeats: t = 0.04 s after 0.04 s; t must increase"),
        (9, ",0,0,400", "t is missing; every sample needs its time"),
        (9, "NaN,0,0,400", "t is missing"),
        (9, "0.05,inf,0,400", "psi is infinite; allowed: a finite number, empty or"),
        (9, "0.05,0,-inf,400", "M_z is infinite"),
        (9, "0.05,0,0,1e999", "F_N is infinite"),
        (9, "inf,0,0,400", "t is infinite"),
        (9, "0.05,0,0,0", "F_N = 0 N; a vertical load is greater than 0"),
        (9, "0.05,0,0,-400", "F_N = -400 N; a vertical load is greater than 0"),
        (9, '0.05,0,0,"400', ""),
        (9, "0.03,0,0," + "4" * 200_000, "is not CSV: "),
    ],
)
def test_faults_of_a_row(tmp_path: Path, number: int, row: str, fault: str) -> None:
    rows = ["# counted from the top of the file", "", *rows_of()]
    rows[number - 1] = row

    assert message_of(write(tmp_path, rows)).startswith(f"row {number}: {fault}")


@pytest.mark.parametrize(
    ("header", "fault"),
    [
        ("t,psi,F_N", "channel M_z missing; there are t, psi, F_N; say which is which"),
        (
            "t,psi,M_z",
            "channel F_N missing; there are t, psi, M_z; a load that was not recorded needs a column"
            " too, with its value [N] in every row",
        ),
        ("t;psi;M_z;F_N", "row 2: has 1 fields, the header has 4 (and "),
        ("t psi M_z F_N", "channels t, psi, M_z, F_N missing; there are t psi M_z F_N; say"),
    ],
)
def test_faults_of_a_header(tmp_path: Path, header: str, fault: str) -> None:
    assert message_of(write(tmp_path, [header, *rows_of()[1:]])).startswith(fault)


@pytest.mark.parametrize(
    ("comment", "fault"),
    [
        ("# a = 0", "row 2: a must be a finite number greater than 0 m, got 0"),
        ("# a = 0.008", "e must lie between -a and a, here -0.008 and 0.008 m, got 0.009"),
        ("# mu = -1", "row 2: mu must be a finite number greater than 0"),
        ("# a = 45 mm", "row 2: a = '45 mm' is not a number; expected such as '# a = 0.045'"),
        ("# a =", "row 2: a = '' is not a number"),
        ("# a = 0.04\n# a = 0.05", "row 3: a is given twice, first in row 2"),
        ("# a = 0.04 +- a bit", "row 2: a = 'a bit' is not a number"),
        ("# a = 0.04 +- 0.05", "row 2: a must stay greater than e and 0 within their tolerances"),
        ("# mu = 1.2 +- 0.1", "row 2: mu = '1.2 +- 0.1' is not a number"),
        ("# load = 1", "row 2: load has a tolerance alone, as in '# load = 1 +- 0.01'"),
        ("# zero = 0.1 +- 0.1", "row 2: zero has a tolerance alone, as in '# zero = 0 +- 0.01'"),
        ("# ground =", "row 2: ground has no name; such as '# ground = steel'"),
        ("# ground = ice\n# ground = steel", "row 3: ground is given twice, first in row 2"),
    ],
)
def test_comment_faults(tmp_path: Path, comment: str, fault: str) -> None:
    assert message_of(write(tmp_path, ["# remark", comment, *rows_of()])).startswith(fault)


@pytest.mark.parametrize(
    ("others", "count"), [((), ""), ((9,), " (and 1 more row)"), ((9, 12), " (and 2 more rows)")]
)
def test_first_fault_is_named_and_the_others_counted(
    tmp_path: Path, others: tuple[int, ...], count: str
) -> None:
    rows = rows_of()
    rows[5] = "0.04,0,0,-400"
    for row in others:
        rows[row] = "text,text,0"
    message = message_of(write(tmp_path, rows))

    assert message.startswith("row 6: F_N = -400 N")
    assert message.endswith("greater than 0" + count)


@pytest.mark.parametrize("samples", [0, 1, 2, 9])
def test_too_short(tmp_path: Path, samples: int) -> None:
    message = message_of(write(tmp_path, rows_of()[: samples + 1]))

    assert message.startswith(f"holds {samples} sample")
    assert message.endswith("at least 10 needed")


@pytest.mark.parametrize("column", ["psi", "M_z", "F_N"])
def test_nothing_but_gaps(tmp_path: Path, column: str) -> None:
    values = {"t": T, "psi": PSI, "M_z": M_Z, "F_N": F_N}
    values[column] = np.full(N, np.nan)

    message = message_of(write(tmp_path, rows_of(*values.values())))
    assert message == f"every {column} is missing, a number is needed"


OTHER_LETTERS = "# Messung in Łódź\n# a = 0.04\nt,psi,M_z,F_N\n".encode("cp1250")


@pytest.mark.parametrize(
    ("content", "fault"),
    [
        (b"# a = 1\n", "has no header; expected t,psi,M_z,F_N"),
        (OTHER_LETTERS, "row 1: is not text, byte 0xa3 is not UTF-8; save"),
    ],
)
def test_no_table(tmp_path: Path, content: bytes, fault: str) -> None:
    (tmp_path / "run.csv").write_bytes(content)

    assert message_of(tmp_path / "run.csv").startswith(fault)


@pytest.mark.parametrize("suffix", [".csv", ".mat"])
def test_no_file(tmp_path: Path, suffix: str) -> None:
    (tmp_path / f"folder{suffix}").mkdir()

    assert message_of(tmp_path / f"none{suffix}") == "no such file"
    assert message_of(tmp_path / f"folder{suffix}") == "is a directory, expected a file"
    assert message_of(write(tmp_path, rows_of()) / f"run{suffix}").startswith("cannot be read: ")


class TestMat:
    def test_its_own_rig_and_tolerance_go_first(self, tmp_path: Path) -> None:
        path = write_mat(tmp_path)

        # The half-length was read to 5 mm.
        within = Tolerances(a=0.0025)
        assert read_recording(path).rig == Rig(a=0.05, e=0.0, tolerances=within)
        assert read_recording(path).tyre == Tyre(k=6e4)
        assert read_recording(path, RIG).rig == Rig(a=0.05, e=0.0, J_A=0.15, tolerances=within)
        assert read_recording(path, RIG).tyre == Tyre(k=6e4, mu=1.6)
        read = read_recording(write_mat(tmp_path, a_tolerance=0.001, load_tolerance=0.02))
        assert read.rig.tolerances == Tolerances(a=0.001, load=0.02)
        unknown = read_recording(write_mat(tmp_path, a=None), RIG)
        assert unknown.rig.tolerances == Tolerances(), "the half-length is the rig file's"

    @pytest.mark.parametrize("shape", [(1, N), (N, 1)])
    def test_reads_rows_and_columns(self, tmp_path: Path, shape: tuple[int, int]) -> None:
        recording = read_recording(write_mat(tmp_path, Mz=M_Z.reshape(shape), Psi_max=3))

        np.testing.assert_array_equal(recording.M_z, M_Z)
        np.testing.assert_array_equal(recording.psi, PSI)
        np.testing.assert_array_equal(recording.F_N, F_N)
        assert recording.name == "run"

    def test_the_time_may_have_the_name_of_its_column_and_is_sought_where_it_is_missing(
        self, tmp_path: Path
    ) -> None:
        np.testing.assert_array_equal(read_recording(write_mat(tmp_path, time=None, t=T)).t, T)
        path = write_mat(tmp_path, time=None, Zeit=T, Psi=None, angle_deg=np.degrees(PSI))
        message = refused(read_recording, path, signals="psi=angle_deg:deg,M_z=-Mz")
        assert "channel t missing; there are Mz, Fz, a, e, k, Zeit, angle_deg; say" in message
        assert message.endswith("--map t=Zeit,psi=angle_deg:deg,M_z=-Mz")

    @pytest.mark.parametrize(
        ("changes", "fault"),
        [
            ({"Psi": None}, "channel psi missing; there are time, Mz, Fz, a, e, k; say which is which"),
            ({"Psi": None, "Fz": None}, "channels psi, F_N missing; there are time, Mz, a,"),
            ({"Psi": PSI[:-1]}, "Psi holds 19 samples, time holds 20; equal numbers are needed"),
            ({"Psi": "text"}, "Psi must hold real numbers"),
            ({"Psi": 1j * PSI}, "Psi must hold real numbers"),
            ({"Psi": np.eye(4)}, "Psi must be one row or column, it is 4x4"),
            ({"Psi": np.zeros((0, 0))}, "Psi must be one row or column, it is 0x0"),
            ({"Psi": PSI * np.nan}, "every psi is missing, a number is needed"),
            ({"Fz": np.where(AFTER_3, -F_N, F_N)}, "sample 4: F_N = -4"),
            ({"a": 0.0}, "scalar a: a must be a finite number greater than 0 m, got 0"),
            ({"a": [0.04, 0.05]}, "a must be one number, it holds 2"),
        ],
    )
    def test_faults(self, tmp_path: Path, changes: dict[str, Any], fault: str) -> None:
        assert message_of(write_mat(tmp_path, **changes), None).startswith(fault)

    def test_without_rig_says_what_to_do(self, tmp_path: Path) -> None:
        path = write_mat(tmp_path, k=None)

        assert message_of(path, None).startswith("k not known; name a rig file (--rig RIG.toml)")
        assert read_recording(path, RIG).tyre.k == 2.4e6

    def test_hdf5_without_its_library(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr("identification.reading.readers.find_spec", {"h5py": None}.get)
        (tmp_path / "run.mat").write_bytes(b"MATLAB 7.3 MAT-file, Platform: GLNXA64")

        assert message_of(tmp_path / "run.mat").startswith("is a MATLAB 7.3 (HDF5) file; save it as")


class TestRecording:
    VALUES: ClassVar[dict[str, Any]] = {
        "name": "made up", "t": T, "psi": PSI, "psi_dot": PSI, "M_z": M_Z, "F_N": F_N,
        "rig": RIG[0], "tyre": RIG[1],
    }  # fmt: skip

    def test_keeps_its_own_copy(self) -> None:
        mine = T.copy()
        recording = Recording(**self.VALUES | {"t": mine, "M": list(M_Z)})
        mine[0] = -1

        assert recording.t[0] == 0
        assert isinstance(recording.M, np.ndarray)
        with pytest.raises(ValueError, match="read-only"):
            recording.psi[0] = 1

    @pytest.mark.parametrize(
        ("changes", "fault"),
        [
            ({"psi": PSI[:-1]}, "psi has shape"),
            ({"M": PSI[:-1]}, "M has shape"),
            ({"M_z": 0.0}, "M_z has shape"),
            ({"t": T.reshape(1, -1)}, "t has shape"),
            (dict.fromkeys(("t", "psi", "psi_dot", "M_z", "F_N"), T[:2]), "2 samples"),
            ({"t": T[::-1]}, "t must increase"),
            ({"F_N": -F_N}, "F_N must be greater than 0"),
            ({"F_N": F_N * np.nan}, "F_N must be finite"),
            ({"psi_dot": PSI * np.nan}, "psi_dot must be finite"),
            ({"M_z": np.full(N, np.inf)}, "M_z must be finite"),
        ],
    )
    def test_refuses(self, changes: dict[str, Any], fault: str) -> None:
        assert refused(Recording, **self.VALUES | changes).startswith(f"made up: {fault}")


@pytest.mark.measured
def test_published_recordings(measured_dir: Path) -> None:
    for path in sorted(measured_dir.glob("*.mat")):
        recording = read_recording(path)

        assert recording.tyre.k == 2.438e6
        assert recording.rig.e == 0.009
        assert np.diff(recording.t) == pytest.approx(0.01)
        assert np.isfinite(recording.M_z).all()
        # The smoothed rate integrates to the angle again.
        steps = recording.psi_dot[1:] + recording.psi_dot[:-1]
        turned = np.cumsum(steps * np.diff(recording.t)) / 2
        assert np.abs(turned - (recording.psi[1:] - recording.psi[0])).max() < 5e-3
