"""Acquired friction written into the state of an estimator, and values read from such a state."""

import casadi as ca

from observers.layout import Expression, Layout, Parts
from observers.measurement.measurement_model import CLEAN, ROWS, MeasurementModel
from observers.quality.acquisition import HANDED_STATES


def newest_state(
    parts: Layout, measurement_model: MeasurementModel, state: Expression, name: str
) -> Expression:
    """A state of the newest sample by its name, 0 where there is none."""
    if name not in measurement_model.states:
        return ca.MX(0)
    at, (rows, columns) = parts.places["x"]
    return state[at.start + rows * (columns - 1) + measurement_model.states.index(name)]


def newest_of_sample(parts: Layout, state: Expression, names: tuple[str, ...]) -> Expression:
    """Numbers of the newest sample, cleaned, by their names."""
    at, (rows, columns) = parts.places["samples" if "samples" in parts.places else "last"]
    first = at.start + rows * (columns - 1)
    return ca.vertcat(*(state[first + CLEAN.index(name)] for name in names))


def take_acquired(
    parts: Layout, states: tuple[str, ...], state: Expression, handed: Parts
) -> Expression:
    """A state of an estimator with ln mu, M_0 and the gear as acquired, not correlated with the rest.

    A window is emptied: its samples led to states that do not count. The memory of bristles stays as it
    is, whatever mu was.
    """
    after = parts.split(state)
    covariance = "P_newest" if "P_newest" in after else "factor"
    for at, name in enumerate(states):
        if name not in HANDED_STATES:
            continue
        after[covariance][at, :] = 0
        after[covariance][:, at] = 0
        after[covariance][at, at] = handed[f"{name}_variance"]
        after["x"][at, :] = handed[name]
    if "samples" in after:
        after |= _empty_window(after)
    for name in ("counts", "monitor", "memory_sensitivity"):
        if name in after:
            after[name] = ca.MX(ca.DM.zeros(*after[name].shape))
    return parts.join(after)


def _empty_window(window: Parts) -> dict[str, ca.MX]:
    """A window with nothing but the last step: no measurement, no motion before it.

    window has the newest states, and their covariance, of which the variances are kept.
    """
    columns = window["x"].shape[1]
    before = window["x"][:, max(columns - 2, 0)]
    samples = ca.MX(window["samples"])
    samples[[ROWS.index("accepted"), ROWS.index("jump")], :] = 0
    samples[ROWS.index("dt"), : columns - 1] = 0
    return {
        "x": ca.horzcat(ca.repmat(before, 1, columns - 1), window["x"][:, -1]),
        "mean": before,
        "factor": ca.diag(ca.diag(window["P_newest"])),
        "samples": samples,
    }
