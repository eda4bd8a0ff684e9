"""What the windows in compact C share: the numbers kept of a sample, and the state of an estimator."""

from typing import Any

from observers.embedded.scalar_type import Real
from observers.estimators.mhe import Mhe
from observers.estimators.model_observer import ModelObserver
from observers.layout import Layout
from observers.measurement.linearisation import directions
from observers.measurement.measurement_model import CLEAN, AligningTorque
from observers.measurement.steering_torque import SteeringTorque
from observers.quality.innovation_gate import COUNTS
from observers.quality.innovation_monitor import MONITOR

ROWS_STORED = {
    AligningTorque: ("F_N", "dt", "M_z", "travel", "accepted", "jump"),
    SteeringTorque: ("psi", "F_N", "dt", "M", "M_age", "accepted", "jump"),
}
"""Numbers of a sample that C stores: all that the terms of a measurement model depend on."""
STORED_CORNERS = 8
"""Corners stored with a sample; what the others add to the torque is stored as linear in mu / k."""
STATE = """\
    {real} mean[{n}], factor[{n} * {n}], P_newest[{n} * {n}], last[{clean}], counts[2], monitor[4];
    {real} x[{window}][{n}], row[{window}][{row}], eliminated[{window}][{eliminated}];
    {real} {kept};{angle}
    {name}_patch_t patch;
    int32_t newest;{integers}"""


def elimination(observer: ModelObserver) -> Layout:
    """The parts that forward elimination leaves for back substitution."""
    n = len(observer.states)
    parts = (("filtered", n, 1), ("P", n, n), ("K", n, 1), ("score", 1, 1), ("H", n, 1))
    slopes = ("slopes", len(directions(observer.measurement_model)), 1)
    return Layout((*parts, slopes) if is_steered(observer) else parts)


def elimination_size(observer: ModelObserver) -> int:
    """Length of the vector of `elimination`."""
    return elimination(observer).size


def row_names(observer: ModelObserver) -> tuple[str, ...]:
    """Names of the numbers of a sample that C stores."""
    return ROWS_STORED[type(observer.measurement_model)]


def is_steered(observer: ModelObserver) -> bool:
    """True where the angle is a state, which the torque moves."""
    return "psi" in observer.states


def window_values(observer: Mhe) -> dict[str, Any]:
    """Values of the placeholders of `templates/window.c` that all windows share."""
    states = {name: str(i) for i, name in enumerate(observer.states)}
    if observer.states[0] != "log_mu":
        # C adds to one element of a factor U D U', which is right for the first state only.
        raise ValueError(f"log_mu must be the first state, got {', '.join(observer.states)}")
    row = row_names(observer)
    return {
        "window": str(observer.window), "states": str(len(observer.states)), "clean": str(len(CLEAN)),
        "eliminated": str(elimination_size(observer)), "effects": False, "bristles": False,
        "log_mu": states["log_mu"], "psi": states.get("psi", ""), "psi_dot": states.get("psi_dot", ""),
        "steering": is_steered(observer), "row": row,
        "measured": [(name, CLEAN.index(name)) for name in row if name in CLEAN],
    }  # fmt: skip


def window_state(
    observer: Mhe, real: Real, name: str, kept: str, numbers: int, integers: str = ""
) -> tuple[str, int]:
    """C of the state of a window, and its bytes without the patch.

    Args:
        observer: the estimator.
        real: the type.
        name: begins every name in C.
        kept: declarations of what is kept of the patch with every sample.
        numbers: how many numbers these are, a sample.
        integers: declarations of integers.
    """
    n, eliminated, row = len(observer.states), elimination_size(observer), len(row_names(observer))
    angle = f"{real.c_type} angle[{observer.window}], by_angle[{observer.window}];"
    text = STATE.format(
        real=real.c_type, name=name, n=n, window=observer.window, eliminated=eliminated,
        clean=len(CLEAN), row=row, kept=kept, integers=integers,
        angle=f"\n    {angle}" if is_steered(observer) else "",
    )  # fmt: skip
    parts = n + 2 * n * n + len(CLEAN) + len(COUNTS) + len(MONITOR)
    a_sample = n + row + eliminated + numbers + 2 * is_steered(observer)
    return text, (parts + observer.window * a_sample) * real.size + 4


def corner_state(observer: Mhe, real: Real, name: str) -> tuple[str, int]:
    """As `window_state`, for windows that keep corners of the patch."""
    window, stored = observer.window, STORED_CORNERS
    kept = f"slope[{window}], lost[{window}][2], xi[{window}][{stored}], d[{window}][{stored}]"
    integers = f"\n    int8_t corners[{window}];"
    text, size = window_state(observer, real, name, kept, 3 + 2 * stored, integers)
    return text, size + window
