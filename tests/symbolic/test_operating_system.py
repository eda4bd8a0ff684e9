"""What differs between operating systems stands in one file; how compilers of others would be called."""

import ast
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import casadi as ca
import pytest

from symbolic import EFFECTS, Model
from symbolic.compilation.bristle_kernel import kernel_source
from symbolic.compilation.operating_system import MemoryLimit
from symbolic.compilation.toolchain import compiler_command, found_compiler

PACKAGES = ("symbolic", "observers", "identification", "brushgrip")
ALLOWED = {"symbolic/compilation/operating_system.py", "brushgrip/running/interrupts.py"}
"""The second, of signals, cannot wait for the import of the first."""
NOT_EVERYWHERE = re.compile(
    r"\b(import|from) (fcntl|grp|pty|pwd|readline|resource|syslog|termios|tty)\b|\bpreexec_fn\b"
    r"|\bos\.(fork|forkpty|kill|killpg|mkfifo|nice|geteuid|getuid|getgid|getpgid|getpgrp|setsid|setuid"
    r"|statvfs|sysconf|uname|wait|waitpid|sched_\w+|chown|fchmod|O_(DIRECTORY|NOFOLLOW|NONBLOCK))\b"
    r"|\bsignal\.(alarm|pause|pthread_\w+|setitimer|sigwait|SIG_BLOCK|SIG_SETMASK|ITIMER_\w+)\b"
    r"|\bsignal\.SIG(ALRM|CHLD|CONT|HUP|KILL|PIPE|QUIT|STOP|TSTP|USR[12]|XCPU|XFSZ)\b"
    r"|[\"'](/proc|/dev|/tmp|/etc|/bin|/usr)\b|get_context\([\"']fork|\.so[\"']"
)
FMU_OF_LINUX = "observers/embedded/fmu.py"
"""Builds on Linux alone, and says so."""


def sources(root: Path) -> Iterator[tuple[str, str]]:
    for package in PACKAGES:
        for path in sorted((root / package).rglob("*.py")):
            yield path.relative_to(root).as_posix(), path.read_text("utf-8")


def test_calls_of_one_system_stand_in_one_file(repository_root: Path) -> None:
    found = {
        (name, match[0])
        for name, text in sources(repository_root)
        if name not in ALLOWED
        for match in NOT_EVERYWHERE.finditer(text)
    }

    assert {(name, text) for name, text in found if (name, text) != (FMU_OF_LINUX, '.so"')} == set()
    assert NOT_EVERYWHERE.search((repository_root / min(ALLOWED)).read_text("utf-8"))


def test_texts_name_their_encoding(repository_root: Path) -> None:
    """On Windows the usual one is that of the country, and a written end of a line is two characters."""
    nameless = [
        f"{name}:{call.lineno}"
        for name, text in sources(repository_root)
        for call in ast.walk(ast.parse(text))
        if isinstance(call, ast.Call) and isinstance(call.func, ast.Attribute)
        if call.func.attr in ("read_text", "write_text")
        if len(call.args) < (1 if call.func.attr == "read_text" else 2)
        and "encoding" not in {word.arg for word in call.keywords}
    ]

    assert nameless == []


def test_a_compiler_is_found_by_cc_or_by_its_usual_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    own = tmp_path / "cc"
    own.write_text("#!/bin/sh\n")
    own.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr("symbolic.compilation.toolchain.COMPILERS", ("clang-cl", "cc"))

    assert found_compiler({}) == str(own)
    assert found_compiler({"CC": str(own)}) == str(own)
    assert found_compiler({"CC": "none"}) is None


@pytest.mark.parametrize(
    "command", ["cl", r"C:/VS/bin/cl.exe", "clang-cl", "/opt/llvm/bin/clang-cl.exe"]
)
def test_microsofts_compilers_have_options_of_their_own(command: str) -> None:
    line = compiler_command(command, ["a.c", "b.c"], "a.dll", ("-O2", "-fPIC", "-shared"), windows=True)

    assert line[0] == command
    assert {"/LD", "a.c", "b.c", "/Fea.dll"} <= set(line)
    assert not [word for word in line if word.startswith("-")]


def test_on_windows_there_is_neither_fpic_nor_lm() -> None:
    flags = ("-O2", "-fPIC", "-shared")

    there = compiler_command("clang", ["a.c"], "a.dll", flags, windows=True)
    here = compiler_command("clang", ["a.c"], "a.so", flags, windows=False)
    assert there == ["clang", "a.c", "-O2", "-shared", "-o", "a.dll"]
    assert here == ["clang", "a.c", "-O2", "-fPIC", "-shared", "-o", "a.so", "-lm"]


FUNCTIONS = (
    "acos asin atan ceil cos cosh erf exp expm1 fabs floor log log1p log10 sin sinh sqrt tan tanh"
)
MATH_H = "\n".join([
    *(f"double {name}(double); float {name}f(float);" for name in FUNCTIONS.split()),
    *(f"double {name}(double, double);" for name in ("atan2", "copysign", "fmax", "fmin", "fmod")),
    "double pow(double, double); double hypot(double, double);",
    "#define INFINITY ((float)(1e300 * 1e300))\n#define NAN ((float)(INFINITY * 0.0f))",
])  # fmt: skip


@pytest.mark.skipif(shutil.which("clang") is None, reason="needs clang")
def test_what_is_compiled_suits_microsofts_dialect(tmp_path: Path) -> None:
    """Parsed by clang as for Windows with MSVC's extensions; their headers are not at hand here."""
    model = Model(effects=(EFFECTS["viscoelastic_relaxation"],), bristles=20)
    generator = ca.CodeGenerator("step.c")
    generator.add(model.step)
    (tmp_path / "step.c").write_text(generator.dump())
    (tmp_path / "kernel.c").write_text(kernel_source(model))
    (tmp_path / "math.h").write_text(MATH_H)
    target = ["--target=x86_64-pc-windows-msvc", "-fms-compatibility", "-ffreestanding", "-std=c11"]
    for name in ("step.c", "kernel.c"):
        subprocess.run(
            ["clang", *target, "-fsyntax-only", "-Werror=implicit-function-declaration", "-I.", name],
            cwd=tmp_path, check=True,
        )  # fmt: skip

    text = (tmp_path / "kernel.c").read_text()
    command = ["clang", *target, "-E", "-I.", "kernel.c"]
    parsed = subprocess.run(command, cwd=tmp_path, check=True, capture_output=True).stdout
    assert b"__attribute__((always_inline" not in parsed
    assert b"__declspec(dllexport)" in parsed
    assert "#ifdef _WIN32" in text


@pytest.mark.skipif(sys.platform != "linux", reason="memory is bounded on Linux alone")
def test_a_fork_amid_a_reading_has_no_limit_and_no_lock_left() -> None:
    import resource

    limit, usual = MemoryLimit(4_000_000_000), resource.getrlimit(resource.RLIMIT_AS)
    with limit.lowered():
        child = os.fork()
        if child == 0:
            status = 1
            try:
                free = resource.getrlimit(resource.RLIMIT_AS) == usual
                with limit.lowered():
                    bounded = resource.getrlimit(resource.RLIMIT_AS) != usual
                free &= resource.getrlimit(resource.RLIMIT_AS) == usual
                status = 0 if free and bounded else 2
            finally:
                os._exit(status)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
        assert resource.getrlimit(resource.RLIMIT_AS) != usual
    assert resource.getrlimit(resource.RLIMIT_AS) == usual
