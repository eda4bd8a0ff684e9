"""What the residual follows: its autocorrelation, and its correlation with the signals."""

from collections.abc import Sequence
from pathlib import Path

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from brushgrip.pictures.style import AFTER, BEFORE, MEASURED, QUIET, legend_above, picture
from identification.residuals.signatures import Signatures

Look = tuple[Signatures, str, str]
"""What was found, its colour and its label."""


def draw_signatures(path: Path, before: Signatures, after: Signatures | None = None) -> None:
    """Autocorrelation over lag beside a bar for each signal, each with what chance leaves.

    Args:
        path: the picture, PNG.
        before: of the declared structure, refitted.
        after: with the effects found; None where there are none.
    """
    looks: list[Look] = [(before, BEFORE, "before: declared structure, refitted")]
    if after is not None:
        looks.append((after, AFTER, "after: with the effects found"))
    with picture(path, 1.2 + 0.34 * len(before.signatures)) as figure:
        memory, following = figure.subplots(1, 2, width_ratios=[2, 3])
        _autocorrelation(memory, looks)
        _bars(following, looks)
        key: list[Artist] = [Patch(color=colour, label=label) for _, colour, label in looks]
        key.append(Patch(color=QUIET, label="99 % of what chance leaves"))
        legend_above(figure, key)


def _autocorrelation(axes: Axes, looks: Sequence[Look]) -> None:
    """White noise keeps within the band at every lag."""
    widest = max(look.autocorrelation.band for look, _, _ in looks)
    axes.axhspan(-widest, widest, color=QUIET, alpha=0.7, lw=0)
    for look, colour, _ in looks:
        known = look.autocorrelation
        axes.plot([0.0, *known.lags], [1.0, *known.values], color=colour)
    axes.axhline(0, color=MEASURED, lw=0.7)
    axes.set_ylim(top=1.04)
    axes.margins(x=0)
    axes.set_xlabel("lag [s]")
    axes.set_ylabel("autocorrelation of the residual [1]")
    axes.set_title("what the residual remembers")


def _bars(axes: Axes, looks: Sequence[Look]) -> None:
    """Each bar lies on the band that independent residuals of the same slowness keep."""
    names = [signature.signal for signature in looks[0][0].signatures]
    height = 0.8 / len(looks)
    for number, (look, colour, _) in enumerate(looks):
        for row, signature in enumerate(look.signatures):
            y = row + (number - (len(looks) - 1) / 2) * height
            axes.barh(y, 2 * signature.band, left=-signature.band, height=height, color=QUIET, alpha=0.7)
            axes.barh(y, signature.correlation, height=0.55 * height, color=colour)
    axes.axvline(0, color=MEASURED, lw=0.7)
    axes.set_yticks(range(len(names)), names)
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    axes.set_xlim(-1.02, 1.02)
    axes.set_xlabel("correlation of the residual, model − measured [1]")
    axes.set_title("what the residual follows")
