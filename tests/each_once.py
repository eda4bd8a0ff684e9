"""What several tests make alike is made once."""

from collections.abc import Callable
from typing import Any


def each_once(build: Callable[..., Any]) -> Callable[..., Any]:
    """The same function, whose result for the same arguments is kept."""
    cache: dict[str, Any] = {}

    def once(*arguments: Any, **options: Any) -> Any:
        if (key := repr((arguments, options))) not in cache:
            cache[key] = build(*arguments, **options)
        return cache[key]

    return once
