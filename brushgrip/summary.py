"""What an observer made of a recording, on one line."""

import numpy as np

from observers import Estimates, Status


def summary(made: Estimates) -> str:
    """Friction at the end, what was not believed, and what to do about the most frequent fault."""
    counts = {flag: int(np.count_nonzero(made.status & flag)) for flag in Status if flag}
    parts = [_end(made)]
    if rejected := counts[Status.REJECTED]:
        parts.append(f"{rejected} {_plural(rejected, 'sample')} rejected")
    if changes := counts[Status.RESET]:
        parts.append(f"{changes} {_plural(changes, 'change')} of the ground")
    line = ", ".join(parts)
    worst = max(counts, key=lambda flag: counts[flag])
    often = counts[worst]
    return f"{line}; {often} {_plural(often, 'sample')}: {worst.remedy}" if often else line


def _end(made: Estimates) -> str:
    mu, std = made.mu[-1], made.mu_std[-1]
    spread = f" ± {std:.3f}" if np.isfinite(std) else ""
    share = f"informed in {100 * made.informed.mean():.0f} % of {made.t.size} samples"
    return f"mu = {mu:.3f}{spread} at the end, {share}"


def _plural(count: int, noun: str) -> str:
    return noun if count == 1 else f"{noun}s"
