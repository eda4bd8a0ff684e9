"""The filter on a model with bristles in compact C.

The patch is that of `observers.embedded.compact_bristles`. The filter is the Function of `observers.ekf`
on a patch whose torque and effective friction are inputs, with the parameters as numbers.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import casadi as ca

from observers.effective_friction import build_effective_friction
from observers.ekf import Ekf, build_step, layout
from observers.embedded.casadi_c import embedded_code
from observers.embedded.compact_bristles import CompactBristles, has_bristles
from observers.embedded.compact_corners import CompactCorners, has_corners
from observers.embedded.constants import Constants
from observers.embedded.scalar_function import with_known_exponentials
from observers.embedded.scalar_type import Real
from observers.embedded.supervision_code import supervised, supervision_functions
from observers.embedded.templating import Body, render
from observers.initial_state import build_initial_state
from observers.innovation_monitor import change_variance
from observers.layout import Layout, named
from observers.linearisation import build_clean, build_motion, directions, state_index
from observers.measurement_model import CLEAN, RIG
from observers.model_observer import ModelObserver
from observers.patch_update import reset_retention, sensitivity_retention
from observers.protocol import OUTPUT, SAMPLE, FunctionObserver
from observers.tuning import TUNING_FIELDS
from observers.udu import covariance
from symbolic import DECLARED, GEOMETRY, SIGNALS
from symbolic.compilation.scalar_c import c_function
from symbolic.deformation import full_slide_arm

MEMORY = Layout(tuple((name, 1, 1) for name in ("M_z", "by_mu", "mu", "slide", "beside")))
"""Memory of a `GivenTorque`: M_z [N m] and its derivative by mu, at mu; effective friction over mu, and
what is beside it [1]."""


@dataclass(frozen=True)
class GivenTorque:
    """A patch whose torque, linear in mu, and effective friction are in its memory; a `PatchModel`."""

    @property
    def memory_size(self) -> int:
        """Length of the memory."""
        return MEMORY.size

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Those of the declared model."""
        return tuple(parameter.name for parameter in DECLARED)

    @property
    def initial(self) -> ca.Function:
        """(signals, theta, geometry) -> zeros: the memory is an input of every step."""
        return ca.Function("start", self._symbols()[1:], [ca.MX(ca.DM.zeros(MEMORY.size))])

    @property
    def advance(self) -> ca.Function:
        """The memory as it is: (memory, signals, theta, geometry) -> (memory_next, seen)."""
        memory, signals, *_ = inputs = self._symbols()
        return ca.Function("advance", inputs, [memory, signals])

    @property
    def torque(self) -> ca.Function:
        """The torque to first order: (memory, seen, theta, geometry) -> M_z."""
        memory, _, theta, _ = inputs = self._symbols()
        at, mu = MEMORY.split(memory), theta[self.coordinates.index("mu")]
        return ca.Function("torque", inputs, [at["M_z"] + at["by_mu"] * (mu - at["mu"])])

    @property
    def full_slide(self) -> ca.Function:
        """(memory, F_N, theta, geometry, rate) -> (mu_eff, M_slide)."""
        memory, _, theta, geometry = self._symbols()
        F_N, rate, at = ca.MX.sym("F_N"), ca.MX.sym("rate"), MEMORY.split(memory)
        mu_eff = theta[self.coordinates.index("mu")] * at["slide"] + at["beside"]
        M_slide = mu_eff * F_N * full_slide_arm(geometry[0], geometry[1])
        return ca.Function("full_slide", [memory, F_N, theta, geometry, rate], [mu_eff, M_slide])

    def memory_depends_on(self, coordinate: str) -> bool:
        """False: C carries the derivative of the bristles."""
        del coordinate
        return False

    def _symbols(self) -> list[ca.MX]:
        sizes = (MEMORY.size, len(SIGNALS), len(self.coordinates), len(GEOMETRY))
        return [ca.MX.sym(f"in{i}", size) for i, size in enumerate(sizes)]


def is_compact_bristle_filter(observer: FunctionObserver) -> bool:
    """True for an `Ekf`, not a subclass, that linearises once, on a model with effects."""
    if type(observer) is not Ekf or observer.iterations != 1:
        return False
    return has_bristles(observer) or has_corners(observer)


