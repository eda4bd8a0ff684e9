"""Templates of C and what they are filled with."""

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from string import Template


@dataclass(frozen=True, kw_only=True)
class Body:
    """What a kind of code puts behind the common interface.

    Attributes:
        core: C that computes, in the type.
        stepping: C of `begin` and `advance`, which the interface calls.
        private: fields of the state, lines of C.
        bytes: size of these fields.
        types: types that they need, C of the header.
    """

    core: str
    stepping: str
    private: str
    bytes: int
    types: str = ""


def filled(template: str, terms: Mapping[str, str]) -> str:
    """A template of this package with its places filled."""
    text = resources.files("observers.embedded").joinpath("templates", template).read_text("utf-8")
    return Template(text).substitute(terms)
