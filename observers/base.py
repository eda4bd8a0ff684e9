"""The settings that observers built on a model share, and what they make of them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from observers.compiled_step import CompiledStep, first_sample, run_stretches
from observers.layout import Layout, ObserverState, named
from observers.measurement_model import CLEAN, RIG, SENSIBLE, AligningTorque, MeasurementModel
from observers.patch_update import tyre
from observers.protocol import Estimate, Sample, Status
from observers.tuning import BELIEFS, Tuning
from symbolic import InvalidInputError, Model, Rig, full_slide_torque

Array = NDArray[np.float64]
SAID = ("mu", "mu_std", "M_z_predicted", "status")
"""What a state says, in the order of its part `said`."""


@dataclass(frozen=True, kw_only=True)
class ModelObserver:
    """A model, its fixed parameters, the rig, what is measured and what is believed.

    Attributes:
        model: the model, with the effects that a diagnosis found if there are any.
        values: every parameter of the model but mu, by name (`k`, `effect.parameter`).
        rig: geometry; J_A and b_t too where the steering torque is measured.
        tuning: prior and noises.
        measurement_model: which torque is measured, and which states there are beside mu.

    Raises:
        InvalidInputError: a parameter is missing or out of bounds, or the rig lacks one.
    """

    model: Model
    values: Mapping[str, float]
    rig: Rig
    tuning: Tuning = field(default_factory=Tuning)
    measurement_model: MeasurementModel = field(default_factory=AligningTorque)

    def __post_init__(self) -> None:
        """Check the parameters, the rig, and that they go together."""
        for name, kind in (("model", Model), ("rig", Rig), ("tuning", Tuning)):
            if not isinstance(getattr(self, name), kind):
                raise InvalidInputError(
                    f"{name} must be a {kind.__name__}, got {type(getattr(self, name)).__name__}"
                )
        if isinstance(self.measurement_model, type) or not hasattr(self.measurement_model, "reading"):
            raise InvalidInputError(
                "measurement_model must be AligningTorque(...) or SteeringTorque(...), with brackets,"
                f" got {self.measurement_model!r}"
            )
        sensors = [effect.name for effect in self.model.effects if effect.sensor]
        if self.measurement_model.turns and sensors:
            raise InvalidInputError(
                f"the model's {sensors[0]} belongs to the channel of the aligning torque, which is not"
                " measured here; leave the effect out"
            )
        self.model.theta({**self.values, "mu": self.tuning.mu})
        self.measurement_model.check(self.rig)

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states, in the order of `state["x"]`."""
        return self.measurement_model.states

    @property
    def layout(self) -> Layout:
        """The parts of a state."""
        raise NotImplementedError

    @property
    def function(self) -> ca.Function:
        """One sample, compiled: (state, sample, constants) -> (state_next, said).

        sample in the order of `observers.SAMPLE`; constants as in `constants`; said as in `SAID`.
        """
        raise NotImplementedError

    @property
    def stretch(self) -> ca.Function:
        """The same over `observers.compiled_step.STRETCH` samples, one column each."""
        raise NotImplementedError

    @cached_property
    def constants(self) -> Array:
        """Parameters of the model at the prior's mu, of the rig, and the beliefs, in one vector."""
        theta = self.model.theta({**self.values, "mu": self.tuning.mu})
        rig = [float("nan") if (v := getattr(self.rig, name)) is None else v for name in RIG]
        return np.concatenate([theta.full().ravel(), rig, self.tuning.beliefs])

    def step(self, state: ObserverState, sample: Sample) -> ObserverState:
        """The state after one more sample; the state given is not changed."""
        if state.values.size != self._size:
            raise InvalidInputError(
                f"the state has {state.values.size} numbers, this observer's has {self._size};"
                " it belongs to another observer"
            )
        return ObserverState(self._compiled_step(state.values, sample), state.layout)

    def estimate(self, state: ObserverState) -> Estimate:
        """What the state says of mu."""
        mu, std, predicted, status = state["said"].tolist()
        return Estimate(
            mu=mu,
            mu_std=std,
            M_z_predicted=predicted,
            informed=bool(self.tuning.informed(mu, std)),
            status=Status(int(status)),
        )

    def run_samples(self, samples: Array) -> Array:
        """A whole recording; see `BatchObserver.run_samples`."""
        start = self.init(first_sample(samples)).values
        mu, std, predicted, status = run_stretches(self.stretch, start, samples, self.constants)
        return np.vstack([mu, std, predicted, self.tuning.informed(mu, std), status])

    def init(self, first: Sample) -> ObserverState:
        """The state before the first sample, whose angle says where the patch stands at rest."""
        raise NotImplementedError

    @cached_property
    def _size(self) -> int:
        return self.layout.size

    @cached_property
    def _compiled_step(self) -> CompiledStep:
        return CompiledStep(self.function, self.constants)

    def __getstate__(self) -> dict[str, Any]:
        """Without what cannot be pickled and is made anew."""
        made = ("_compiled_step", "constants")
        return {name: value for name, value in self.__dict__.items() if name not in made}

    def _start(self, first: Sample) -> dict[str, Array | float]:
        """Parts that every state has, before the first sample."""
        if not (abs(first.psi) < SENSIBLE and 0 < first.F_N < SENSIBLE):
            raise InvalidInputError(
                "the first sample must have a finite psi and F_N > 0 N, as they say where the patch"
                f" stands; got psi = {first.psi} rad, F_N = {first.F_N} N; wait for one that has"
            )
        rate = first.psi_dot if np.isfinite(first.psi_dot) else 0.0
        theta = self.model.theta({**self.values, "mu": self.tuning.mu})
        geometry = ca.DM([self.rig.a, self.rig.e])
        signals = ca.DM([first.psi, rate, first.F_N, first.dt])
        memory = self.model.initial(signals, theta, geometry).full().ravel()
        slide = float(full_slide_torque(first.F_N, self.rig.a))
        prior = self.measurement_model.prior(self.tuning, first, slide)
        mean, std = np.array([prior[name] for name in self.states]).T
        last = dict.fromkeys(CLEAN, 0.0) | {"psi": first.psi, "F_N": first.F_N}
        return {
            "memory": memory.reshape(-1, 1),
            "carried": 0.0,
            "held_at": np.array([[self.tuning.mu], [1.0]])[: len(tyre(self.measurement_model))],
            "x": mean.reshape(-1, 1),
            "factor": np.diag(std**2),
            "last": np.array([[last[name]] for name in CLEAN]),
            "M_z": 0.0,
            "slopes": 0.0,
            "counts": 0.0,
            "said": np.array([[self.tuning.mu], [self.tuning.mu_std], [float("nan")], [0.0]]),
        }


