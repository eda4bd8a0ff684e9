"""Extended Kalman filter for ln mu and, as measured, torque zero, stiffness, angle and rate.

The memory of the patch is not filtered: `observers.patch_update` says how it follows the states. The
filter knows nothing of tyres: M_z and its derivatives are the model's.

Source: Jazwinski, Stochastic Processes and Filtering Theory (1970), section 8.3, iterated filter
theorem 8.2; the covariance is kept as a factor, see `observers.udu`.
"""

from dataclasses import dataclass
from functools import cache, partial

import casadi as ca

from observers.base import (
    SAID,
    ModelObserver,
    constants_size,
    flags,
    on_bound,
    prior_variance,
    projected,
    says,
    split_constants,
)
from observers.compiled_step import build_stretch
from observers.innovation_gate import COUNTS, build_gate, huber_share
from observers.layout import Layout, ObserverState
from observers.linearisation import (
    build_clean,
    build_measured,
    build_motion,
    build_moved,
    build_reading,
    directions,
)
from observers.measurement_model import CLEAN, MeasurementModel
from observers.patch_update import (
    build_meeting,
    by_states,
    carries,
    history_fields,
    kept_share,
    signals_of,
    tyre_of,
)
from observers.protocol import SAMPLE, Sample
from observers.udu import covariance
from symbolic import InvalidInputError, Model, compiled


@dataclass(frozen=True, kw_only=True)
class Ekf(ModelObserver):
    """The filter: settings as of `ModelObserver`, and how often it linearises.

    Attributes:
        iterations: linearisations of a measurement; 1 is the plain filter. More pay where one sample
            says much: under a clean torque, while little is known of mu.

    Parts of its state: `memory` (m,) of the patch and, where it depends on the tyre, its derivative
    `carried` (m, t) and the tyre `held_at` (t,) that it stands for; `x` (n,) in the order of `states`
    and `factor` (n, n) of its covariance, see `covariance_of`; `last`, the last sample; `M_z` and
    `slopes`; `counts`, streak and changes of the ground; `said`.
    """

    iterations: int = 1

    def __post_init__(self) -> None:
        """Check the settings."""
        super().__post_init__()
        if not (isinstance(self.iterations, int) and self.iterations >= 1):
            raise InvalidInputError(
                f"iterations must be a whole number of at least 1, got {self.iterations}"
            )

    def init(self, first: Sample) -> ObserverState:
        """The state before the first sample, whose angle says where the patch stands at rest."""
        return ObserverState(self.layout.pack(self._start(first)), self.layout)

    @property
    def layout(self) -> Layout:
        """The parts of a state."""
        return layout(self.model, self.measurement_model)

    @property
    def function(self) -> ca.Function:
        """One sample, compiled; see `ModelObserver.function`."""
        return _compiled_step(self.model, self.measurement_model, self.iterations)

    @property
    def stretch(self) -> ca.Function:
        """Many samples, compiled; see `ModelObserver.stretch`."""
        return _compiled_stretch(self.model, self.measurement_model, self.iterations)


@cache
def layout(model: Model, measurement_model: MeasurementModel) -> Layout:
    """The parts of the filter's state."""
    n = len(measurement_model.states)
    return Layout(
        (
            *history_fields(model, measurement_model),
            ("x", n, 1),
            ("factor", n, n),
            ("last", len(CLEAN), 1),
            ("M_z", 1, 1),
            ("slopes", len(directions(measurement_model)), 1),
            ("counts", len(COUNTS), 1),
            ("said", len(SAID), 1),
        )
    )


@cache
def _compiled_step(model: Model, measurement_model: MeasurementModel, iterations: int) -> ca.Function:
    return compiled(build_step(model, measurement_model, iterations))


@cache
def _compiled_stretch(model: Model, measurement_model: MeasurementModel, iterations: int) -> ca.Function:
    return compiled(build_stretch(build_step(model, measurement_model, iterations)))


