"""The innovation as a torque: what lasts in it, what k explains, and what is a new ground."""

import casadi as ca

from observers.layout import Expression, Parts, named
from observers.measurement.steering_torque_as_input import BLOCK_TIME
from observers.measurement.torque_error import is_known
from observers.quality.acquisition import EquivalentPatch
from observers.quality.hysteresis_branches import torque_slope_by_log_k
from observers.quality.mu_and_scale_from_hypotheses import VERDICT, log_torque_scale_variance
from observers.quality.mu_over_k_hypotheses import NOISIER, SETTINGS, build_torque_error_variance

BEYOND, IN_A_ROW = 2.5, 5
"""Deviations, beyond what k makes, by which a torque computed from the steering torque differs from the
predicted one, and so often in a row, if the ground has changed: the estimator's measurement is the angle
there, which a torque moves little."""
INNOVATION_THRESHOLD, SMOOTHING_TIME = 3.0, 0.1
"""Test of a lasting innovation: threshold in model errors, and time constant of its low-pass [s]. Beyond
it the model is wrong: what depends on time rather than on the angle, a zero that drifts or a torque that
relaxes, is hidden in the noise of a sample and lasts."""
CLEAR, CLEAR_COMPUTED = 0.7, 0.5
"""Lasting innovation, in model errors, that a model that was handed over has to fall below once; of a
torque that is computed from the steering torque, of which there are few by then."""
SPIKE = 12.0
"""Deviations of a torque's error beyond which an innovation counts no more: one sample lasts not."""
NOISE_ALLOWANCE = 3.0
"""Variance of the smoothed noise that is allowed, over its own [1]."""


def innovation_of(inputs: Parts, own: Parts, output: Parts) -> Expression:
    """The measured torque less the predicted one [N m], NaN where it is missing."""
    return inputs["M_z"] - output["M_z_predicted"] * own["scale"]


def torque_variance_from_stiffness(
    inputs: Parts, own: Parts, output: Parts, patch: EquivalentPatch, *, scaled: bool
) -> Expression:
    """Variance of the present branch's torque that k makes, being softer or stiffer [N^2 m^2].

    A torque of the declared model that is divided by s, as `scaled` says, leaves k off by no more than
    s is uncertain; one that is not, by s too. A model that was found keeps its k, of which the tolerance
    counts.
    """
    std = named(SETTINGS, inputs["limits"])["stiffness_std"]
    verdict = named(VERDICT, inputs["verdict"])
    if not scaled:
        std = ca.sqrt(std**2 + verdict["log_gain"] ** 2)
    elif not patch.misfit:
        std = ca.sqrt(log_torque_scale_variance(verdict, std))
    mu = output["mu"] * inputs["friction"]
    by_k = torque_slope_by_log_k(inputs["turn"] / 2, mu, own["load"], inputs["tyre"])
    return (std * by_k) ** 2


def range_of_last_predictions(own: Parts, predicted: Expression) -> tuple[Expression, Expression]:
    """Least and greatest torque that was predicted at the last two that were computed and since [N m].

    A computed torque is of the time between those two.
    """
    before = (own["predicted"], own["predicted_before"])
    return ca.fmin(predicted, ca.fmin(*before)), ca.fmax(predicted, ca.fmax(*before))


def smoothed_innovation_test(
    inputs: Parts, own: Parts, output: Parts, by_k: Expression,
    predictions: tuple[Expression, Expression] | None = None,
) -> tuple[Expression, Expression, Expression]:  # fmt: skip
    """The smoothed innovation, whether it is more than is explained, and whether it is clear.

    It is in N m. Of a torque that is computed, which is known now and then, it is in deviations, and
    those count whose `range_of_last_predictions` is narrower than one.
    """
    known = is_known(inputs["M_z"])
    interval = inputs["interval"] + (predictions is not None) * BLOCK_TIME
    share, clear = (
        ca.fmin(interval / SMOOTHING_TIME, 1),
        CLEAR if predictions is None else CLEAR_COMPUTED,
    )
    slide, error = output["M_slide"] * own["scale"], named(SETTINGS, inputs["limits"])["error"]
    a = inputs["tyre"][1]
    _, variance, noisy = build_torque_error_variance()(
        0, own["F_N"], a, inputs["added"], slide, 1, error
    )
    most, innovation = SPIKE * ca.sqrt(variance + by_k), innovation_of(inputs, own, output)
    if predictions is not None:
        low, high = predictions
        innovation = inputs["M_z"] - (low + high) / 2
        known = ca.logic_and(known, (high - low) ** 2 <= variance + by_k)
    innovation = ca.fmax(-most, ca.fmin(most, ca.if_else(known, innovation, 0)))
    # Of the noise the smoothed innovation has but a part; it is tested often, so that more is allowed.
    noise = noisy * variance / NOISIER
    variance = variance - noise * (1 - NOISE_ALLOWANCE * share / (2 - share)) + by_k
    zero = ca.SX(0)
    if predictions is not None:
        # The zero in the predictions is that of an acquisition, after which it may have been dragged.
        var_zero = named(VERDICT, inputs["verdict"])["var_zero"]
        zero = 4 * (own["again"] > 0) * var_zero / variance
        innovation, variance = innovation / ca.sqrt(variance), ca.SX(1)
    lasting = own["lasting"] + ca.if_else(known, share, 0) * (innovation - own["lasting"])
    square = lasting**2
    return lasting, square > INNOVATION_THRESHOLD**2 * variance, square <= clear**2 * variance + zero


def update_deviation_streak(
    inputs: Parts, own: Parts, predicted: Expression, by_k: Expression, error: Expression
) -> Parts:
    """Torques in a row, up to now, that differ from the predicted one [N m] by more than `BEYOND`."""
    known, (low, high) = is_known(inputs["M_z"]), range_of_last_predictions(own, predicted)
    M_z = ca.if_else(known, inputs["M_z"], predicted)
    away = ca.fmax(ca.fmax(M_z - high, low - M_z), 0)
    reach = ca.fmax(ca.fabs(M_z), ca.fabs(predicted))
    a = inputs["tyre"][1]
    _, variance, _ = build_torque_error_variance()(M_z, own["F_N"], a, inputs["added"], reach, 1, error)
    streak = ca.if_else(away**2 > BEYOND**2 * (variance + by_k), own["streak"] + 1, 0)
    after = {"streak": streak, "predicted": predicted, "predicted_before": own["predicted"]}
    return {name: ca.if_else(known, value, own[name]) for name, value in after.items()}