STIFFNESS_SHARE = (0.1, 10.0)
"""Bounds of k over its nominal value, where it is a state [1]."""


def split_constants(model: Model, constants: ca.MX) -> tuple[ca.MX, ca.MX, ca.MX]:
    """theta, rig and beliefs of `ModelObserver.constants`."""
    at = len(model.parameters)
    theta, rig, beliefs = ca.vertsplit(constants, [0, at, at + len(RIG), constants.numel()])
    return theta, rig, beliefs


def constants_size(model: Model) -> int:
    """Length of `ModelObserver.constants`."""
    return len(model.parameters) + len(RIG) + len(BELIEFS)


def flags(**conditions: ca.MX) -> ca.MX:
    """The status of a sample, `Status` as a number, from a condition a flag."""
    total = ca.MX(0)
    for name, condition in conditions.items():
        total = total + ca.if_else(condition, int(Status[name.upper()]), 0)
    return total


def projected(measurement_model: MeasurementModel, x: ca.MX, beliefs: ca.MX) -> ca.MX:
    """The states, one column a sample, with mu on its bounds where it is beyond, k off nonsense."""
    belief = named(BELIEFS, beliefs)
    bounds: dict[str, tuple[Any, Any]] = {
        "log_mu": (ca.log(belief["least"]), ca.log(belief["greatest"])),
        "stiffness": STIFFNESS_SHARE,
    }
    rows = [
        ca.fmax(bounds[name][0], ca.fmin(bounds[name][1], x[i, :])) if name in bounds else x[i, :]
        for i, name in enumerate(measurement_model.states)
    ]
    return ca.vertcat(*rows)


def on_bound(log_mu: ca.MX, beliefs: ca.MX) -> ca.MX:
    """True where mu, projected, lies on one of its bounds."""
    belief = named(BELIEFS, beliefs)
    bounds = ca.log(belief["least"]), ca.log(belief["greatest"])
    outside: ca.MX = ca.logic_or(log_mu <= bounds[0], log_mu >= bounds[1])
    return outside


def prior_variance(beliefs: ca.MX) -> ca.MX:
    """Variance of ln mu before anything is known of the ground."""
    belief = named(BELIEFS, beliefs)
    variance: ca.MX = (belief["mu_std"] / belief["mu"]) ** 2
    return variance


def says(log_mu: ca.MX, variance: ca.MX) -> ca.MX:
    """The coefficient of friction and its standard deviation, from those of its logarithm."""
    return ca.exp(log_mu) * ca.vertcat(1, ca.sqrt(variance))
