"""A state that was stored: its own code goes on from it, any other refuses it."""

import ctypes
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from observers import ESTIMATE
from observers.embedded import SINGLE
from observers.embedded.codegen import REFUSED
from reference_rig import RigRecording
from tests.observers.embedded.conftest import Generate
from tests.observers.embedded.generated_code import (
    GeneratedCode,
    RunningCode,
    generate_code,
    needs_compiler,
    observer_named,
    rows_of,
)

pytestmark = needs_compiler


def header(code: GeneratedCode) -> str:
    return (code.folder / "brushgrip.h").read_text("utf-8")


def macro(code: GeneratedCode, name: str) -> int:
    found = re.search(rf"#define BRUSHGRIP_STATE_{name} (\w+?)u?\n", header(code))
    assert found is not None
    return int(found[1], 0)


def stored(running: RunningCode) -> bytes:
    return ctypes.string_at(running.at, running.code.library.state_size())


def restore(running: RunningCode, kept: bytes, size: int | None = None) -> int:
    given = ctypes.create_string_buffer(kept, len(kept))
    number = ctypes.c_uint32(len(kept) if size is None else size)
    return int(running.code.library.brushgrip_restore(running.at, given, number))


@pytest.mark.parametrize("name", ["ekf declared aligning", "mhe declared aligning"])
def test_its_own_code_goes_on(generated: Generate, recording: RigRecording, name: str) -> None:
    code, rows = generated(observer_named(name), SINGLE), rows_of(recording)[:300]
    first, second = RunningCode(code), RunningCode(code)
    first.run(rows[:200])
    kept = stored(first)

    assert len(kept) == macro(code, "BYTES")
    assert restore(second, kept) == 0
    np.testing.assert_array_equal(second.run(rows[200:]), first.run(rows[200:]))


def test_a_foreign_or_older_state_is_refused(
    generated: Generate, recording: RigRecording, tmp_path: Path
) -> None:
    rows = rows_of(recording)[:200]
    code = generated(observer_named("ekf declared aligning"), SINGLE)
    other = generate_code(observer_named("ekf declared aligning", mu=0.8), SINGLE, tmp_path)
    running, foreign = RunningCode(code), RunningCode(other)
    running.run(rows)
    kept = stored(running)
    older = bytes([kept[0] ^ 1, *kept[1:]])

    assert macro(code, "LAYOUT") != macro(other, "LAYOUT")
    for bytes_, size in ((stored(foreign), None), (older, None), (kept[:-4], None), (kept, 4)):
        assert restore(running, bytes_, size) == 1
        assert stored(running) == kept


def test_a_state_that_nobody_initialised_says_so(generated: Generate, recording: RigRecording) -> None:
    code = generated(observer_named("ekf declared aligning"), SINGLE)
    running = RunningCode(code)
    size = code.library.state_size()
    for garbage in (bytes(size), b"\xff" * size):
        ctypes.memmove(running.at, garbage, size)
        estimates = running.run(rows_of(recording)[:50])

        assert (estimates[:, ESTIMATE.index("status")] == REFUSED).all()
        assert not estimates[:, ESTIMATE.index("usable")].any()
        assert np.isnan(estimates[:, 0]).all()
        assert stored(running) == garbage


def test_the_header_says_for_which_tyre_and_rig(generated: Generate) -> None:
    text = header(generated(observer_named("ekf declared aligning"), SINGLE))

    assert "For k = 2.4e+06 N/m^2, a = 0.045 m, e = 0.009 m." in text


def test_the_steps_of_the_filter_and_its_states_are_named(generated: Generate) -> None:
    text = generated(observer_named("ekf declared steering"), SINGLE).folder / "brushgrip.c"
    body = re.search(r"void brushgrip_filter\(.*?^}", text.read_text("utf-8"), re.S | re.M)
    assert body is not None
    comments: list[Any] = re.findall(r"/\* (.*?) \*/", body[0])
    steps = ["Predict", "Innovation", "Gate", "Update", "What the next", "Output"]
    order = [next(i for i, c in enumerate(comments) if c.startswith(step)) for step in steps]

    assert order == sorted(order)
    for state in observer_named("ekf declared steering").states:
        assert re.search(rf"x_next\[\d\] = .*; /\* {state} \*/", body[0])
        assert f"D of {state}" in comments
    assert any("variance of the innovation" in comment for comment in comments)
