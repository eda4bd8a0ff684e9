"""What a recording cannot tell apart
==================================

What a recording cannot tell apart: friction from contact length, bristles from carcass.

.. code-block:: sh

    python examples/trade_offs.py [PICTURE.png]

The recordings come from the independent rig. With the caster length 0, M_z depends on a, mu and k only
through mu a and k a^2/mu: any contact length fits as well as any other, and mu follows as 1/a. A caster
length tells them apart, though not well. The bristles' stiffness k and the torsional stiffness k_t of
the carcass are in series: where the patch sticks, a softer one is made up for by a stiffer other, and
only how the torque bends when the patch begins to slide tells which.
"""

import sys
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from brushgrip.pictures.style import AFTER, BEFORE, MEASURED, figure_saved_as_png, legend_above
from identification import LIMIT, Recording, fit, initial_guess
from identification.fits.covariance import parameter_correlation, standard_deviations
from identification.fits.profile_likelihood import HALF_LENGTH, Profile, ProfiledParameter, profile
from identification.loop_plot import matplotlib_text
from reference_rig import RigTyre, make_recording
from rig_recordings import as_read
from symbolic import Model, effects_named

A, K, MU, K_T = 0.045, 2.4e6, 1.3, 400.0
CASTER = 0.009
NOISE = 0.004
"""White noise of the torque, share of its range [1]."""
FACTORS = np.linspace(0.8, 1.2, 9)
"""Contact lengths, over the true one."""
STIFFNESSES = K * np.linspace(0.98, 1.02, 9)
"""Stiffnesses of the bristles [N/m^2]."""
HIGHEST = 5.0
"""The deviance is shown up to this multiple of the limit, if it goes so far."""


def record(seed: int, e: float, k_t: float | None) -> list[Recording]:
    """A recording of the rig, with its carcass twisting or not."""
    effects = {"carcass_torsion": {"k_t": k_t}} if k_t else {}
    result = make_recording(seed, effects, a=A, e=e, k=K, mu=MU, noise=NOISE)
    return [as_read(result, RigTyre(a=A, e=e, k=K))]


def friction_or_length(e: float) -> Profile:
    """The profile along the contact length, as factors on the true one."""
    recordings, model = record(5, e, None), Model(corners=16)
    return profile(model, recordings, initial_guess(model, recordings), HALF_LENGTH, FACTORS)


def bristles_or_carcass() -> tuple[Profile, float, float]:
    """The profile along k; the deviation of k by the fit alone, and its correlation with 1/k_t."""
    recordings = record(5, CASTER, K_T)
    model = Model(effects=effects_named(["carcass_torsion"]), corners=16)
    fitted = fit(model, recordings, initial_guess(model, recordings))
    k, k_t = (fitted.labels.index((None, name)) for name in ("k", "carcass_torsion.k_t"))
    result = profile(model, recordings, fitted.values, ProfiledParameter(name="k"), STIFFNESSES)
    spread, correlated = (
        standard_deviations(fitted, recordings),
        parameter_correlation(fitted, recordings),
    )
    return result, float(spread[k]), float(correlated[k, k_t])


def interval_sentence(result: Profile) -> str:
    """The interval in words."""
    low, high = result.interval
    if low is None and high is None:
        return f"every value from {result.grid[0]:.4g} to {result.grid[-1]:.4g} fits"
    ends = ["open" if end is None else f"{end:.4g}" for end in (low, high)]
    return f"95 % interval {ends[0]} to {ends[1]}, best {result.best:.4g}"


def draw_profile(path: Path, profiles: Mapping[str, tuple[Profile, str]]) -> None:
    """Draw columns: the deviance along one parameter, and below it the named one, refitted."""
    with figure_saved_as_png(path, 5.0) as figure:
        panels = figure.subplots(2, len(profiles), squeeze=False, sharex="col")
        artists: list[Artist] = []
        for (above, below), (title, (profile, partner)) in zip(panels.T, profiles.items(), strict=True):
            artists = _deviance(above, profile)
            above.set_title(f"{matplotlib_text(title)}\n{interval_sentence(profile)}")
            artists += below.plot(
                profile.grid,
                profile.paths[partner],
                "o-",
                color=BEFORE,
                ms=3,
                label="the other, refitted at every value",
            )
            _shade(below, profile)
            below.set(
                ylabel=_with_unit(partner, profile.units[partner]),
                xlabel=_with_unit(profile.name, profile.unit),
            )
        panels[0, 0].set_ylabel("deviance n ln(cost / least) [1]")
        figure.align_ylabels()
        legend_above(figure, artists)


def _deviance(axes: Axes, profile: Profile) -> list[Artist]:
    artists: list[Artist] = [_shade(axes, profile)]
    artists += axes.plot(profile.grid, profile.deviance, "o-", color=AFTER, ms=3, label="deviance")
    label = f"95 % limit, {LIMIT:.2f}"
    artists.append(axes.axhline(LIMIT, color=MEASURED, ls="--", lw=1.0, label=label))
    highest = min(float(profile.deviance.max()), HIGHEST * LIMIT)
    axes.set_ylim(-0.05 * HIGHEST * LIMIT, 1.05 * max(highest, 1.5 * LIMIT))
    return artists


def _shade(axes: Axes, profile: Profile) -> Artist:
    """The interval; where it is open, up to the end of the grid."""
    low, high = profile.interval
    ends = (
        profile.grid[0] if low is None else low,
        profile.grid[-1] if high is None else high,
    )
    label = "95 % interval, up to the grid's end where open"
    return axes.axvspan(*ends, color=AFTER, alpha=0.1, lw=0, label=label)


def _with_unit(name: str, unit: str) -> str:
    return f"{matplotlib_text(name)} [{unit}]"


def main() -> None:
    """Print the intervals, and the other parameters along them."""
    without, with_caster = friction_or_length(0.0), friction_or_length(CASTER)
    for e, result in ((0.0, without), (CASTER, with_caster)):
        print(f"e = {1000 * e:g} mm, {result.name}: {interval_sentence(result)}")
        mu = result.paths["mu"]
        print(f"  mu from {mu[0]:.4f} to {mu[-1]:.4f} at {result.grid[0]:g} to {result.grid[-1]:g} of a")
    product = without.paths["mu"] * without.grid
    print(f"  without caster mu a keeps within {np.ptp(product) / product.mean():.2%}")
    result, spread, correlated = bristles_or_carcass()
    k_t = result.paths["carcass_torsion.k_t"]
    print(f"k, {K:g} N/m^2 in truth: {interval_sentence(result)}")
    print(f"  by its deviation: {result.best - 1.96 * spread:.4g} to {result.best + 1.96 * spread:.4g}")
    print(f"  k_t from {k_t[0]:.0f} to {k_t[-1]:.0f} N m/rad along it, {K_T:g} in truth")
    print(f"  correlation of k with the compliance 1/k_t: {correlated:.3f}")
    if sys.argv[1:]:
        columns = {
            "friction or contact length, e = 0": (without, "mu"),
            f"friction or contact length, e = {1000 * CASTER:g} mm": (with_caster, "mu"),
            "bristles or carcass": (result, "carcass_torsion.k_t"),
        }
        draw_profile(Path(sys.argv[1]), columns)


if __name__ == "__main__":
    main()
