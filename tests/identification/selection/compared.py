"""Two models made up such that each figure by which they are compared is known beforehand."""

from dataclasses import replace

import numpy as np

from identification import Recording
from identification.fits.autocorrelation import effective_samples
from identification.selection.criteria import DEFAULT_CRITERIA, ComparisonBasis, SelectionCriteria
from identification.selection.trial import Judgement, Trial
from symbolic import Effect, Parameter

SECONDS, PER_SECOND = 80, 50
Pair = tuple[Trial, list[Recording]]
"""A trial, and the recordings that it was fitted to and judged by."""


def compared_by(pair: Pair, criteria: SelectionCriteria = DEFAULT_CRITERIA) -> ComparisonBasis:
    """What models are compared by that were fitted to the first recording."""
    return ComparisonBasis(pair[1][:1], criteria, pair[0])


class Law(Effect):
    """A law of friction over speed."""

    family = "friction over speed"


class FlexibleLaw(Law):
    """One that stands for all others of them."""

    flexible = True


def effect_of(name: str) -> Effect:
    """An effect by its letter: s and t are laws of one family, f is its flexible one.

    z is of the same family and has values of each recording alone.
    """
    kind = {"s": Law, "t": Law, "z": Law, "f": FlexibleLaw}.get(name, Effect)
    own = Parameter(name="zero", unit="1", neutral=0.0, start=0.1, lower=-1.0, upper=1.0, scale=0.1,
                    scope="recording")  # fmt: skip
    return kind(name=name, summary=name, parameters=(own,) if name == "z" else ())


def with_effects(trial: Trial, names: str) -> Trial:
    """The trial as if its effects were these letters."""
    model = replace(trial.fitted.model, effects=tuple(effect_of(name) for name in names))
    return replace(trial, fitted=replace(trial.fitted, model=model))


def judgement(sizes: np.ndarray) -> Judgement:
    """A held-out error of that size in each second, range 1."""
    t = np.arange(SECONDS * PER_SECOND) / PER_SECOND
    alternating = np.where(np.arange(t.size) % 2, 1.0, -1.0)
    residuals = {"a": alternating * np.repeat(sizes, PER_SECOND)}
    return Judgement(residuals=residuals, ranges={"a": 1.0}, times={"a": t})


def trials(
    pair: Pair, bic: float, error: float, block: float = DEFAULT_CRITERIA.block
) -> tuple[Trial, Trial]:
    """A model with one more parameter, and one without.

    With it the information criterion rises by `bic`, and the held-out mean square falls by `error` times
    its standard error, from blocks of so many seconds.
    """
    trial, (training, _) = pair
    white = np.random.default_rng(3).standard_normal(training.t.size)
    n = effective_samples({training.name: white})
    ratio = np.exp((np.log(n) - bic) / (2 * n))
    with_more = (*trial.fitted.labels, (None, "more"))
    before = replace(trial.fitted, residuals={training.name: ratio * white})
    after = replace(trial.fitted, residuals={training.name: white}, labels=with_more)
    blocks = SECONDS // int(block)
    gains = np.repeat(np.where(np.arange(blocks) % 2, 1.0, -1.0), int(block))
    gains = 0.2 * (1 + gains * np.sqrt(blocks - 1) / error)
    held = {"before": np.ones(SECONDS) * 4, "after": 4 - gains}
    judged = {name: judgement(0.05 * np.sqrt(squares)) for name, squares in held.items()}
    return (
        replace(trial, fitted=after, judgement=judged["after"]),
        replace(trial, fitted=before, judgement=judged["before"]),
    )
