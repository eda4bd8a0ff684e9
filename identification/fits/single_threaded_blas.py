"""Linear algebra in one thread: for matrices as narrow as a fit's several threads take longer than one.

The last digits of a result depend on the number of threads too.
"""

from collections.abc import Callable
from functools import cache, wraps
from typing import ParamSpec, TypeVar

from threadpoolctl import ThreadpoolController

P = ParamSpec("P")
R = TypeVar("R")


def one_thread(function: Callable[P, R]) -> Callable[P, R]:
    """The function with its linear algebra in one thread."""

    @wraps(function)
    def limited(*args: P.args, **kwargs: P.kwargs) -> R:
        with _libraries().limit(limits=1, user_api="blas"):
            return function(*args, **kwargs)

    return limited


@cache
def _libraries() -> ThreadpoolController:
    """The libraries of linear algebra; those of SciPy are loaded once something is fitted."""
    return ThreadpoolController()
