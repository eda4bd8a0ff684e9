from pathlib import Path

import pytest

from identification.reading.rigfile import read_rig, rig_text, with_declared
from symbolic import InvalidInputError, Rig, Tolerances, Tyre

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


def test_the_optional_is_optional(tmp_path: Path) -> None:
    path = write(tmp_path, "[rig]\na = 0.04  # m\ne = 0\n[tyre]\nk = 6e4\n")

    assert read_rig(path) == (Rig(a=0.04, e=0.0), Tyre(k=6e4))


def test_tolerances(tmp_path: Path) -> None:
    text = COMPLETE.replace("a = 0.04", "a = { value = 0.04, tolerance = 0.0025 }")
    text = text.replace(
        "[tyre]", "load = { tolerance = 0.01 }\nzero = { value = 0, tolerance = 0.1 }\n[tyre]"
    )
    within = Tolerances(a=0.0025, load=0.01, zero=0.1)

    assert read_rig(write(tmp_path, text))[0] == Rig(
        a=0.04, e=0.009, J_A=0.15, b_t=1.0, tolerances=within
    )


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ("a = 0.04", "a = { value = 0.04 }", "[rig] a lacks its tolerance; write {"),
        ("a = 0.04", "a = { tolerance = 0.01 }", "[rig] a lacks its value; write {"),
        ("a = 0.04", "a = { value = 0.04, tol = 1 }", "[rig] a holds an unknown 'tol'; allowed: value"),
        ("a = 0.04", 'a = { value = 0.04, tolerance = "1" }', "[rig] a: its tolerance must be a number"),
        (
            "a = 0.04",
            "a = { value = 0.04, tolerance = -1 }",
            "a: its tolerance must be a finite number of",
        ),
        (
            "a = 0.04",
            "a = { value = 0.04, tolerance = 0.035 }",
            "a must stay greater than e and 0 within",
        ),
        ("e = 0.009", "e = { value = 0, tolerance = inf }", "e: its tolerance must be a finite number"),
        (
            "J_A = 0.15",
            "load = { value = 1.1, tolerance = 0.1 }",
            "[rig] load must have the value 1: it has",
        ),
        (
            "J_A = 0.15",
            "load = { tolerance = 1 }",
            "load: its tolerance must be a finite number of at least",
        ),
        ("J_A = 0.15", "zero = 0.2", "[rig] zero must have the value 0: it has a tolerance alone"),
        ("J_A = 0.15", "J_A = { value = 0.15, tolerance = 0.1 }", "[rig] J_A must be a number, got"),
    ],
)
def test_faults_of_tolerances(tmp_path: Path, old: str, new: str, fault: str) -> None:
    path = write(tmp_path, COMPLETE.replace(old, new))
    with pytest.raises(InvalidInputError) as caught:
        read_rig(path)
    message = str(caught.value)
    assert message.startswith(f"{path}: {fault}")
    assert "\n" not in message


