"""Effective friction of an observer's estimate, and the output of a step.

The standard deviation follows from that of mu by the delta method; `mu_eff` is linear in mu for every
effect of the library.
"""

from functools import cache
from typing import Any

import casadi as ca

from observers.layout import named, symbols, vector_of
from observers.patch.patch_protocol import PatchModel
from observers.protocol import OUTPUT
from symbolic import GEOMETRY
from symbolic.casadi_functions import named_function


@cache
def build_effective_friction(model: PatchModel) -> ca.Function:
    """(mu, mu_std, memory, F_N, theta, geometry, rate) -> (mu_eff, mu_eff_std, M_slide).

    memory (m,) after the sample, load [N] and parameters as of the model, theta at any mu; rate [rad/s]
    is that of the full slide. See `symbolic.full_slide`.
    """
    inputs = symbols(
        ca.MX, mu=1, mu_std=1, memory=model.memory_size, F_N=1, theta=len(model.coordinates),
        geometry=len(GEOMETRY), rate=1,
    )  # fmt: skip
    mu, mu_std, memory, F_N, theta, geometry, rate = inputs.values()
    at = vector_of(model.coordinates, {**named(model.coordinates, theta), "mu": mu})
    mu_eff, M_slide = model.full_slide.call([memory, F_N, at, geometry, rate], True, False)
    deviation = ca.fabs(ca.jtimes(mu_eff, mu, ca.MX(1))) * mu_std
    outputs = {"mu_eff": mu_eff, "mu_eff_std": deviation, "M_slide": M_slide}
    return named_function("effective_friction", inputs, outputs, cse=True)


def output_vector(**known: Any) -> ca.MX:
    """An output in the order of `OUTPUT`; a status that is not given is 0, all else that is not NaN."""
    vector: ca.MX = vector_of(OUTPUT, dict.fromkeys(OUTPUT, float("nan")) | {"status": 0} | known)
    return vector
