"""k from the recordings of one contact at a time, and whether the contacts agree.

A wrong a or e moves the stiffness (5.7) of a long contact otherwise than that of a short one, and a
wrong J_A of some contacts moves theirs alone. Every recording may then be met well and every interval be
narrow, and k is off by percents all the same; but the contacts, each for itself, tell different k.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import f as fishers_f

from identification.free_decay.jackknife import spread_of
from identification.free_decay.likelihood import Contact, Programme, contact_of
from identification.free_decay.noise_continuation import solve

_CHANCE = 1e-3
"""How often contacts that agree are said not to."""


@dataclass(frozen=True, kw_only=True)
class Alone:
    """k as the recordings of one contact tell it.

    Attributes:
        contact: a and e [m].
        k: distributed lateral stiffness [N/m^2].
        std: its standard deviation.
        freedom: degrees of freedom of that.
    """

    contact: Contact
    k: float
    std: float
    freedom: int


def each_alone(programme: Programme) -> tuple[Alone, ...]:
    """The k of every contact that tells it for itself; nothing where there is but one contact."""
    if len(programme.contacts) < 2:
        return ()
    made = (_alone(programme, contact) for contact in programme.contacts)
    return tuple(alone for alone in made if alone is not None)


def agree(alone: Sequence[Alone]) -> bool | None:
    """Whether values of k are apart by no more than they may by chance; None for less than two."""
    if len(alone) < 2:
        return None
    k, std = np.array([one.k for one in alone]), np.array([one.std for one in alone])
    mean = np.average(k, weights=std**-2)
    scatter = float((((k - mean) / std) ** 2).sum()) / (k.size - 1)
    # The variances are estimates themselves; the least certain one stands for all.
    freedom = min(one.freedom for one in alone)
    return bool(fishers_f.sf(scatter, k.size - 1, freedom) > _CHANCE)


def _alone(programme: Programme, contact: Contact) -> Alone | None:
    part = Programme([r for r in programme.releases if contact_of(r) == contact])
    try:
        solution = solve(part)
        spread = spread_of(part, solution)
    except np.linalg.LinAlgError:
        return None
    if not solution.converged:
        return None
    k, std = np.array([solution.x[0], np.sqrt(spread.covariance[0, 0])]) * part.scales[0]
    return Alone(contact=contact, k=float(k), std=float(std), freedom=spread.freedom)
