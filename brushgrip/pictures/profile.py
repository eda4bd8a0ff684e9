"""What trades off against what: deviance along a value, and below it how another one gives way."""

from collections.abc import Mapping
from pathlib import Path

from matplotlib.artist import Artist
from matplotlib.axes import Axes

from brushgrip.pictures.style import AFTER, BEFORE, MEASURED, legend_above, literal, picture
from identification.fits.profile import LIMIT, Profile

_HIGHEST = 5.0
"""The deviance is shown up to this multiple of the limit, if it goes so far."""


def draw_profile(path: Path, profiles: Mapping[str, tuple[Profile, str]]) -> None:
    """A column for every profile.

    Args:
        path: of the picture, PNG.
        profiles: title of each column, its profile, and the parameter whose path stands below it.
    """
    with picture(path, 5.0) as figure:
        panels = figure.subplots(2, len(profiles), squeeze=False, sharex="col")
        artists: list[Artist] = []
        for (above, below), (title, (made, partner)) in zip(panels.T, profiles.items(), strict=True):
            artists = _deviance(above, made)
            above.set_title(f"{literal(title)}\n{_said(made)}")
            artists += below.plot(
                made.grid,
                made.paths[partner],
                "o-",
                color=BEFORE,
                ms=3,
                label="the other, fitted again at every value",
            )
            _shade(below, made)
            below.set_ylabel(_with_unit(partner, made.units[partner]))
            below.set_xlabel(_with_unit(made.name, made.unit))
        panels[0, 0].set_ylabel("deviance n ln(cost / least) [1]")
        figure.align_ylabels()
        legend_above(figure, artists)


def _deviance(axes: Axes, made: Profile) -> list[Artist]:
    artists: list[Artist] = [_shade(axes, made)]
    artists += axes.plot(made.grid, made.deviance, "o-", color=AFTER, ms=3, label="deviance")
    label = f"95 % limit, {LIMIT:.2f}"
    artists.append(axes.axhline(LIMIT, color=MEASURED, ls="--", lw=1.0, label=label))
    highest = min(float(made.deviance.max()), _HIGHEST * LIMIT)
    axes.set_ylim(-0.05 * _HIGHEST * LIMIT, 1.05 * max(highest, 1.5 * LIMIT))
    return artists


def _shade(axes: Axes, made: Profile) -> Artist:
    """The interval; where it is open, up to the end of the grid."""
    low, high = made.interval
    ends = (
        made.grid[0] if low is None else low,
        made.grid[-1] if high is None else high,
    )
    label = "95 % interval, up to the grid's end where open"
    return axes.axvspan(*ends, color=AFTER, alpha=0.1, lw=0, label=label)


def _said(made: Profile) -> str:
    low, high = made.interval
    if low is None and high is None:
        return "every value shown fits"
    if low is None:
        return f"95 %: at most {high:.4g}"
    if high is None:
        return f"95 %: at least {low:.4g}"
    return f"95 %: {low:.4g} to {high:.4g}"


def _with_unit(name: str, unit: str) -> str:
    return f"{literal(name)} [{unit}]"
