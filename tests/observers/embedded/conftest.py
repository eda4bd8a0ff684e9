from collections.abc import Callable
from typing import Any

import pytest

from observers.embedded import Real
from tests.observers.embedded.generated_code import GeneratedCode, generate_code

Generate = Callable[[Any, Real], GeneratedCode]


@pytest.fixture(scope="session")
def generated(tmp_path_factory: pytest.TempPathFactory) -> Generate:
    """Generates and compiles an observer, each once a session."""
    cache: dict[Any, GeneratedCode] = {}

    def once(observer: Any, real: Real) -> GeneratedCode:
        key = (repr(observer), real)
        if key not in cache:
            cache[key] = generate_code(observer, real, tmp_path_factory.mktemp("embedded"))
        return cache[key]

    return once
