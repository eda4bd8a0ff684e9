"""The programme of free vibrations solved at ever narrower noise.

A wide noise makes an objective without local minima. Where the encoder's step is all the error there is,
only a scale near zero leaves the estimate unbiased: a wider one expects readings to flicker close to the
borders of their cells, and they do not. So the scale goes from what the first guess needs to the one
under which the readings are likeliest.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from identification.free_decay.likelihood import Look, Programme

Array = NDArray[np.float64]

_NARROWING, _SAME = 3.0, 0.02
"""Largest factor of the scale from stage to stage, and the relative change at which it is found."""
_MOST_STAGES, _MOST_STEPS = 20, 40
_SLOPE = 0.01
"""Length of the gradient at which a stage ends, in the units of `_units`."""
_RADIUS, _LARGEST_RADIUS = 1e3, 1e9
"""Radius of the region of trust to begin with and at most, in these units."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Solution:
    """Where the programme ended.

    Attributes:
        x: unknowns in units of the programme's scales.
        noise: scale of the noise besides the encoder's step [rad].
        look: the programme there.
        converged: whether scale and unknowns both ended by their tolerances.
        steps: steps of the solver in all.
    """

    x: Array
    noise: float
    look: Look
    converged: bool
    steps: int


def solve(programme: Programme) -> Solution:
    """The unknowns under which the readings are likeliest.

    Raises:
        numpy.linalg.LinAlgError: something unknown does not show in the readings at all.
    """
    x, steps = programme.start(), 0
    first = programme.look(x, 1.0)
    _units(first)
    noise = programme.likeliest_noise(first.swings)
    for _ in range(_MOST_STAGES):
        stage = _stage(programme, x, noise)
        x, steps = stage.x, steps + stage.steps
        likeliest = max(programme.likeliest_noise(stage.look.swings), noise / _NARROWING)
        found = abs(likeliest - noise) < _SAME * noise
        if found:
            break
        noise = likeliest
    return Solution(
        x=x, noise=stage.noise, look=stage.look, converged=found and stage.converged, steps=steps
    )


def _stage(programme: Programme, x: Array, noise: float) -> Solution:
    """The minimum for one scale of the noise, by a trust region."""
    unit = _units(programme.look(x, noise))

    @lru_cache(maxsize=2)
    def look(point: bytes) -> Look:
        return programme.look(x + unit * np.frombuffer(point), noise)

    ended = minimize(
        lambda z: look(z.tobytes()).cost,
        np.zeros(x.size),
        jac=lambda z: unit * look(z.tobytes()).gradient,
        hess=lambda z: np.outer(unit, unit) * look(z.tobytes()).hessian,
        method="trust-exact",
        options={
            "gtol": _SLOPE,
            "maxiter": _MOST_STEPS,
            "initial_trust_radius": _RADIUS,
            "max_trust_radius": _LARGEST_RADIUS,
        },
    )
    return Solution(
        x=x + unit * ended.x,
        noise=noise,
        look=look(ended.x.tobytes()),
        converged=bool(ended.success),
        steps=int(ended.nit),
    )


def _units(look: Look) -> Array:
    """What each unknown's standard deviation would be if all others were known."""
    information = np.diag(look.hessian)
    if not (information > 0).all():
        raise np.linalg.LinAlgError("the readings do not depend on one of the unknowns")
    units: Array = 1 / np.sqrt(information)
    return units
