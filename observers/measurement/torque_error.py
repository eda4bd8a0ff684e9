"""Error of a measured torque, in shares of full slide at mu = 1: the sensor's and the model's.

The sensor's error is absolute: it sets the least friction that a rig can tell. The model's is a share of
the torque that there is, full slide at the present mu: in shares of the signal, the model is no more
wrong on ice than on asphalt.
"""

import casadi as ca

from observers.layout import Expression, Parts

SENSIBLE = 1e9
"""Sensor values of this magnitude and above are invalid, in SI units; 1e20 squared overflows a float."""
SENSOR = 0.005
"""Least white torque noise of a sample, as a share of 3/8 F_N a [1]."""
MIN_TRAVEL = 1e-9
"""Travel that is added to numerator and divisor, against division by zero [rad]."""


def is_known(value: Expression) -> Expression:
    """False for NaN, infinity and `SENSIBLE`; casadi simplifies x == x to true, no other comparison."""
    return ca.fabs(value) < SENSIBLE


def independent_share(travel: Expression, error_travel: Expression) -> Expression:
    """Share of an independent sample of the model's error that a turn [rad] is worth, at most 1."""
    return ca.fmin(1, (travel + MIN_TRAVEL) / (error_travel + MIN_TRAVEL))


def forgetting_factor(share: Expression, memory: float) -> Expression:
    """Share that is forgetting_factor of older samples after a share of an independent one [1]."""
    return 1 - share / memory


def white_variance(rig: Parts, tuning: Parts, slide: Expression) -> Expression:
    """Variance of the sensor's white error in 10 ms, divided as in `model_error_variance` [1]."""
    known = is_known(rig["noise"])
    return ca.if_else(known, (ca.if_else(known, rig["noise"], 0) / slide) ** 2, tuning["noise"] ** 2)


def sensor_variance(rig: Parts) -> Expression:
    """Variance of the sensor's noise that the rig declares, 0 where it declares none [N^2 m^2]."""
    return ca.if_else(is_known(rig["noise"]), rig["noise"] ** 2, 0)


def model_error_variance(x: Parts, tuning: Parts) -> Expression:
    """Variance of the model's torque error, divided by the full-slide torque at mu = 1 squared [1].

    It is 0 where the tuning states no model error. The error is a share of full slide at the present mu.
    """
    return ca.if_else(is_stated(tuning), model_error_share(x, tuning) ** 2, 0)


def is_stated(tuning: Parts) -> Expression:
    """Whether the tuning states an error of the model beside the noise."""
    return ca.logic_and(tuning["error_travel"] > 0, tuning["error"] < SENSIBLE)


def model_error_share(x: Parts, tuning: Parts) -> Expression:
    """Deviation of the model's torque error at the present mu, divided by full slide at mu = 1 [1].

    An infinite one is set to 0, so that derivatives stay finite.
    """
    finite = ca.if_else(tuning["error"] < SENSIBLE, tuning["error"], 0)
    return finite * ca.exp(x["log_mu"])


def huber_scale(x: Parts, tuning: Parts, noise: Expression) -> Expression:
    """Square of the error up to which Huber's loss is quadratic, in full slides at mu = 1 [1]."""
    stated = tuning["error"] < SENSIBLE
    return ca.if_else(stated, model_error_share(x, tuning) ** 2 + noise, ca.inf)
