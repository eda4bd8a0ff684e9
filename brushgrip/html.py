"""Building blocks of a page that needs nothing beside itself."""

import base64
from collections.abc import Sequence
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import NamedTuple


class Cell(NamedTuple):
    """One cell of a table: its text, whether it is a figure, and whether it is a warning."""

    text: str
    number: bool = False
    warn: bool = False


def page(title: str, *blocks: str) -> str:
    """The whole page."""
    template = Template(files("brushgrip").joinpath("page.html").read_text(encoding="utf-8"))
    return template.substitute(title=escape(title), body="\n".join(blocks))


def section(title: str, *blocks: str) -> str:
    """A heading with what belongs to it."""
    return f"<section>\n<h2>{_text(title)}</h2>\n" + "\n".join(blocks) + "\n</section>"


def heading(text: str) -> str:
    """The headline of the page."""
    return f"<h1>{_text(text)}</h1>"


def paragraph(text: str, style: str = "") -> str:
    """A paragraph."""
    return f"<p{_class(style)}>{_text(text)}</p>"


def bullets(texts: Sequence[str]) -> str:
    """A list of sentences, nothing for none."""
    items = "".join(f"<li>{_text(text)}</li>\n" for text in texts)
    return f"<ul>\n{items}</ul>" if texts else ""


def table(
    caption: str, header: Sequence[Cell], rows: Sequence[Sequence[Cell]], *, narrow: bool = False
) -> str:
    """A table whose first column names the rows; a narrow one is only as wide as it needs to be."""
    head = "".join(_cell("th", cell, ' scope="col"') for cell in header)
    body = ""
    for first, *others in rows:
        cells = _cell("th", first, ' scope="row"') + "".join(_cell("td", c) for c in others)
        body += f"<tr>{cells}</tr>\n"
    return (
        f'<div class="scroll"><table{_class("narrow" if narrow else "")}>\n'
        f"<caption>{_text(caption)}</caption>\n"
        f"<thead><tr>{head}</tr></thead>\n<tbody>\n{body}</tbody>\n</table></div>"
    )


def figure(png: Path, alternative: str, caption: str) -> str:
    """A picture inside the page, with a text for those who cannot see it."""
    content = base64.b64encode(png.read_bytes()).decode("ascii")
    return (
        f'<figure><img alt="{escape(alternative)}" src="data:image/png;base64,{content}">\n'
        f"<figcaption>{_text(caption)}</figcaption></figure>"
    )


def _text(text: str) -> str:
    """The text as it stands, a percent sign kept on the line of its number."""
    return escape(text).replace(" %", "&nbsp;%")


def _cell(tag: str, cell: Cell, attributes: str = "") -> str:
    style = " ".join(name for name, on in (("number", cell.number), ("worse", cell.warn)) if on)
    return f"<{tag}{attributes}{_class(style)}>{_text(cell.text)}</{tag}>"


def _class(style: str) -> str:
    return f' class="{style}"' if style else ""
