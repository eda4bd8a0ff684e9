"""A thin stateful wrapper for control loops, which also puts late measurements into their place."""

from collections import deque
from dataclasses import dataclass, replace
from functools import cache
from math import isfinite, nan
from numbers import Integral
from typing import Any

import numpy as np

from observers.compiled_step import CompiledStep
from observers.measurement.causal_yaw_rate import next_rate
from observers.protocol import Estimate, Observer, Sample, Status, prior_estimate
from observers.quality.sample_screening import (
    SCREEN,
    beyond_limits,
    build_input_screen,
    initial_screen_state,
    is_plausible_first_sample,
    sample_limits_of,
)
from observers.quality.wrong_units_or_signs import suspicions_from_state
from observers.tuning import NO_LIMIT, require_positive_ints
from symbolic import InvalidInputError

AT_PSI, AT_AGE = (SCREEN.places[name][0].start for name in ("psi", "age"))


@cache
def _compiled_input_screen(limits: tuple[float, ...]) -> CompiledStep:
    """The check of samples, whose buffers are not pickled with a loop."""
    return CompiledStep(build_input_screen(), np.array(limits))


@dataclass(frozen=True, slots=True)
class _LoopState:
    state: Any = None  # That of the observer, None before the start.
    psi: float = nan  # The last angle [rad].
    age: float = 0.0  # Of that angle [s].
    psi_dot: float = 0.0  # The last rate [rad/s].
    screen: Any = None  # That of the check of samples, None before the start.
    too_fast: bool = False  # Whether a rate was measured beyond its limit.


class Loop:
    """An observer that keeps its state: `loop(sample)` is the estimate after the sample.

    It starts at the first sample with a sensible psi and F_N >= 0.001 N, which says where the patch
    stands at rest. A yaw rate that a sample lacks, NaN, is taken from the past of the angle as in
    `observers.run`.
    Implausible values are left out, see `observers.quality.sample_screening`.

    Attributes:
        observer: the observer.
        history: samples that a late measurement may reach back, the newest included.

    Raises:
        InvalidInputError: history is no whole number of at least 1.
    """

    def __init__(self, observer: Observer, history: int = 50) -> None:
        """Begin without a sample."""
        require_positive_ints(history=history)
        self.observer = observer
        self.history = history
        self._limits = sample_limits_of(observer)
        self.reset()

    def reset(self) -> None:
        """Forget all samples; the next usable one starts anew."""
        self._present = _LoopState()
        # Each sample with the state before it.
        self._past: deque[tuple[_LoopState, Sample]] = deque(maxlen=self.history)

    @property
    def suspicions(self) -> tuple[str, ...]:
        """Causes of `Status.SUSPECT`, or of a scale for which friction is not acquired; else empty."""
        return suspicions_from_state(self.state, self.observer.channel)

    @property
    def state(self) -> Any:
        """The observer's state after the newest sample, None before the start."""
        return self._present.state

    def __call__(self, sample: Sample) -> Estimate:
        """The estimate after one more sample; before the start the prior, `Status.MISSING`."""
        self._past.append((self._present, sample))
        self._present = self._after(self._present, sample)
        return self._estimate(sample)

    def late(
        self, age: int, *, M_z: float | None = None, M: float | None = None, psi: float | None = None
    ) -> Estimate:
        """Put a measurement that arrived late into its place, and replay from there.

        The result is the same as if it had been there in time. NaN takes a measurement back.

        Args:
            age: how many samples back it belongs, 0 for the newest.
            M_z: aligning torque [N m]; None leaves the sample's own, as for the others.
            M: steering torque [N m].
            psi: yaw angle [rad].

        Returns:
            The estimate after the newest sample.

        Raises:
            InvalidInputError: nothing is given, or age lies beyond the samples that are kept.
        """
        given = {name: v for name, v in (("M_z", M_z), ("M", M), ("psi", psi)) if v is not None}
        if not given:
            raise InvalidInputError("a late measurement needs one of M_z, M, psi, got none")
        if not self._past:
            raise InvalidInputError("no sample is kept yet that a late measurement could belong to")
        if not (isinstance(age, Integral) and 0 <= age < len(self._past)):
            raise InvalidInputError(
                f"age must be a whole number from 0 to {len(self._past) - 1}, as {len(self._past)}"
                f" samples are kept (history = {self.history}), got {age}"
            )
        at = len(self._past) - 1 - age
        state, sample = self._past[at]
        samples = [replace(sample, **given), *(later for _, later in list(self._past)[at + 1 :])]
        for place, sample in enumerate(samples, start=at):
            self._past[place] = (state, sample)
            state = self._after(state, sample)
        self._present = state
        return self._estimate(samples[-1])

    def _after(self, before: _LoopState, sample: Sample) -> _LoopState:
        psi, rate, age, state = before.psi, before.psi_dot, before.age + sample.dt, before.state
        psi_limit, rate_limit, *_ = self._limits
        starts = state is None and is_plausible_first_sample(self.observer, sample.psi, sample.F_N)
        screen = initial_screen_state(sample.psi) if starts else before.screen
        passed = sample.psi if abs(sample.psi) < psi_limit else nan
        if screen is not None:
            screen = _compiled_input_screen(self._limits)(screen, sample)
            passed = screen[AT_PSI] if screen[AT_AGE] == 0 else nan
        if isfinite(passed):
            turn = passed - psi if isfinite(psi) else 0.0
            psi, rate, age = passed, next_rate(rate, turn, age), 0.0
        too_fast = rate_limit <= abs(sample.psi_dot) < NO_LIMIT
        if not abs(sample.psi_dot) < rate_limit:
            sample = replace(sample, psi_dot=rate)
        if starts:
            state = self.observer.init(sample)
        state = None if state is None else self.observer.step(state, sample)
        return _LoopState(state, psi, age, rate, screen, too_fast)

    def _estimate(self, sample: Sample) -> Estimate:
        """The present estimate; the newest sample only lends its dt to the prior."""
        if self.state is None:
            prior = prior_estimate(self.observer, sample.dt)
            beyond = beyond_limits(np.array([sample.numbers]).T, self._limits)[0]
            return replace(prior, status=prior.status | (Status.IMPLAUSIBLE if beyond else 0))
        estimate = self.observer.estimate(self.state)
        if self._present.too_fast:
            estimate = replace(estimate, status=estimate.status | Status.IMPLAUSIBLE)
        return estimate
