"""The moving-horizon estimator in compact C, `templates/estimators/window.c`.

What the window keeps of the patch is stored with every sample. C loops over the samples and calls, at
each, the Functions of `observers.estimators.mhe_recursions`, adapted here to scalar arguments.
"""

from dataclasses import dataclass

import casadi as ca

from observers.embedded.estimators.shared_step_functions import (
    TORQUE,
    EstimatorCode,
    function_of_symbols,
    initial_state_parts,
    memory_with_slide_only,
    motion_depends_on_patch_torque,
    sensitivity_retentions,
    stiffness_ratio_c,
    stored_fields,
)
from observers.embedded.patches.patch_code import PatchCode, mhe_window_length
from observers.embedded.scalar_expansion import ConstantSubstitution
from observers.estimators.ekf_mhe_step_terms import StepSample, clip_to_bounds
from observers.estimators.mhe_recursions import (
    arrival_variance_increment,
    build_acceptance_update,
    build_back_substitution,
    build_forward_elimination,
    build_state_prediction,
    has_not_converged,
)
from observers.layout import Layout, named, outputs_of
from observers.measurement.directional_friction import EVIDENCE, OTHER
from observers.measurement.measurement_model import CLEAN, RIG, ROWS, MeasurementModel
from observers.measurement.motion_and_torque_jacobians import build_linearised_motion, slope_states
from observers.patch.update import slopes_by_states, tyre_states
from observers.protocol import SAMPLE
from observers.quality.friction_change_by_stroke import change_monitor_fields
from observers.quality.outlier_or_ground_change import COUNTS, build_innovation_test
from observers.quality.slow_change_and_misfit_alarms import log_mu_variance_between_grounds
from observers.tuning import TUNING_FIELDS

TORQUES = ("M_Z", "BY_MU", "BY_STIFFNESS", "BY_ANGLE")
"""Order of a torque in C, see `templates/patches/torque_places.c`."""
TEST = ("accepted", "reset", "run", "missing", "expected", "nis", "inconsistent", "lag")
"""Result of the test of the newest innovation, see `innovation_test_outputs`."""
STATE = """\
    {real} mean[{n}], factor[{n} * {n}], P_newest[{n} * {n}];
    {real} last[{clean}], counts[{counts}], monitor[{monitor}];
    {real} x[{window}][{n}], row[{window}][{row}], eliminated[{window}][{eliminated}];
{kept}    NAME_patch_t patch;
    int32_t newest;
{integers}"""


def compact_mhe_code(patch: PatchCode, constants: ConstantSubstitution) -> EstimatorCode:
    """An `Mhe` of one iteration over two samples or more, on a patch of C."""
    observer, size, window = patch.observer, patch.real.size, mhe_window_length(patch.observer)
    model = observer.measurement_model
    built = MheStepFunctions(patch, window).all_functions()
    functions = [constants.substitute_constants(function.name(), function) for function in built]
    if patch.follows_mu:
        P = ca.MX.sym("P", len(model.states), len(model.states))
        functions.append(sensitivity_retentions(observer, constants, P, P, predicted=False))
    row, n, eliminated = stored_fields(model), len(model.states), forward_elimination_layout(model).size
    numbers = n + 2 * n * n + len(CLEAN) + len(COUNTS) + len(change_monitor_fields(model))
    a_sample = (n + len(row) + eliminated) * size + patch.kept_bytes
    states = {name: i for i, name in enumerate(model.states)}
    return EstimatorCode(
        template="estimators/window.c",
        functions=functions,
        element_names={"row": row, "torque": TORQUES, "test": innovation_test_outputs(model)},
        terms={
            "window": window, "eliminated": eliminated,
            "moves_states": motion_depends_on_patch_torque(model),
            "log_mu": states["log_mu"], "psi": states.get("psi"), "row": row,
            "test": innovation_test_outputs(model), "walk": len(tyre_states(model)) ** 2,
            "measured": [(name, CLEAN.index(name)) for name in row if name in CLEAN],
            "evidence": [CLEAN.index(EVIDENCE)] if OTHER in states else [],
            "stiffness": stiffness_ratio_c(model, "x"),
            "stiffness_newest": stiffness_ratio_c(model, "newest"),
            "stiffness_corrected": stiffness_ratio_c(model, "state->x[at]"),
            "newest_x": "state->x[state->newest]", "newest_last": "state->last",
            "x": "state->x[newest]", "P": "state->P_newest",
            "own_state": "state->",
        },
        private_fields=STATE.format(
            real=patch.real.c_type, n=n, window=window, eliminated=eliminated, clean=len(CLEAN),
            row=len(row), counts=len(COUNTS), monitor=len(change_monitor_fields(model)), kept=patch.kept,
            integers=patch.kept_integers,
        ).rstrip(),
        bytes=numbers * size + 4 + window * a_sample,
    )  # fmt: skip


