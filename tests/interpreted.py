"""Observers and models without machine code: a few samples of each take less time than a compiler."""

from functools import cache

import pytest

import observers.compiled_step
from symbolic import trajectory_sensitivity

COMPILING = {
    observers.compiled_step: ("compiled_step", "compiled_stretch"),
    trajectory_sensitivity: ("_compiled_sample_block",),
}
"""Modules that compile, and what they keep of it."""


def without_machine_code(patch: pytest.MonkeyPatch) -> None:
    """Has everything interpreted, and forgets that when the patch ends."""
    patch.setattr(trajectory_sensitivity, "bristle_kernel", lambda _: None)
    for module, kept in COMPILING.items():
        patch.setattr(module, "compiled", lambda function, **_: function)
        for name in kept:
            patch.setattr(module, name, cache(getattr(module, name).__wrapped__))
