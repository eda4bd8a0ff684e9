"""Newton's method for the programme of free vibrations, at ever narrower noise.

A wide noise makes an objective without local minima. Where the encoder's step is all the error there is,
only a scale near zero leaves the estimate unbiased: a wider one expects readings to flicker close to the
borders of their cells, and they do not. So the scale goes from what the first guess needs to the one
under which the readings are likeliest.
"""

from dataclasses import dataclass

from identification.arrow import Split
from identification.programme import Look, Programme

_NARROWING, _SAME = 3.0, 0.02
"""Largest factor of the scale from stage to stage, and the relative change at which it is found."""
_MOST_STAGES, _MOST_STEPS, _MOST_HALVINGS = 20, 40, 25
_DECREMENT = 1e-4
"""Squared length of a step in standard deviations at which a stage ends."""
_GAIN = 0.01
"""Share of the gain that the slope promises with which a step is content."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Solution:
    """Where the programme ended.

    Attributes:
        x: unknowns in units of the programme's scales.
        noise: scale of the noise besides the encoder's step [rad].
        look: the programme there.
        converged: whether scale and unknowns both ended by their tolerances.
        steps: Newton steps in all.
    """

    x: Split
    noise: float
    look: Look
    converged: bool
    steps: int


def solve(programme: Programme) -> Solution:
    """The unknowns under which the readings are likeliest."""
    x, steps = programme.start(), 0
    noise = programme.likeliest_noise(programme.look(x, 1.0).swings)
    for _ in range(_MOST_STAGES):
        x, look, ended, taken = _stage(programme, x, noise)
        steps += taken
        likeliest = max(programme.likeliest_noise(look.swings), noise / _NARROWING)
        if abs(likeliest - noise) < _SAME * noise:
            return Solution(x=x, noise=noise, look=look, converged=ended, steps=steps)
        noise = likeliest
    return Solution(x=x, noise=noise, look=look, converged=False, steps=steps)


def _stage(programme: Programme, x: Split, noise: float) -> tuple[Split, Look, bool, int]:
    """Newton's method with halved steps: point, programme there, whether it converged, steps."""
    look = programme.look(x, noise)
    for taken in range(_MOST_STEPS):
        move = look.hessian.damped(1e-12).solve(look.gradient) * -1.0
        decrement = -look.gradient.dot(move)
        if decrement < _DECREMENT:
            return x, look, True, taken
        for halving in range(_MOST_HALVINGS):
            share = 0.5**halving
            tried = programme.look(x + move * share, noise)
            # Where the wheel would not vibrate the objective is NaN, which is no gain either.
            if tried.cost < look.cost - _GAIN * share * decrement:
                break
        else:
            return x, look, False, taken
        x, look = x + move * share, tried
    return x, look, False, _MOST_STEPS