def innovation_test_outputs(model: MeasurementModel) -> tuple[str, ...]:
    """Names of what a test gives."""
    return (*TEST, "untested", "evidence") if OTHER in model.states else TEST


def forward_elimination_layout(model: MeasurementModel) -> Layout:
    """The parts that forward elimination leaves for back substitution."""
    n = len(model.states)
    slopes = {"slopes": len(slope_states(model))} if motion_depends_on_patch_torque(model) else {}
    return Layout.of(filtered=n, P=(n, n), K=n, score=1, H=n, **slopes)


@dataclass(frozen=True)
class MheStepFunctions:
    """The Functions that C calls at each sample of a window."""

    patch: PatchCode
    window: int

    @property
    def measurement_model(self) -> MeasurementModel:
        """The observer's measurement model."""
        return self.patch.observer.measurement_model

    def all_functions(self) -> list[ca.Function]:
        """All of them."""
        return [
            self.initial_arrival(), self.clip_states(), self.predict(), self.test_innovation(),
            self.update_acceptance(), self.arrival_increment(), self.forward_eliminate(),
            self.substitute_back(), self.output(),
        ]  # fmt: skip

    def symbols(self, *names: str) -> list[ca.MX]:
        """Symbols of these names, in their shapes."""
        model = self.measurement_model
        n, row = len(model.states), len(stored_fields(model))
        shapes = {
            "sample": (len(SAMPLE), 1), "last": (len(CLEAN), 1), "now": (len(CLEAN), 1), "x": (n, 1),
            "mean": (n, 1), "factor": (n, n), "P": (n, n), "torque": (len(TORQUES), 1),
            "row": (row, 1), "after": (row, 1), "counts": (len(COUNTS), 1),
            "monitor": (len(change_monitor_fields(model)), 1),
            "eliminated": (forward_elimination_layout(model).size, 1), "costate": (n, 1),
            "newest": (n, 1), "test": (len(innovation_test_outputs(model)), 1), "age": (1, 1),
            "imputed": (1, 1), "slide": (2, 1), "tuning": (len(TUNING_FIELDS), 1),
            "theta": (len(self.patch.torque_model.coordinate_names), 1), "rig": (len(RIG), 1),
        }  # fmt: skip
        return [ca.MX.sym(name, *shapes[name]) for name in names]

    def expand_stored_row(self, row: ca.MX) -> ca.MX:
        """The stored numbers at their places in `ROWS`; the others are 0, as nothing here uses them."""
        stored = named(stored_fields(self.measurement_model), row)
        full: ca.MX = ca.vertcat(*(stored.get(name, 0) for name in ROWS))
        return full

    def torque_and_slopes(self, torque: ca.MX, x: ca.MX) -> tuple[ca.MX, ca.MX]:
        """M_z and its slopes by the states."""
        parts = named(TORQUES, torque)
        slopes = ca.vertcat(*(parts[TORQUE[name]] for name in slope_states(self.measurement_model)))
        return parts["M_Z"], slopes_by_states(self.measurement_model, slopes, x)

    def initial_arrival(self) -> ca.Function:
        """(sample) -> mean, factor, last."""
        n = len(self.measurement_model.states)
        parts = Layout.of(mean=n, factor=(n, n), last=len(CLEAN))
        return initial_state_parts(
            "begin_window", self.patch, parts, {name: name for name in parts.places}
        )

    def clip_states(self) -> ca.Function:
        """(x) -> within bounds."""
        x, tuning = self.symbols("x", "tuning")
        return function_of_symbols(
            "limit", [x, tuning], limited=clip_to_bounds(self.measurement_model, x, tuning)
        )

    def predict(self) -> ca.Function:
        """(x, torque, P, last, now) -> newest, P at it."""
        names = ("x", "torque", "P", "last", "now", "rig", "tuning")
        x, torque, P, last, now, rig, tuning = inputs = self.symbols(*names)
        predict = build_state_prediction(self.measurement_model)
        newest, P_newest, _ = predict(x, P, *self.torque_and_slopes(torque, x), last, now, rig, tuning)
        return function_of_symbols("predict", inputs, newest=newest, P_newest=P_newest)

    def test_innovation(self) -> ca.Function:
        """(newest, torque, now, P, counts, monitor) -> test, counts, monitor."""
        names = ("newest", "torque", "now", "P", "counts", "monitor", "rig", "tuning")
        newest, torque, now, P, counts, monitor, rig, tuning = inputs = self.symbols(*names)
        M_z, slopes = self.torque_and_slopes(torque, newest)
        innovation = build_innovation_test(self.measurement_model)
        results = outputs_of(innovation, newest, P, M_z, slopes, now, counts, monitor, rig, tuning)
        test = ca.vertcat(*(results[name] for name in innovation_test_outputs(self.measurement_model)))
        after = {name: results[name] for name in ("counts_next", "monitor_next")}
        return function_of_symbols("test_innovation", inputs, test=test, **after)

    def update_acceptance(self) -> ca.Function:
        """(row, age, test) -> accepted, jump."""
        row, age, test, tuning = inputs = self.symbols("row", "age", "test", "tuning")
        stored, three = named(stored_fields(self.measurement_model), row), test[: TEST.index("run") + 1]
        unknown = log_mu_variance_between_grounds(named(TUNING_FIELDS, tuning))
        accepted, jump = build_acceptance_update()(
            stored["accepted"], stored["jump"], age, three, unknown
        )
        return function_of_symbols("accept", inputs, accepted=accepted, jump=jump)

    def arrival_increment(self) -> ca.Function:
        """(test) -> increment of the arrival's variance of ln mu."""
        test, tuning = inputs = self.symbols("test", "tuning")
        result = named(innovation_test_outputs(self.measurement_model), test)
        unknown = log_mu_variance_between_grounds(named(TUNING_FIELDS, tuning))
        jump = arrival_variance_increment(self.window, result["reset"], result["run"], unknown)
        return function_of_symbols("reset_arrival", inputs, jump=jump)

    def forward_eliminate(self) -> ca.Function:
        """(mean, factor, x, torque, row, after) -> mean, factor, eliminated."""
        names = ("mean", "factor", "x", "torque", "row", "after", "rig", "tuning")
        mean, factor, x, torque, row, after, rig, tuning = inputs = self.symbols(*names)
        forward = build_forward_elimination(self.measurement_model)
        rows, (M_z, slopes) = (
            (self.expand_stored_row(r) for r in (row, after)),
            self.torque_and_slopes(torque, x),
        )
        results = outputs_of(forward, mean, factor, x, M_z, slopes, *rows, rig, tuning)
        results["slopes"] = slopes
        return function_of_symbols(
            "forward", inputs, mean_next=results["mean_next"], factor_next=results["factor_next"],
            eliminated=forward_elimination_layout(self.measurement_model).join(results),
        )  # fmt: skip

    def substitute_back(self) -> ca.Function:
        """(costate, eliminated, row, after) -> costate before, smoothed x within bounds."""
        names = ("costate", "eliminated", "row", "after", "rig", "tuning")
        costate, eliminated, row, after, rig, tuning = inputs = self.symbols(*names)
        parts = forward_elimination_layout(self.measurement_model).split(eliminated)
        # The motion is cheaper to compute again than to store with every sample.
        now, now_next = (self.expand_stored_row(vector)[: len(CLEAN)] for vector in (row, after))
        motion = build_linearised_motion(self.measurement_model)
        slopes = parts.pop("slopes", ca.DM.zeros(len(slope_states(self.measurement_model))))
        _, A, _, _ = motion(parts["filtered"], 0, slopes, now, now_next, rig, tuning)
        before, smoothed = build_back_substitution(self.measurement_model)(
            costate, *parts.values(), A, tuning
        )
        return function_of_symbols("backward", inputs, costate_before=before, smoothed=smoothed)

    def output(self) -> ca.Function:
        """(x, P, newest, now, test, imputed, slide) -> output."""
        names = ("x", "P", "newest", "now", "test", "imputed", "slide", "theta", "rig", "tuning")
        x, P, newest, now, test, imputed, slide, theta, rig, tuning = inputs = self.symbols(*names)
        model, tests = self.patch.torque_model, innovation_test_outputs(self.measurement_model)
        result = named(tests, test)
        memory = model.memory_layout.join(memory_with_slide_only(self.patch, slide))
        sample = StepSample(
            model=model, measurement_model=self.measurement_model, now=now, imputed=imputed,
            theta=theta, rig=rig, tuning=tuning,
        )  # fmt: skip
        unsettled = has_not_converged(self.measurement_model, x, newest, P)
        output = sample.output(x, P, memory, result["expected"], result, unsettled=unsettled)
        return function_of_symbols("step_output", inputs, result=output)
