"""The one line by which a bad input is refused."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from symbolic import InvalidInputError


def refused(call: Callable[..., object], *arguments: Any, **named: Any) -> str:
    """The message with which a call ends."""
    with pytest.raises(InvalidInputError) as caught:
        call(*arguments, **named)
    message = str(caught.value)
    assert "\n" not in message
    return message


def fault_of(read: Callable[..., object], path: Path, *arguments: Any) -> str:
    """The message about a file, without its path, with which it begins."""
    message = refused(read, path, *arguments)
    assert message.startswith(f"{path}: ")
    return message.removeprefix(f"{path}: ")