def test_reads_past_a_byte_order_mark(tmp_path: Path) -> None:
    path = write(tmp_path, "\ufeff" + COMPLETE.replace("\n", "\r\n"))

    assert read_rig(str(path))[0].a == 0.04


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ("[rig]", "[rigg]", "unknown section or key 'rigg'; allowed: [rig], [tyre]"),
        ("[rig]", "x = 1\n[rig]", "unknown section or key 'x'"),
        ("[tyre]\nk = 2438000\nmu = 1.67\n", "", "section [tyre] is missing; it holds k, mu"),
        ("a = 0.04\n", "", "[rig] a is missing; required: a, e"),
        ("e = 0.009\n", "", "[rig] e is missing; required: a, e"),
        ("k = 2438000\n", "", "[tyre] k is missing; required: k"),
        ("J_A", "J", "[rig] unknown key 'J'; allowed: a, e, J_A, b_t, slide_rate"),
        ("a = 0.04", 'a = "4 cm"', "[rig] a must be a number, got '4 cm'"),
        ("a = 0.04", "a = true", "[rig] a must be a number, got 'True'"),
        ("a = 0.04", "a = [0.04]", "[rig] a must be a number, got '[0.04]'"),
        ("a = 0.04", "a = 0", "a must be a finite number greater than 0 m, got 0"),
        ("a = 0.04", "a = nan", "a must be a finite number greater than 0 m, got nan"),
        ("e = 0.009", "e = -0.04", "e must lie between -a and a, here -0.04 and 0.04 m, got -0.04"),
        ("k = 2438000", "k = -1", "k must be a finite number greater than 0 N/m^2, got -1"),
        ("mu = 1.67", "mu = 0.0", "mu must be a finite number greater than 0, got 0"),
        ("b_t = 1", "b_t = -1", "b_t must be a number from 0 to 10000 N m s/rad, got -1"),
        ("a = 0.04", "a = 40", "a must be given in metres, at most 1 m in size, got 40; if these are"),
        ("e = 0.009", "e = -9", "e must be given in metres, at most 1 m in size, got -9; if these are"),
        ("a = 0.04", "a = inf", "a must be a finite number greater than 0 m, got inf"),
        ("k = 2438000", "k = 1" + "0" * 400, "[tyre] holds a number too large to compute with"),
        ("a = 0.04", "a = ", "is not valid TOML: "),
        ("e = 0.009", "a = 0.05", "is not valid TOML: "),
    ],
)
def test_faults(tmp_path: Path, old: str, new: str, fault: str) -> None:
    path = write(tmp_path, COMPLETE.replace(old, new, 1))

    with pytest.raises(InvalidInputError) as caught:
        read_rig(path)

    message = str(caught.value)
    assert message.startswith(f"{path}: {fault}")
    assert "\n" not in message


def test_section_that_is_a_value(tmp_path: Path) -> None:
    path = write(tmp_path, "rig = 3\n[tyre]\nk = 1\n")

    with pytest.raises(InvalidInputError, match=r"section \[rig\] is missing"):
        read_rig(path)


def test_missing_file_and_directory(tmp_path: Path) -> None:
    with pytest.raises(InvalidInputError, match=r"none\.toml: no such file$"):
        read_rig(tmp_path / "none.toml")
    with pytest.raises(InvalidInputError, match="is a directory"):
        read_rig(tmp_path)


@pytest.mark.parametrize(
    ("content", "fault"),
    [(b"", "is empty"), (b"[rig]\na = 1 # \xe9\n", "row 2"), (b"[rig]\n\0", "row 2")],
)
def test_no_text(tmp_path: Path, content: bytes, fault: str) -> None:
    path = tmp_path / "rig.toml"
    path.write_bytes(content)

    with pytest.raises(InvalidInputError, match=fault):
        read_rig(path)


def test_declared_values_go_first() -> None:
    nominal = (Rig(a=0.04, e=0.009, J_A=0.15), Tyre(k=6e4, mu=0.8))

    assert with_declared(nominal, {}) == nominal
    assert with_declared(nominal, {"a": 0.05, "b_t": 1.0, "k": 7e4}) == (
        Rig(a=0.05, e=0.009, J_A=0.15, b_t=1.0),
        Tyre(k=7e4, mu=0.8),
    )


def test_declared_in_millimetres() -> None:
    with pytest.raises(InvalidInputError, match=r"^a must be given in metres, .* write 0\.045$"):
        with_declared((Rig(a=0.04, e=0.009), Tyre(k=6e4)), {"a": 45.0})


def test_declared_alone_must_be_complete() -> None:
    assert with_declared(None, {"a": 0.04, "e": 0.0, "k": 6e4}) == (Rig(a=0.04, e=0), Tyre(k=6e4))
    with pytest.raises(InvalidInputError, match=r"^e and k not known; name a rig file \(--rig"):
        with_declared(None, {"a": 0.04})


@pytest.mark.parametrize(
    ("rig", "tyre"),
    [
        (Rig(a=0.045, e=0.009), Tyre(k=2.4e6)),
        (
            Rig(
                a=0.1 / 3,
                e=-0.01,
                J_A=0.14,
                b_t=1.5,
                tolerances=Tolerances(a=0.002, e=1e-3, load=0.02, zero=0.1),
            ),
            Tyre(k=2.4e6 / 7, mu=1.2),
        ),
    ],
)
def test_what_is_written_is_read_again(tmp_path: Path, rig: Rig, tyre: Tyre) -> None:
    path = tmp_path / "rig.toml"
    path.write_text(rig_text(rig, tyre))

    assert read_rig(path) == (rig, tyre)
