"""Machine code against the interpreter, and every way in which there may be no machine code."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from symbolic import EFFECTS, Model, compiled, compiler, effects_named, sensitivity_step
from symbolic.compiled import cache_directory
from tests.symbolic.oracles import random_path, signals
from tests.symbolic.test_effects import VALUES

OTHERS = [
    n for n in EFFECTS if n not in ("viscoelastic_relaxation", "frictional_creep", "carcass_torsion")
]
OTHER_VALUES = tuple(value for name in OTHERS for value in VALUES[name].values())
needs_compiler = pytest.mark.skipif(compiler() is None, reason="no C compiler at hand")


@pytest.fixture(autouse=True)
def fresh(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """An empty cache, and a compiler that is looked for anew."""
    monkeypatch.setenv("BRUSHGRIP_CACHE", str(tmp_path / "cache"))
    compiler.cache_clear()
    yield
    compiler.cache_clear()


def small(factor: float = 2.0) -> ca.Function:
    x = ca.SX.sym("x", 3)
    return ca.Function("small", [x], [factor * ca.sin(x), ca.sum1(x)], ["x"], ["y", "total"])


def libraries(folder: Path) -> list[Path]:
    return sorted(folder.glob("cache/*"))


@needs_compiler
@pytest.mark.parametrize(
    ("model", "own"),
    [
        (Model(corners=8), ()),
        (Model(discretised=True, lengthways=20), ()),
        (Model(effects=(EFFECTS["viscoelastic_relaxation"],), lengthways=20), (0.5, 0.6)),
        (
            Model(effects=effects_named(["frictional_creep", "carcass_torsion"]), lengthways=20),
            (0.15, 1 / 350),
        ),
        (Model(effects=effects_named(OTHERS), lengthways=8), OTHER_VALUES),
    ],
    ids=["zones", "bristles", "relaxing bristles", "creep behind a carcass", "every other effect"],
)
@pytest.mark.parametrize("vectorised", [False, True], ids=["plain", "vectorised"])
def test_machine_code_gives_the_interpreters_numbers(
    model: Model, own: tuple[float, ...], vectorised: bool
) -> None:
    step = sensitivity_step(model, 2)
    fast = compiled(step, vectorised=vectorised)
    path = random_path(3, depth=4, samples=150)
    samples, geometry = signals(path.psi, path.F_N), np.array([path.tyre.a, path.tyre.e])
    theta = np.array([path.tyre.mu, path.tyre.k, *own])
    seeds = np.eye(len(theta), 2) @ np.diag([path.tyre.mu, path.tyre.k])
    state = [np.asarray(model.initial(samples[:, 0], theta, geometry)), np.zeros((model.memory_size, 2))]
    scale, error = [1e-300] * 4, [0.0] * 4

    assert fast is not step
    assert fast.name_in() == step.name_in()
    assert fast.name_out() == step.name_out()
    for sample in samples.T:
        arguments = (*state, sample, theta, seeds, geometry)
        slow, quick = ([np.asarray(part) for part in f(*arguments)] for f in (step, fast))
        for i in range(4):
            scale[i] = max(scale[i], float(np.max(np.abs(slow[i]))))
            error[i] = max(error[i], float(np.max(np.abs(slow[i] - quick[i]))))
        state = slow[:2]
    relative = [e / s for e, s in zip(error, scale, strict=True)]
    print(f"machine code against interpreter: {max(relative):.1e}")
    assert max(relative) <= 1e-12


@needs_compiler
def test_library_is_kept_and_used_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert compiled(small()) is not None
    kept = libraries(tmp_path)
    assert [path.suffix for path in kept] == [".so"], "no scratch is left behind"

    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("compiled again")

    monkeypatch.setattr(subprocess, "run", refuse)

    np.testing.assert_allclose(np.asarray(compiled(small())([0, 1, 2])[1]), 3.0)
    assert libraries(tmp_path) == kept


@needs_compiler
def test_changed_function_does_not_meet_a_stale_library(tmp_path: Path) -> None:
    two, three = compiled(small(2.0)), compiled(small(3.0))

    assert len(libraries(tmp_path)) == 2
    np.testing.assert_allclose(np.asarray(three([1, 1, 1])[0]), 1.5 * np.asarray(two([1, 1, 1])[0]))


@pytest.mark.parametrize(
    "environment",
    [{"BRUSHGRIP_INTERPRET": "1"}, {"CC": "/bin/false"}, {"CC": "no-such-compiler"}],
    ids=["asked to interpret", "broken compiler", "missing compiler"],
)
def test_function_is_interpreted_where_it_cannot_be_compiled(
    environment: dict[str, str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    function = small()

    assert compiled(function) is function
    assert libraries(tmp_path) == []


def test_function_is_interpreted_where_nothing_can_be_kept(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    # A file in the way of the folder stops every user, the superuser too.
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("BRUSHGRIP_CACHE", str(tmp_path / "file" / "cache"))
    function = small()

    assert compiled(function) is function


@needs_compiler
def test_function_is_interpreted_where_the_library_is_broken(tmp_path: Path) -> None:
    compiled(small(5.0))
    (library,) = libraries(tmp_path)
    # Another inode: a library that is loaded must not be written into.
    library.unlink()
    library.write_bytes(b"not a library")
    function = small(5.0)

    np.testing.assert_allclose(np.asarray(compiled(function)([1, 2, 3])[1]), 6.0)


@needs_compiler
def test_many_exponentials_at_a_time(tmp_path: Path) -> None:
    x = ca.MX.sym("x", 64)
    function = ca.Function("many", [x], [ca.exp(x) + ca.log(1 + x**2)])
    at = np.linspace(-30, 30, 64)

    quick = compiled(function, vectorised=True)

    assert quick is not function
    assert len(libraries(tmp_path)) == 1
    np.testing.assert_allclose(np.asarray(quick(at)), np.asarray(function(at)), rtol=1e-14)


@needs_compiler
def test_without_such_a_library_one_at_a_time(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    # The package has a function of the module's name.
    monkeypatch.setattr(sys.modules["symbolic.compiled"], "VECTORISED", ("-lno-such-library",))
    function = small(7.0)

    assert compiled(function, vectorised=True) is not function
    assert len(libraries(tmp_path)) == 1


def test_cache_folder_is_the_users(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    assert cache_directory() == tmp_path / "cache"
    monkeypatch.delenv("BRUSHGRIP_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert cache_directory() == tmp_path / "xdg" / "brushgrip"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert cache_directory() == tmp_path / ".cache" / "brushgrip"
