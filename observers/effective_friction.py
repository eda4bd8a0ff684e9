"""Effective friction of an observer's estimate, and the output of a step.

The standard deviation follows from that of mu by the delta method; `mu_eff` is linear in mu for every
effect of the library.
"""

from functools import cache
from typing import Any

import casadi as ca

from observers.patch_model import PatchModel
from observers.protocol import OUTPUT
from symbolic import GEOMETRY


@cache
def build_effective_friction(model: PatchModel) -> ca.Function:
    """(mu, mu_std, memory, F_N, theta, geometry, rate) -> (mu_eff, mu_eff_std, M_slide).

    memory (m,) after the sample, load [N] and parameters as of the model, theta at any mu; rate [rad/s]
    is that of the full slide. See `symbolic.full_slide`.
    """
    names = ("mu", "mu_std", "memory", "F_N", "theta", "geometry", "rate")
    sizes = {"memory": model.memory_size, "theta": len(model.coordinates), "geometry": len(GEOMETRY)}
    mu, mu_std, memory, F_N, theta, geometry, rate = inputs = [
        ca.MX.sym(name, sizes.get(name, 1)) for name in names
    ]
    rows = dict(zip(model.coordinates, ca.vertsplit(theta), strict=True)) | {"mu": mu}
    slide = [memory, F_N, ca.vertcat(*rows.values()), geometry, rate]
    mu_eff, M_slide = model.full_slide.call(slide, True, False)
    deviation = ca.fabs(ca.jtimes(mu_eff, mu, ca.MX(1))) * mu_std
    return ca.Function(
        "effective_friction",
        inputs,
        [mu_eff, deviation, M_slide],
        list(names),
        ["mu_eff", "mu_eff_std", "M_slide"],
        {"cse": True},
    )


def output_vector(**known: Any) -> ca.MX:
    """An output in the order of `OUTPUT`; a status that is not given is 0, all else that is not NaN."""
    missing = {"status": 0}
    vector: ca.MX = ca.vertcat(*(known.get(name, missing.get(name, float("nan"))) for name in OUTPUT))
    return vector