def bristle_filter_body(observer: Ekf, real: Real, terms: Mapping[str, Any]) -> Body:
    """The code of a filter for which `is_compact_bristle_filter` holds."""
    kind = CompactBristles if has_bristles(observer) else CompactCorners
    bristles, parts = kind(observer, real), _layout(observer)
    constants = Constants(observer, terms["tunable"], theta=range(len(DECLARED)))
    functions = [
        *bristles.functions,
        _build_begin(observer, constants),
        _build_filter(observer, constants),
        *supervision_functions(observer, terms["tunable"]),
    ]
    source = embedded_code(functions, real, f"{terms['name']}_core", null_checks=False)
    own = [
        ("clean_sample", build_clean_sample(observer)),
        ("retentions", _build_retentions(observer, constants)),
    ]
    if "psi" in observer.states:
        own.append(("effective_friction", _build_effective_friction(observer)))
    by_state = {"psi": "torque[2]", "log_mu": "torque[1] * output[OUT_MU]"}
    values = {
        **terms, **bristles.terms, "a": repr(float(observer.rig.a)), "clean": len(CLEAN),
        "at": _indices(observer), "last": parts.places["last"][0].start,
        "is_angle_known": "psi" not in observer.states,
        "slopes": [by_state[name] for name in directions(observer.measurement_model)],
    }  # fmt: skip
    size = parts.size
    private = f"    {real.c_type} values[2][{size}]; /* of the filter, before and after a sample */\n"
    private += f"    {terms['name']}_patch_t patch;"
    scalar = "\n".join(c_function(name, function, real.c_type) for name, function in own)
    body = Body(
        core=f"{source.text}\n{bristles.numbers(values, scalar)}\n{scalar}\n{bristles.text(values)}",
        stepping=render("bristle_stepping.c", values),
        private=private,
        bytes=2 * size * real.size + bristles.bytes,
        types=bristles.state_type(terms["name"]),
    )
    return supervised(observer, real, values, body, source, parts)


def build_clean_sample(observer: ModelObserver) -> ca.Function:
    """(sample, last) -> the sample cleaned."""
    sample, last = ca.SX.sym("sample", len(SAMPLE)), ca.SX.sym("last", len(CLEAN))
    now = build_clean(observer.measurement_model)(sample, last)[0]
    return ca.Function("clean_sample", [sample, last], [now], ["sample", "last"], ["now"], {"cse": True})


def _layout(observer: Ekf) -> Layout:
    return layout(GivenTorque(), observer.measurement_model)


def _indices(observer: Ekf) -> dict[str, int]:
    """Index in the filter's state of each part, state, and element of memory and output."""
    indices = {name: at.start for name, (at, _) in _layout(observer).places.items()}
    indices |= {name: indices["x"] + i for i, name in enumerate(observer.states)}
    memory = {f"memory.{name}": at.start for name, (at, _) in MEMORY.places.items()}
    indices |= {name: indices["memory"] + at for name, at in memory.items()}
    return indices | {f"output.{name}": indices["output"] + i for i, name in enumerate(OUTPUT)}


def _build_begin(observer: Ekf, constants: Constants) -> ca.Function:
    """(sample) -> the state before it."""
    start = build_initial_state(GivenTorque(), observer.measurement_model, _layout(observer))
    return constants.fill("begin_filter", start)


def _build_filter(observer: Ekf, constants: Constants) -> ca.Function:
    """(state, sample) -> (state_next, output)."""
    step = build_step(GivenTorque(), observer.measurement_model, observer.iterations)
    flat = constants.fill("filter", step)
    at = _indices(observer)
    mu = observer.measurement_model.patch_before(at["output.mu"], lambda: at["memory.mu"])
    return with_known_exponentials(flat, {at["log_mu"]: mu})


def _build_retentions(observer: Ekf, constants: Constants) -> ca.Function:
    """(state, now) -> shares of the bristles' derivative that a walk of mu leaves, and a new ground."""
    parts, sensing = _layout(observer), observer.measurement_model
    state, now = ca.MX.sym("state", parts.size), ca.MX.sym("now", len(CLEAN))
    rig, tuning = ca.MX.sym("rig", len(RIG)), ca.MX.sym("tuning", len(TUNING_FIELDS))
    before = parts.split(state)
    _, _, Q, _ = build_motion(sensing)(
        before["x"], before["M_z"], before["slopes"], before["last"], now, rig, tuning
    )
    P, at = covariance(before["factor"]), state_index(sensing)
    walk = sensitivity_retention(sensing, P, Q, before["x"])
    change = reset_retention(ca.MX(1), P[at, at] + Q[at], change_variance(named(TUNING_FIELDS, tuning)))
    function = ca.Function(
        "retentions", [state, now, rig, tuning], [ca.vertcat(walk, change)],
        ["state", "now", "rig", "tuning"], ["retention"],
    )  # fmt: skip
    return constants.fill("retentions", function)


def _build_effective_friction(observer: Ekf) -> ca.Function:
    """(mu, mu_std, F_N, slide) -> (mu_eff, mu_eff_std, M_slide)."""
    friction = build_effective_friction(GivenTorque())
    mu, std, F_N, slide = (
        ca.MX.sym("mu"), ca.MX.sym("mu_std"), ca.MX.sym("F_N"), ca.MX.sym("slide", 2),
    )  # fmt: skip
    memory = ca.vertcat(0, 0, 0, slide)
    geometry = ca.DM([observer.rig.a, observer.rig.e])
    outputs = friction(mu, std, memory, F_N, ca.DM([1, 1]), geometry, 0.0)
    return ca.Function(
        "effective_friction", [mu, std, F_N, slide], [*outputs], ["mu", "mu_std", "F_N", "slide"],
        ["mu_eff", "mu_eff_std", "M_slide"],
    ).expand()  # fmt: skip
