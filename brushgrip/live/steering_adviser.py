"""Where to turn so that friction is known soon: a `Probe` that follows in a thread of its own."""

import threading
from collections import deque
from math import degrees
from typing import Any

from observers import Advice, Estimate, Observer, Probe, Sample, Status, SteeringLimits
from observers.estimators.model_observer import ModelObserver
from symbolic import InvalidInputError

PLANNING = "where to turn is being planned"
STOP = "stop turning"
"""Stands in every advice to do so."""
MAX_PLAN_SAMPLES = 2_000
"""Samples that a plan may take; where it takes longer, it begins anew."""


class SteeringAdviser:
    """A thread that plans, for which samples need not wait; `text` says what to do now."""

    def __init__(self, target: float, limits: SteeringLimits) -> None:
        """Until friction is known to a share, within what the wheel may do."""
        self._target, self._limits = target, limits
        self._waiting: deque[tuple[Sample, Any, bool]] = deque(maxlen=MAX_PLAN_SAMPLES)
        self._arrived, self._generation, self._text = threading.Event(), 0, ""
        # Whether the target is reached, and whether the plan has judged a sample where it is.
        self._reached = self._judged = False

    @property
    def text(self) -> str:
        """What to do now, or why nothing can be said; empty at a turning point.

        Where the target is reached, the old plan counts no more before the new one knows of it.
        """
        if self._reached and not self._judged:
            return target_reached_text(self._target)
        return self._text

    def begin(self, observer: Observer) -> None:
        """Advise on an observer from its next sample on, as long as no other one begins."""
        self._generation += 1
        self._waiting, self._text = deque(maxlen=MAX_PLAN_SAMPLES), PLANNING
        self._reached = self._judged = False
        arguments = (observer, self._generation, self._waiting)
        threading.Thread(
            target=self._plan_in_thread, args=arguments, name="live-advise", daemon=True
        ).start()

    def __call__(self, sample: Sample, state: Any, estimate: Estimate) -> None:
        """Tell of a sample, and of the observer's state and estimate after it."""
        known = estimate.usable and estimate.mu_std <= self._target * estimate.mu
        self._reached = known or (self._reached and not _is_friction_lost(estimate))
        self._waiting.append((sample, state, self._reached))
        self._arrived.set()

    def _plan_in_thread(
        self, observer: Observer, own: int, waiting: deque[tuple[Sample, Any, bool]]
    ) -> None:
        try:
            if not isinstance(observer, ModelObserver):
                raise InvalidInputError("--target is for ekf and mhe, whose deviation it can forecast")
            probe = Probe(observer, self._target, self._limits)
            while own == self._generation:
                if not waiting:
                    self._arrived.wait(0.1)
                    self._arrived.clear()
                elif len(waiting) == MAX_PLAN_SAMPLES:
                    waiting.clear()
                    probe.reset()
                else:
                    sample, state, is_reached = waiting.popleft()
                    advice = probe(sample, state)
                    if advice.finished and _is_friction_lost(observer.estimate(state)):
                        probe.restart_advice()
                        advice = probe(sample, state)
                    newest = waiting[-1][0] if waiting else sample
                    if own == self._generation:
                        self._text = advice_text(advice, newest.psi, self._target)
                        self._judged = is_reached
        except Exception as error:
            self._text = f"no advice: {error}"
            if not isinstance(error, InvalidInputError):
                raise


LOST = Status.RESET | Status.ACQUIRING | Status.INCONSISTENT | Status.SUSPECT
"""Flags of friction that is known no more; what a sample lacks, or a spike, takes nothing away."""


def _is_friction_lost(estimate: Estimate) -> bool:
    """Whether friction that was known is so no more."""
    return not estimate.usable and bool(estimate.status & LOST)


def target_reached_text(target_deviation: float) -> str:
    """That the deviation over friction that was wanted is reached."""
    return f"friction is known to {target_deviation:.1%}, {STOP}"


def advice_text(advice: Advice, psi: float, target_deviation: float) -> str:
    """An advice in a sentence, by the angle now [rad] and the deviation over friction wanted [1]."""
    if advice.finished:
        return target_reached_text(target_deviation)
    if advice.stopped:
        return f"{STOP}: {advice.reason}"
    left = degrees(advice.toward - psi)
    size = f"{abs(left):.{0 if abs(left) >= 1 else 1}f}"
    return "" if size == "0.0" else f"turn {size}° more to the {'left' if left > 0 else 'right'}"
