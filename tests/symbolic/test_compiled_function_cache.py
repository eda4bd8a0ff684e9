"""Machine code against the interpreter, and every way in which there may be no machine code."""

import errno
import hashlib
import os
import signal
import stat
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from symbolic import EFFECTS, Model, compiled, compiler, effects_named, sensitivity_step
from symbolic.compilation import compiled_function_cache as module
from symbolic.compilation.cache_folder import cache_directory
from symbolic.compilation.compiled_function_cache import compiled_c_library
from tests.processes import is_running, wait_for
from tests.symbolic.oracles import random_path, signals
from tests.symbolic.test_effects import VALUES

ELSEWHERE = ("viscoelastic_relaxation", "frictional_creep", "carcass_torsion")
OTHERS = [n for n in EFFECTS if n not in ELSEWHERE]
OTHER_VALUES = tuple(value for name in OTHERS for value in VALUES[name].values())
needs_users = pytest.mark.skipif(not hasattr(os, "geteuid"), reason="files have no owner here")
needs_compiler = pytest.mark.skipif(compiler() is None, reason="no C compiler at hand")


@pytest.fixture(autouse=True)
def fresh(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """An empty cache, and a compiler that is looked for anew."""
    monkeypatch.setenv("BRUSHGRIP_CACHE", str(tmp_path / "cache"))
    compiler.cache_clear()
    module._WARNED.clear()
    yield
    compiler.cache_clear()


def small(factor: float = 2.0) -> ca.Function:
    x = ca.SX.sym("x", 3)
    return ca.Function("small", [x], [factor * ca.sin(x), ca.sum1(x)], ["x"], ["y", "total"])


def claiming(library: Path, content: bytes) -> Path:
    """The library's path with the digest of another content in its name."""
    stem = library.stem.rpartition("_")[0]
    digest = hashlib.sha256(stem.encode() + content).hexdigest()[:24]
    return library.with_stem(f"{stem}_{digest}")


def libraries(folder: Path) -> list[Path]:
    return sorted(folder.glob("cache/*"))


@needs_compiler
@pytest.mark.parametrize(
    ("model", "own"),
    [
        (Model(corners=8), ()),
        (Model(discretised=True, bristles=20), ()),
        (Model(effects=(EFFECTS["viscoelastic_relaxation"],), bristles=20), (0.5, 0.6)),
        (
            Model(effects=effects_named(["frictional_creep", "carcass_torsion"]), bristles=20),
            (0.15, 1 / 350),
        ),
        pytest.param(
            Model(effects=effects_named(OTHERS), bristles=8), OTHER_VALUES, marks=pytest.mark.long
        ),
    ],
    ids=["zones", "bristles", "relaxing bristles", "creep behind a carcass", "every other effect"],
)
@pytest.mark.parametrize(
    "vectorised",
    [pytest.param(False, id="plain", marks=pytest.mark.long), pytest.param(True, id="vectorised")],
)
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
    assert max(relative) <= 1e-12


@needs_compiler
def test_library_is_kept_and_used_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert compiled(small()) is not None
    kept = libraries(tmp_path)
    assert [path.suffix for path in kept] == [".so"], "no scratch is left behind"

    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("compiled again")

    monkeypatch.setattr(module, "run_compiler", refuse)

    np.testing.assert_allclose(np.asarray(compiled(small())([0, 1, 2])[1]), 3.0)
    assert libraries(tmp_path) == kept


@needs_compiler
def test_flags_are_tried_once_for_a_cache(monkeypatch: pytest.MonkeyPatch) -> None:
    tried: list[object] = []
    run = module.run_compiler
    monkeypatch.setattr(module, "run_compiler", lambda *call: (tried.append(call), run(*call)))
    for _ in range(2):
        module._compiler_accepts_flags.cache_clear()  # As in another process.
        assert module._compiler_accepts_flags(str(compiler()), ("-O1",))
        assert not module._compiler_accepts_flags(str(compiler()), ("-no-such-flag",))

    assert len(tried) == 3


@needs_compiler
def test_changed_function_does_not_meet_a_stale_library(tmp_path: Path) -> None:
    two, three = compiled(small(2.0)), compiled(small(3.0))

    assert len(libraries(tmp_path)) == 2
    np.testing.assert_allclose(np.asarray(three([1, 1, 1])[0]), 1.5 * np.asarray(two([1, 1, 1])[0]))


@pytest.mark.parametrize(
    ("environment", "said"),
    [
        ({"BRUSHGRIP_INTERPRET": "1"}, []),
        ({"CC": "/bin/false"}, ["interpreted instead, which is slow"]),
        ({"CC": "no-such-compiler"}, ["models are interpreted, which is slow"]),
    ],
    ids=["asked to interpret", "broken compiler", "missing compiler"],
)
def test_function_is_interpreted_where_it_cannot_be_compiled(
    environment: dict[str, str],
    said: list[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    caplog: pytest.LogCaptureFixture,
) -> None:
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    function = small()

    assert [compiled(function) for _ in range(2)] == [function, function]
    assert compiled_c_library("forty_two", "int answer(void) { return 42; }") is None
    assert libraries(tmp_path) == []
    assert [part in line for part, line in zip(said, caplog.messages, strict=True)] == [True] * len(said)


@needs_compiler
def test_a_cache_that_cannot_be_written_has_another_in_its_place(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    # A file in the way of the folder stops every user, the superuser too.
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("BRUSHGRIP_CACHE", str(tmp_path / "file" / "cache"))
    function = small()

    assert compiled(function) is not function
    assert compiled(small(3.0)) is not function
    (line,) = caplog.messages
    assert f"{tmp_path / 'file' / 'cache'} cannot be written" in line
    assert "what is compiled now is not kept" in line


@needs_compiler
def test_a_full_disk_has_another_folder_in_its_place(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    temporary_folder = module.temporary_folder

    def full(parent: Path) -> object:
        if parent == tmp_path / "cache":
            raise OSError(errno.ENOSPC, "No space left on device")
        return temporary_folder(parent)

    monkeypatch.setattr(module, "temporary_folder", full)
    function = small()

    assert compiled(function) is not function
    assert "cannot be written (No space left on device)" in caplog.text


@needs_compiler
def test_a_compiler_that_makes_rubbish_is_one_line_for_all_models(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    script = tmp_path / "rubbish"
    script.write_text('#!/bin/sh\nwhile [ "$1" != -o ]; do shift; done\necho half > "$2"\n')
    script.chmod(0o700)
    monkeypatch.setenv("CC", str(script))

    for function in (small(), small(3.0)):
        assert compiled(function) is function
    (line,) = caplog.messages
    assert f"what {script} makes cannot be loaded" in line
    assert "\n" not in line
    assert list((tmp_path / "cache").iterdir()) == []


@needs_compiler
def test_an_interrupted_compiler_ends_with_all_that_it_started(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    compiler_of_a_minute = tmp_path / "compiler"
    compiler_of_a_minute.write_text(
        f"#!/bin/sh\nsleep 60 &\necho $! > {tmp_path}/pid\nsleep 0.5\nkill -USR1 $PPID\nwait\n"
    )
    compiler_of_a_minute.chmod(0o700)
    monkeypatch.setenv("CC", str(compiler_of_a_minute))

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGUSR1, interrupt)
    try:
        with pytest.raises(KeyboardInterrupt):
            compiled(small())
    finally:
        signal.signal(signal.SIGUSR1, before)
    pid = int((tmp_path / "pid").read_text())

    assert libraries(tmp_path) == []
    wait_for(lambda: not is_running(pid))


@needs_compiler
@pytest.mark.parametrize(
    ("damage", "is_named_so"),
    [
        *(
            pytest.param(
                lambda whole, share=share: whole[: int(share * len(whole))], False, id=f"{share}"
            )
            for share in (0.0, 0.1, 0.5, 0.99)
        ),
        pytest.param(lambda _: b"not a library", False, id="damaged"),
        pytest.param(lambda _: b"not a library", True, id="of another machine"),
    ],
)
def test_a_library_that_does_not_load_is_built_anew(
    tmp_path: Path, damage: Callable[[bytes], bytes], is_named_so: bool
) -> None:
    compiled(small(5.0))
    (library,) = libraries(tmp_path)
    whole = library.read_bytes()
    content = damage(whole)
    # Another inode: a library that is loaded must not be written into.
    library.unlink()
    if is_named_so:
        library = claiming(library, content)
    library.write_bytes(content)
    library.chmod(0o700)
    function = small(5.0)
    again = compiled(function)

    assert again is not function
    np.testing.assert_allclose(np.asarray(again([1, 2, 3])[1]), 6.0)
    assert [path.read_bytes() for path in libraries(tmp_path)] == [whole]


def two_and_three(folder: Path) -> tuple[Path, Path]:
    """The libraries of `small(2)` and `small(3)`."""
    compiled(small(2.0))
    (two,) = libraries(folder)
    compiled(small(3.0))
    (three,) = set(libraries(folder)) - {two}
    return two, three


def planted(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Moves the cache; where the library of `small(2)` should be, there is that of `small(3)`."""
    two, three = two_and_three(folder)
    cache = folder / "planted" / "cache"
    cache.mkdir(parents=True, mode=0o700)
    three.rename(cache / claiming(two, three.read_bytes()).name)
    monkeypatch.setenv("BRUSHGRIP_CACHE", str(cache))
    return cache


@needs_compiler
def test_a_library_under_another_name_is_not_run(tmp_path: Path) -> None:
    two, three = two_and_three(tmp_path)
    two.unlink()
    three.rename(two.with_stem("_".join([two.stem.rpartition("_")[0], three.stem.rpartition("_")[2]])))

    assert is_doubling(compiled(small(2.0)))


def is_doubling(function: ca.Function) -> bool:
    return bool(np.allclose(np.asarray(function([1, 1, 1])[0]), 2 * np.sin(1)))


@needs_compiler
def test_a_planted_library_would_be_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # Without this the tests below would show nothing.
    planted(tmp_path, monkeypatch)

    assert not is_doubling(compiled(small(2.0)))


@needs_compiler
@needs_users
@pytest.mark.parametrize(
    ("mode", "is_linked"),
    [(0o722, False), (0o702, False), (0o777, False), (0o1777, False), (0o777, True)],
)
def test_a_folder_that_others_may_write_to_is_not_used(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
    mode: int,
    is_linked: bool,
) -> None:
    cache = planted(tmp_path, monkeypatch)
    before = sorted(cache.iterdir())
    cache.chmod(mode)
    if is_linked:
        (tmp_path / "link").symlink_to(cache)
        monkeypatch.setenv("BRUSHGRIP_CACHE", str(tmp_path / "link"))
    made = [compiled(small(factor)) for factor in (2.0, 4.0, 2.0)]

    assert [is_doubling(function) for function in made] == [True, False, True]
    assert sorted(cache.iterdir()) == before
    (line,) = caplog.messages
    assert f"{cache} may be written by other users" in line
    assert "Remove that folder, or name one of your own in BRUSHGRIP_CACHE" in line
    assert stat.S_IMODE(cache_directory().stat().st_mode) == 0o700


@needs_compiler
@needs_users
@pytest.mark.parametrize("mode", [0o720, 0o775], ids=oct)
def test_an_own_folder_is_closed_to_the_group(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, mode: int
) -> None:
    cache = planted(tmp_path, monkeypatch)
    (cache / "foreign.so").write_bytes(b"")
    cache.chmod(mode)

    assert is_doubling(compiled(small(2.0))), "a member of the group may have renamed libraries"
    assert stat.S_IMODE(cache.stat().st_mode) == mode & ~0o020
    assert caplog.messages == []
    kept = sorted(cache.iterdir())
    assert len(kept) == 2
    assert kept[0].name == "foreign.so"
    assert is_doubling(compiled(small(2.0)))
    assert sorted(cache.iterdir()) == kept


@needs_compiler
@needs_users
@pytest.mark.parametrize(("mode", "is_used"), [(0o777, False), (0o1777, True), (0o775, True)])
def test_a_folder_that_others_may_replace_is_not_used(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
    mode: int,
    is_used: bool,
) -> None:
    open_folder, cache = tmp_path / "open", tmp_path / "open" / "own" / "cache"
    cache.mkdir(parents=True, mode=0o700)
    open_folder.chmod(mode)
    monkeypatch.setenv("BRUSHGRIP_CACHE", str(cache))
    function = small(2.0)

    assert compiled(function) is not function
    assert bool(list(cache.iterdir())) is is_used
    expected = f"{cache} lies in {open_folder}, where other users may replace it"
    assert [expected in line for line in caplog.messages] == ([] if is_used else [True])


@needs_compiler
@needs_users
def test_a_folder_of_another_user_is_not_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    cache = planted(tmp_path, monkeypatch)
    monkeypatch.setattr(os, "geteuid", lambda: cache.stat().st_uid + 1)

    assert is_doubling(compiled(small(2.0)))
    assert f"{cache} belongs to another user" in caplog.text


@needs_compiler
@needs_users
@pytest.mark.parametrize("fault", ["group", "others", "owner", "link"])
def test_a_library_that_others_may_have_written_is_built_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fault: str
) -> None:
    cache = planted(tmp_path, monkeypatch)
    (library,) = cache.iterdir()
    if fault == "link":
        library.rename(tmp_path / library.name)
        library.symlink_to(tmp_path / library.name)
    elif fault == "owner":
        if os.geteuid() != 0:
            pytest.skip("only the superuser gives files away")
        os.chown(library, 12345, -1)
    else:
        library.chmod({"group": 0o720, "others": 0o702}[fault])

    assert is_doubling(compiled(small(2.0)))
    (library,) = cache.iterdir()
    assert not library.is_symlink()
    assert library.stat().st_uid == os.geteuid()
    assert not library.stat().st_mode & 0o022


@needs_compiler
def test_without_users_nothing_is_asked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.delattr(os, "geteuid", raising=False)
    (tmp_path / "cache").mkdir()
    (tmp_path / "cache").chmod(0o777)
    compiled(small())

    assert len(libraries(tmp_path)) == 1
    assert caplog.messages == []


@needs_compiler
@needs_users
def test_what_is_kept_is_the_users_alone(tmp_path: Path) -> None:
    before = os.umask(0)
    try:
        compiled(small())
    finally:
        os.umask(before)
    kept = [tmp_path / "cache", *libraries(tmp_path)]

    assert [stat.S_IMODE(path.stat().st_mode) for path in kept] == [0o700, 0o700]


@needs_compiler
@needs_users
def test_the_folder_in_its_place_goes_with_the_process(tmp_path: Path, repository_root: Path) -> None:
    for name in ("cache", "temporary"):
        (tmp_path / name).mkdir()
        (tmp_path / name).chmod(0o777)
    child = "import subprocess, sys; subprocess.run([sys.executable, '-c', sys.argv[1], ''], check=True)"
    code = (
        "import sys, casadi as ca; from symbolic import compiled; x = ca.SX.sym('x');"
        "f = ca.Function('f', [x], [ca.sin(x)]); assert compiled(f) is not f;"
        f"sys.argv[1] and exec({child!r})"
    )
    environment = {**os.environ, "TMPDIR": str(tmp_path / "temporary")}
    command, told = [sys.executable, "-c", code, code], {"capture_output": True, "text": True}
    ended = subprocess.run(command, cwd=repository_root, env=environment, **told)

    assert ended.returncode == 0, ended.stderr
    assert ended.stderr.count("\n") == 1, "a process that this one starts uses its folder"
    assert str(tmp_path / "cache") in ended.stderr
    assert [list((tmp_path / name).iterdir()) for name in ("cache", "temporary")] == [[], []]


@needs_compiler
def test_without_such_a_library_one_at_a_time(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(module, "VECTORISED", ("-lno-such-library",))
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


@needs_compiler
def test_source_of_ours_is_a_library_of_the_cache(tmp_path: Path) -> None:
    library = compiled_c_library("forty_two", "int answer(void) { return 42; }")

    assert library is not None
    assert library.answer() == 42
    assert len(list((tmp_path / "cache").glob("forty_two_*.so"))) == 1
