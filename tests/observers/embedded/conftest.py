from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from observers.embedded import Real, generate_fmu
from tests.each_once import each_once
from tests.observers.embedded.generated_code import GeneratedCode, generate_code

Generate = Callable[[Any, Real], GeneratedCode]
Unpacked = Callable[..., Path]


@pytest.fixture(scope="session")
def generated(tmp_path_factory: pytest.TempPathFactory) -> Generate:
    """Generates and compiles an observer, each once a session."""
    return each_once(lambda observer, real: generate_code(observer, real, tmp_path_factory.mktemp("c")))


@pytest.fixture(scope="session")
def unpacked(tmp_path_factory: pytest.TempPathFactory) -> Unpacked:
    """Generates an FMU of a version, 2 if none is given, and unpacks it, each once a session."""

    def unpack(observer: Any, real: Real, version: int = 2) -> Path:
        import fmpy

        folder = tmp_path_factory.mktemp("fmu")
        archive = generate_fmu(observer, folder, real, version=version)
        return Path(fmpy.extract(str(archive), str(folder / "unpacked")))

    return each_once(unpack)