@cache
def build_step(model: Model, measurement_model: MeasurementModel, iterations: int = 1) -> ca.Function:
    """One sample of the filter: (state, sample, constants) -> (state_next, said)."""
    parts = layout(model, measurement_model)
    state, sample = ca.MX.sym("state", parts.size), ca.MX.sym("sample", len(SAMPLE))
    constants = ca.MX.sym("constants", constants_size(model))
    before = parts.split(state)
    theta, rig, beliefs = split_constants(model, constants)
    now, held = build_clean(measurement_model)(sample, before["last"])
    motion = build_motion(measurement_model)
    x, A, Q, _ = motion(before["x"], before["M_z"], before["slopes"], before["last"], now, rig, beliefs)
    share = kept_share(measurement_model, covariance(before["factor"]), Q, before["x"])
    history = [before[name] for name, *_ in history_fields(model, measurement_model)]
    if carries(model, measurement_model):
        history[1] = history[1] @ share
    factor = build_moved(len(measurement_model.states))(before["factor"], A, Q)
    read, measure = build_reading(measurement_model), build_measured(len(measurement_model.states))

    meet = partial(_met, model, measurement_model, history, now, theta, rig)
    # Where the angle is measured the patch follows it when it is corrected; else it is what is measured.
    met = before if measurement_model.turns else meet(x)
    innovation, H, weight, expected, ordinary = read(x, met["M_z"], met["slopes"], now, rig, beliefs)
    left_open = ca.dot(H, covariance(factor) @ H)
    verdict = build_gate()(innovation, left_open, weight, ordinary, before["counts"], beliefs)
    believed, reset, _, counts = verdict
    missing = weight <= 0
    change = reset * prior_variance(beliefs)
    known = covariance(factor)[0, 0]
    factor[0, 0] += change
    left_open = left_open + change * H[0] ** 2
    weight = weight * believed * huber_share(innovation, ordinary, left_open)
    after, K, _ = measure(factor, H, weight)
    corrected = projected(measurement_model, x + K * innovation, beliefs)
    for _ in range(0 if measurement_model.turns else iterations - 1):
        met = meet(corrected)
        innovation, H, *_ = read(corrected, met["M_z"], met["slopes"], now, rig, beliefs)
        after, K, _ = measure(factor, H, weight)
        innovation = innovation - ca.dot(H, x - corrected)
        corrected = projected(measurement_model, x + K * innovation, beliefs)
    if measurement_model.turns:
        met = meet(corrected)
        expected = met["M_z"]
    if carries(model, measurement_model):
        # What the old ground did to the patch says nothing of the new one.
        met["carried"] = ca.if_else(reset, known / (known + change), 1) * met["carried"]
    status = flags(
        missing=missing, held=held, rejected=ca.logic_not(believed), reset=reset,
        bound=on_bound(corrected[0], beliefs),
    )  # fmt: skip
    said = ca.vertcat(says(corrected[0], covariance(after)[0, 0]), expected, status)
    made = {**met, "x": corrected, "factor": after, "last": now, "counts": counts, "said": said}
    return ca.Function(
        "ekf_step",
        [state, sample, constants],
        [parts.join(made), said],
        ["state", "sample", "constants"],
        ["state_next", "said"],
    )


def _met(
    model: Model,
    measurement_model: MeasurementModel,
    history: list[ca.MX],
    now: ca.MX,
    theta: ca.MX,
    rig: ca.MX,
    x: ca.MX,
) -> dict[str, ca.MX]:
    """What comes of the patch meeting the sample `now` at the states x: history, M_z and its slopes."""
    meeting = build_meeting(model, measurement_model)
    made = meeting(
        *history, signals_of(measurement_model, x, now), tyre_of(measurement_model, x), theta, rig[:2]
    )
    names = (name.removesuffix("_next") for name in meeting.name_out())
    met = dict(zip(names, made, strict=True))
    return {**met, "slopes": by_states(measurement_model, met["slopes"], x)}
