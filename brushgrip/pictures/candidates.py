"""Every candidate effect alone on top of the declared structure, ranked."""

from pathlib import Path

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from brushgrip.formatting import fate, plain
from brushgrip.pictures.style import AFTER, BEFORE, QUIET, legend_above, picture
from identification.results import Candidate, Diagnosis

_ALIKE = "#9cc3e0"


def draw_candidates(path: Path, diagnosis: Diagnosis) -> None:
    """Horizontal bars of the judged error, best on top, with error and evidence as figures."""
    candidates = diagnosis.candidates
    with picture(path, 1.3 + 0.26 * max(1, len(candidates))) as figure:
        axes = figure.add_subplot()
        errors = [100 * candidate.holdout_nrmse for candidate in candidates]
        colours = [_colour(diagnosis, candidate) for candidate in candidates]
        axes.barh(range(len(candidates)), errors, color=colours, height=0.7)
        axes.set_yticks(range(len(candidates)), [plain(c.name) for c in candidates])
        axes.invert_yaxis()
        axes.grid(visible=False, axis="y")
        baseline = _baseline(diagnosis)
        _limit(axes, errors, baseline)
        _figures(axes, candidates)
        judged = "held-out" if diagnosis.holdout else "left-out"
        axes.set_xlabel(f"{judged} torque error with this effect alone [% of range]")
        legend_above(figure, _key(axes, diagnosis, baseline))


def _baseline(diagnosis: Diagnosis) -> float | None:
    """Held-out error without any effect [% of range]; None where nothing is held out."""
    share = diagnosis.before.summary()["holdout_torque_nrmse"]
    return None if share is None else 100 * share


def _colour(diagnosis: Diagnosis, candidate: Candidate) -> str:
    outcome = fate(diagnosis, candidate.name)
    return AFTER if outcome.startswith("added") else _ALIKE if outcome else QUIET


def _limit(axes: Axes, errors: list[float], baseline: float | None) -> None:
    """Bars begin at 0; a hopeless candidate may run off to the right, its figure is given."""
    usual = max(sorted(errors)[: max(1, len(errors) // 2)], default=1.0)
    longest = max([*errors, baseline or 0.0, 1e-9])
    axes.set_xlim(0, 1.04 * min(longest, 2.5 * max(usual, baseline or 0.0, 1e-9)))


def _figures(axes: Axes, candidates: tuple[Candidate, ...]) -> None:
    beside = axes.get_yaxis_transform()
    rows = [("error", "ΔBIC", -1.0)] + [
        (f"{100 * c.holdout_nrmse:.2f} %", f"{c.delta_bic:+.0f}".replace("-", "−"), float(row))
        for row, c in enumerate(candidates)
    ]
    for error, evidence, row in rows:
        for place, text in ((1.08, error), (1.17, evidence)):
            axes.text(place, row, text, transform=beside, ha="right", va="center", fontsize=8)


def _key(axes: Axes, diagnosis: Diagnosis, baseline: float | None) -> list[Artist]:
    key: list[Artist] = []
    if diagnosis.effects:
        key.append(Patch(color=AFTER, label="added to the model"))
    if any(effect.indistinguishable_from for effect in diagnosis.effects):
        key.append(Patch(color=_ALIKE, label="these recordings cannot tell it from an added one"))
    key.append(Patch(color=QUIET, label="not added"))
    if baseline is not None:
        label = f"no effect: {baseline:.2f} %"
        key.append(axes.axvline(baseline, color=BEFORE, lw=1.4, label=label))
    return key
