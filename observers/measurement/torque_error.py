"""Error of a measured torque, in shares of full slide at mu = 1: the sensor's and the model's.

The sensor's error is absolute: it sets the least friction that a rig can tell. The model's is a share of
the torque that there is, full slide at the present mu: in shares of the signal, the model is no more
wrong on ice than on asphalt.

White noise is estimated from the samples. Means of the torque over blocks of `REFERENCE_STEP` are
compared with their neighbours: of three in a row the second difference has six times the variance of
one, and a smooth torque contributes little to it. What counts is noise by time, so that a sensor that
measures every 10 ms or faster is not taken for less noisy where it is sampled oftener; one that measures
more slowly is. The corners of the torque are rare, and their squares are limited.
"""

from typing import Any

import casadi as ca

from observers.layout import Expression, Parts
from observers.tuning import REFERENCE_STEP

SENSIBLE = 1e9
"""Sensor values of this magnitude and above are invalid, in SI units; 1e20 squared overflows a float."""
SENSOR = 0.005
"""Least white torque noise of a sample, as a share of 3/8 F_N a [1]."""
MIN_TRAVEL = 1e-9
"""Travel that is added to numerator and divisor, against division by zero [rad]."""


def is_known(value: Expression) -> Expression:
    """False for NaN, infinity and `SENSIBLE`; casadi simplifies x == x to true, no other comparison."""
    return ca.fabs(value) < SENSIBLE


def independent_sample_share(travel: Expression, error_travel: Expression) -> Expression:
    """Share of an independent sample of the model's error that a turn [rad] is worth, at most 1."""
    return ca.fmin(1, (travel + MIN_TRAVEL) / (error_travel + MIN_TRAVEL))


def forgetting_factor(share: Expression, memory: float) -> Expression:
    """Weight that older samples keep after a share of an independent one [1]."""
    return 1 - share / memory


def relative_sensor_noise_variance(rig: Parts, tuning: Parts, slide_torque: Expression) -> Expression:
    """Variance of the sensor's white error in 10 ms, divided as in `model_error_variance` [1]."""
    known = is_known(rig["noise"])
    return ca.if_else(
        known, (ca.if_else(known, rig["noise"], 0) / slide_torque) ** 2, tuning["noise"] ** 2
    )


def share_of_full_slide(value: Expression, slide_torque: Expression, default: Expression) -> Expression:
    """A value of the rig over full slide at mu = 1 [1], or another share where it is unknown."""
    known = is_known(value)
    return ca.if_else(known, ca.if_else(known, value, 0) / slide_torque, default)


def declared_sensor_variance(rig: Parts) -> Expression:
    """Variance of the sensor's noise that the rig declares, 0 where it declares none [N^2 m^2]."""
    return ca.if_else(is_known(rig["noise"]), rig["noise"] ** 2, 0)


def model_error_variance(x: Parts, tuning: Parts) -> Expression:
    """Variance of the model's torque error, divided by the full-slide torque at mu = 1 squared [1].

    It is 0 where the tuning states no model error. The error is a share of full slide at the present mu.
    """
    return ca.if_else(has_stated_model_error(tuning), model_error_std(x, tuning) ** 2, 0)


def has_stated_model_error(tuning: Parts) -> Expression:
    """Whether the tuning states an error of the model beside the noise."""
    return ca.logic_and(tuning["error_travel"] > 0, tuning["error"] < SENSIBLE)


def model_error_std(x: Parts, tuning: Parts) -> Expression:
    """Deviation of the model's torque error at the present mu, divided by full slide at mu = 1 [1].

    An infinite one is set to 0, so that derivatives stay finite.
    """
    finite = ca.if_else(tuning["error"] < SENSIBLE, tuning["error"], 0)
    return finite * ca.exp(x["log_mu"])


def huber_scale_squared(x: Parts, tuning: Parts, noise: Expression) -> Expression:
    """Square of the error up to which Huber's loss is quadratic, in full slides at mu = 1 [1]."""
    stated = tuning["error"] < SENSIBLE
    return ca.if_else(stated, model_error_std(x, tuning) ** 2 + noise, ca.inf)


NOISE = ("waited", "time", "sum", "newer", "older", "variance", "blocks")
"""Time since the last torque [s]; time of the present block [s], and integral of its torque [N m s];
means of the last two blocks [N m]; variance of a block [N^2 m^2]; blocks so far."""
MAX_BLOCKS = 100.0
"""Blocks over which the variance is averaged."""
MAX_SQUARE = 9.0
"""Square of a second difference that counts at most, over its variance."""
JITTER = 0.99
"""Share of `REFERENCE_STEP` that fills a block [1]."""


def update_sensor_noise_estimate(
    before: Parts, M_z: Expression, dt: Expression, initial_variance: Expression,
    min_variance: Expression,
) -> Parts:  # fmt: skip
    """The numbers of `NOISE` after a torque [N m], NaN where it is missing, of so long a step [s].

    initial_variance is that of a block before one was seen, min_variance that of a sensor without noise,
    about which the squares are limited [N^2 m^2].
    """
    known, interval = is_known(M_z), before["waited"] + dt
    time = before["time"] + interval
    total = before["sum"] + ca.if_else(known, M_z, 0) * interval
    mean = total / time
    closes = ca.logic_and(known, time >= JITTER * REFERENCE_STEP)
    variance = ca.if_else(
        before["blocks"] > 0, before["variance"], ca.fmax(before["variance"], initial_variance)
    )
    most = MAX_SQUARE * ca.fmax(variance, min_variance)
    # A block may be longer than `REFERENCE_STEP`, of which the variance is counted.
    length = time / ca.fmax(REFERENCE_STEP, interval)
    square = ca.fmin(length * (mean - 2 * before["newer"] + before["older"]) ** 2 / 6, most)
    # The initial variance weighs as one block.
    seen = ca.fmax(before["blocks"], 1)
    grown = variance + ca.if_else(before["blocks"] >= 2, (square - variance) / seen, 0)
    closed = {
        "waited": 0, "time": 0, "sum": 0, "newer": mean, "older": before["newer"], "variance": grown,
        "blocks": ca.fmin(before["blocks"] + 1, MAX_BLOCKS),
    }  # fmt: skip
    present = {**before, "waited": 0, "time": time, "sum": total, "variance": variance}
    missing = {**before, "waited": interval}
    after: dict[str, Any] = {
        name: ca.if_else(closes, closed[name], ca.if_else(known, present[name], missing[name]))
        for name in NOISE
    }
    return after
