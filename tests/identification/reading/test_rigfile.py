import re
from pathlib import Path

import pytest

from identification.reading.checked_sample_table import Table
from identification.reading.rigfile import read_rig, rig_overridden_by_table, rig_text
from symbolic import Rig, Tolerances, Tyre
from tests.refusal import refused

COMPLETE = "[rig]\na = 0.04\ne = 0.009\nJ_A = 0.15\nb_t = 1\n\n[tyre]\nk = 2438000\nmu = 1.67\n"


def write(folder: Path, text: str) -> Path:
    path = folder / "rig.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_reads_everything(tmp_path: Path) -> None:
    rig, tyre = read_rig(write(tmp_path, COMPLETE))

    assert rig == Rig(a=0.04, e=0.009, J_A=0.15, b_t=1.0)
    assert tyre == Tyre(k=2.438e6, mu=1.67)
    assert isinstance(tyre.k, float)


def test_tolerances(tmp_path: Path) -> None:
    text = COMPLETE.replace("a = 0.04", "a = { value = 0.04, tolerance = 0.0025 }")
    alone = "load = { tolerance = 0.01 }\nzero = { value = 0, tolerance = 0.1 }\n"
    text = text.replace("[tyre]", f"{alone}[tyre]")
    within = Tolerances(a=0.0025, load=0.01, zero=0.1)

    declared = Rig(a=0.04, e=0.009, J_A=0.15, b_t=1.0, tolerances=within)
    assert read_rig(write(tmp_path, text))[0] == declared
    shares = text.replace("= 0.01 }", '= "1%" }').replace("= 0.0025 }", '= "6.25 %" }')
    assert read_rig(write(tmp_path, shares))[0].tolerances == within
    alone = re.sub(r"k = .*", "k = { value = 2.4e6, tolerance = 0.2 }", COMPLETE)
    told = refused(read_rig, write(tmp_path, alone))
    assert 'is in the unit of the value 2.4e+06, of which it is hardly anything; write "20%"' in told


TOLERANCES = [
    ("a", "{ value = 0.04 }", "[rig] a lacks its tolerance; write {"),
    ("a", "{ tolerance = 0.01 }", "[rig] a lacks its value; write {"),
    ("a", "{ value = 0.04, tol = 1 }", "[rig] a holds an unknown 'tol'; allowed: value"),
    ("a", '{ value = 0.04, tolerance = "1" }', "[rig] a: its tolerance must be a number"),
    ("a", '{ value = 0.04, tolerance = "-1%" }', "[rig] a: its tolerance must be a number"),
    ("zero", '{ tolerance = "5%" }', "[rig] zero: its tolerance must be a number"),
    ("a", "{ value = 0.04, tolerance = -1 }", "a: its tolerance must be a finite number of"),
    ("a", "{ value = 0.04, tolerance = 0.035 }", "a must stay greater than e and 0 within"),
    ("e", "{ value = 0, tolerance = inf }", "e: its tolerance must be a finite number"),
    ("load", "{ value = 1.1, tolerance = 0.1 }", "[rig] load must have the value 1: it has"),
    ("load", "{ tolerance = 1 }", "load: its tolerance must be a finite number of at least"),
    ("zero", "0.2", "[rig] zero must have the value 0: it has a tolerance alone"),
    ("J_A", "{ value = 0.15, tolerance = 0.1 }", "[rig] J_A must be a number, got"),
]
VALUES = [
    ("a", '"4 cm"', "[rig] a must be a number, got '4 cm'"),
    ("a", "true", "[rig] a must be a number, got 'True'"),
    ("a", "45", "a must be given in metres, at most 1 m in size, got 45; if"),
    ("e", "9.0", "e must be given in metres, at most 1 m in size, got 9; if"),
    ("e", "-0.04", "e must lie between -a and a, here -0.04 and 0.04 m, got -0.04"),
    ("k", "2.4", "k must lie between 1000 and 1e+09 N/m^2, got 2.4"),
    ("k", f"1{'0' * 400}", "[tyre] holds a number too large to compute with"),
]


@pytest.mark.parametrize(("name", "value", "fault"), TOLERANCES + VALUES)
def test_faults_of_a_value(tmp_path: Path, name: str, value: str, fault: str) -> None:
    lines = [line for line in COMPLETE.splitlines() if not line.startswith(f"{name} =")]
    lines.insert(lines.index("[tyre]") + (name in ("k", "mu")), f"{name} = {value}")
    path = write(tmp_path, "\n".join(lines))

    assert refused(read_rig, path).startswith(f"{path}: {fault}")


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ("[rig]", "[rigg]", "unknown section or key 'rigg'; allowed: [rig], [tyre]"),
        (
            COMPLETE,
            "rig = 3\n[tyre]\nk = 1\n",
            "section [rig] is missing; it holds a (half-length), e (caster), J_A",
        ),
        (COMPLETE, "[rig]\na = 0.04\ne = 0\n", "section [tyre] is missing; it holds k (stiffness"),
        ("e = 0.009\n", "", "[rig] e is missing; required: a, e"),
        ("k = 2438000\n", "", "[tyre] k is missing; required: k"),
        (
            "J_A",
            "J",
            "[rig] unknown key 'J'; allowed: a (half-length), e (caster), J_A (inertia), b_t (damping),"
            " slide_rate, load (tolerance), zero (tolerance)",
        ),
        ("k = ", "zero = 0\nk = ", "[tyre] unknown key 'zero', which belongs to [rig]; allowed: k"),
        ("J_A", "noise", "[rig] unknown key 'noise', which belongs to [sensor]; allowed: a"),
    ],
)
def test_faults_of_a_file(tmp_path: Path, old: str, new: str, fault: str) -> None:
    path = tmp_path / "rig.toml"
    path.write_bytes(COMPLETE.replace(old, new, 1).encode("utf-8", "surrogateescape"))

    assert refused(read_rig, path).startswith(f"{path}: {fault}")


def test_a_file_that_is_none(tmp_path: Path) -> None:
    assert refused(read_rig, tmp_path / "none.toml").endswith("none.toml: no such file")


def declared(nominal: tuple[Rig, Tyre] | None, values: dict[str, float]) -> tuple[Rig, Tyre]:
    path = Path("run.csv")
    table = Table(path=path, columns={}, declared=values, place=lambda name: f"line of {name}")
    return rig_overridden_by_table(table, nominal)


@pytest.mark.parametrize(
    ("nominal", "value", "fault"),
    [
        (
            (Rig(a=0.04, e=0.009), Tyre(k=6e4)),
            45.0,
            "line of a: a must be given in metres, at most 1 m in size, got 45; if these are"
            " millimetres, write 0.045",
        ),
        (None, 0.04, "e and k not known; name a rig file (--rig"),
    ],
)
def test_faults_of_declared_values(nominal: tuple[Rig, Tyre] | None, value: float, fault: str) -> None:
    assert refused(declared, nominal, {"a": value}).startswith(f"run.csv: {fault}")


def test_what_is_written_is_read_again(tmp_path: Path) -> None:
    within = Tolerances(a=0.002, e=1e-3, load=0.02, zero=0.1)
    for rig, tyre in (
        (Rig(a=0.045, e=0.009), Tyre(k=2.4e6)),
        (Rig(a=0.045, e=0.009, noise=0.02, range=7.5), Tyre(k=2.4e6)),
        (Rig(a=0.1 / 3, e=-0.01, J_A=0.14, b_t=1.5, tolerances=within), Tyre(k=2.4e6 / 7, mu=1.2)),
    ):
        assert read_rig(write(tmp_path, rig_text(rig, tyre))) == (rig, tyre)
