from collections.abc import Callable
from typing import Any

import pytest

from observers.embedded import Real
from tests.observers.embedded.building import Built, build

Build = Callable[[Any, Real], Built]


@pytest.fixture(scope="session")
def built(tmp_path_factory: pytest.TempPathFactory) -> Build:
    """Generates and compiles an observer, each once a session."""
    made: dict[Any, Built] = {}

    def once(observer: Any, real: Real) -> Built:
        key = (repr(observer), real)
        if key not in made:
            made[key] = build(observer, real, tmp_path_factory.mktemp("embedded"))
        return made[key]

    return once
