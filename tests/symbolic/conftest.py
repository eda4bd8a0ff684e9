from collections.abc import Iterator
from functools import cache

import pytest

from symbolic import trajectory


@pytest.fixture(scope="module")
def interpreted() -> Iterator[None]:
    """Simulation without machine code: one of each model takes less time than its compiler does."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(trajectory, "compiled", lambda function, **_: function)
        patch.setattr(trajectory, "_functions", cache(trajectory._functions.__wrapped__))
        yield
