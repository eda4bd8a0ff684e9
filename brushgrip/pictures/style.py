"""Style of all pictures: colours, figure, legend, titles and the order of recordings."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar, copy_context
from math import ceil
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from warnings import catch_warnings, filterwarnings

from matplotlib import rc_context
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from identification import Diagnosis, Series
from identification.loop_plot import matplotlib_text

MEASURED, BEFORE, AFTER, QUIET = "#3c3c3c", "#e07b00", "#0063a8", "#b9bec4"
"""Dark grey, orange, blue and light grey; people with colour blindness tell them apart."""
TRACKS = (BEFORE, AFTER, "#008f6b", "#a0559c")
"""Colours of estimates of friction; the declared model comes first."""
WIDTH = 10.0
"""Width of most pictures [in]."""

_DPI = 110
_SOURCE, _BEGINNING = "brushgrip", 1024
"""Mark of our pictures, and the bytes within which it stands."""
_LETTERS_ACROSS, _LETTERS_PER_SYMBOL = 55, 8
_VECTORS: ContextVar[bool] = ContextVar("_VECTORS", default=False)
_NO_METADATA: dict[str, Any] = dict.fromkeys(("Date", "Creator", "Format", "Type"))
_STYLE: dict[Any, Any] = {
    "svg.hashsalt": "brushgrip",
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e6e8ea",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.2,
    "legend.frameon": False,
}


@contextmanager
def figure_saved_as_png(path: Path, height: float, width: float = WIDTH) -> Iterator[Figure]:
    """An empty figure, of the common width if none is given [in], written to `path` (PNG) in the end."""
    with rc_context(_STYLE), catch_warnings():
        # A name in a script that the font lacks is drawn as boxes.
        filterwarnings("ignore", message="Glyph .* missing from font")
        figure = Figure((width, height), _DPI, layout="constrained", facecolor="white")
        yield figure
        # `savefig` would draw everything once more, to lay it out.
        FigureCanvasAgg(figure).print_png(path, metadata={"Software": None, "Source": _SOURCE})  # type: ignore[no-untyped-call]
        if _VECTORS.get():
            figure.set_layout_engine("none")  # Everything is in its place by now.
            FigureCanvasSVG(figure).print_svg(path.with_suffix(".svg"), metadata=_NO_METADATA)  # type: ignore[no-untyped-call]


def picture_as_png_and_svg(
    draw: Callable[..., None], name: str, content: Sequence[Any], wanted: bool
) -> tuple[bytes, bytes | None]:
    """A picture as PNG and, where wanted, as SVG: what `draw` makes of a path and the content."""
    context = copy_context()
    context.run(_VECTORS.set, wanted)
    with TemporaryDirectory() as folder:
        path = Path(folder) / name
        context.run(draw, path, *content)
        lines = path.with_suffix(".svg")
        return path.read_bytes(), lines.read_bytes() if lines.exists() else None


def is_drawn_by_us(path: Path) -> bool:
    """Whether a file is a picture that `figure_saved_as_png` has written."""
    with path.open("rb") as file:
        return f"tEXtSource\0{_SOURCE}".encode() in file.read(_BEGINNING)


def legend_above(figure: Figure, artists: list[Artist]) -> None:
    """Put a legend above all axes, where it covers no data, on the left, which a narrow screen shows."""
    labels = [str(artist.get_label()) for artist in artists]
    width = _LETTERS_ACROSS - _LETTERS_PER_SYMBOL * len(labels)
    rows = 1 + sum(map(len, labels)) // max(width, 1)
    columns = max(1, ceil(len(labels) / rows))
    figure.legend(artists, labels, loc="outside upper left", ncols=columns)


def representative_first(diagnosis: Diagnosis) -> list[Series]:
    """Every recording: the representative one first, then held-out ones, then training ones."""
    first = diagnosis.median_error_series
    others = [series for series in diagnosis.series if series is not first]
    return [first, *sorted(others, key=lambda series: not series.held_out)]


def set_title(axes: Axes, series: Series, text: str = "") -> None:
    """Put the name of a recording and its use (held out, training) over the axes."""
    role = "validation" if series.held_out else "training"
    axes.set_title(f"{matplotlib_text(series.name)} ({role}){text}")
