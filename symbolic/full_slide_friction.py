"""Full slide: the torque of a steady turn in which every bristle slides, and the effective friction.

The effective friction mu_eff is that torque over the torque of the declared patch with mu = 1 under the
same load, [Györök 2022], (2.1) in (2.3). It is mu for the declared model. Models with effects state
their mu at different speeds, loads and travels, so that their mu do not compare; their mu_eff does.

Steady means: turned at one rate for so long that creep, relaxation and Stribeck's law have the values of
that rate, that a sensor's delay no longer matters, and that a compliant carcass turns along. What an
effect counts up, such as the travel of `friction_drift`, stays as it is now.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache

import casadi as ca

from symbolic.effects.base import Effect, ModelProtocol, Values
from symbolic.named_and_buffered_functions import named_function
from symbolic.patch_interface import Expression, PatchInputs, Signals, patch_inputs
from symbolic.patch_moment_by_zones import full_slide_arm


@cache
def build_full_slide(
    model: ModelProtocol, of_patch: Callable[[PatchInputs], Expression] | None = None
) -> ca.Function:
    """(memory, F_N, theta, geometry, rate) -> (mu_eff, M_slide) of a model.

    M_slide [N m] is half the difference of the torques of the ground in steady full slides to either
    side: offsets and return torques cancel, and friction that differs by direction gives its mean. Of
    the torques beside the patch those count that are the ground's, see `Effect.torque_by_ground`.
    mu_eff [1] is M_slide over that of the declared patch with mu = 1 under the load F_N [N]; rate
    [rad/s] is that of the turn, greater than 0. of_patch gives mu_eff of the patch alone, None is for
    the model's patch.
    """
    memory, rate, F_N = ca.MX.sym("memory", model.memory_size), ca.MX.sym("rate"), ca.MX.sym("F_N")
    _, theta, geometry = model.input_symbols()
    angle, _, own = model.split_angle_patch_effects(memory)
    effects = model.values_by_effect(theta)
    # No steady torque depends on the time step.
    forth = Signals(psi=angle, psi_dot=rate, F_N=F_N, dt=1)
    sides = (forth, replace(forth, psi_dot=-rate))
    factors, torques = zip(
        *(effect_factor_and_torque(effects, own, side) for side in sides), strict=True
    )
    # The patch itself slides alike to both sides, and in proportion to the factor on its limit.
    inputs = patch_inputs(forth, (factors[0] + factors[1]) / 2, theta, geometry)
    declared = F_N * full_slide_arm(inputs.a, inputs.e)
    beside = (torques[1] - torques[0]) / (2 * declared)
    mu_eff = (of_patch or model.patch(theta).effective_friction)(inputs) + beside
    given = {"memory": memory, "F_N": F_N, "theta": theta, "geometry": geometry, "rate": rate}
    outputs = {"mu_eff": mu_eff, "M_slide": mu_eff * declared}
    return named_function("full_slide", given, outputs, cse=True)


def effect_factor_and_torque(
    effects: Sequence[tuple[Effect, Values]], own: list[Expression], side: Signals
) -> tuple[Expression, Expression]:
    """Factor on the limit [1], and torque of the ground beside the patch [N m], of all effects."""
    factor, torque = ca.MX(1), ca.MX(0)
    for (effect, values), memory in zip(effects, own, strict=True):
        factor = factor * effect.friction(side, memory, values)
        if effect.torque_by_ground:
            torque = torque + effect.torque(side, values)
    return factor, torque
