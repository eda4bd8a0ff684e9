"""A small table in HTML, as notebooks show a result."""

from collections.abc import Iterable
from html import escape

from symbolic.errors import printable

_LEFT = ' style="text-align: left"'


def html_table(title: str, rows: Iterable[tuple[str, str]]) -> str:
    """A table of two columns, what and its value, under a title; all text is escaped."""
    lines = [
        f"<tr><th{_LEFT}>{_escaped(what)}</th><td{_LEFT}>{_escaped(value)}</td></tr>"
        for what, value in rows
    ]
    return f"<table><caption>{_escaped(title)}</caption><tbody>{''.join(lines)}</tbody></table>"


def _escaped(text: str) -> str:
    return escape(printable(text))
