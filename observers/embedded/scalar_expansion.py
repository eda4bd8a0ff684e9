"""Functions of scalars: parameters as numbers, exponentials that are known, and their C."""

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import inf
from typing import Any, Literal

import casadi as ca

from observers.embedded.scalar_type import Real
from observers.estimators.model_observer import ModelObserver
from observers.layout import outputs_of
from observers.measurement.measurement_model import RIG
from observers.patch.patch_protocol import EQUIVALENT
from observers.tuning import TUNING_FIELDS
from symbolic.compilation.scalar_c import Comments, c_function
from symbolic.named_and_buffered_functions import named_function

Tunable = Literal["", "tuning", "all"]
"""What generated code takes at run time: nothing, the tuning, or model, rig and tuning."""
VECTORS = frozenset({"x", "mean", "factor", "P", "costate", "newest", "slopes", "own"})
"""Inputs that are vectors in C even where they have one element, as an estimator of one state has."""

BETWEEN: Mapping[str, Sequence[str]] = {
    "predicted_x": (), "predicted_factor": (),
    "innovation": ("innovation: measured less expected torque or angle; 0 without a measurement",),
    "innovation_variance": ("variance of the innovation",),
    "accepted": ("accepted by the gate, or a reset",), "reset": ("the ground has changed",),
}  # fmt: skip
"""Outputs of a filter's step that are steps between, with comments on their elements."""
SECTIONS = {
    "predicted_x": "Predict: the states at the sample, and the factor of their covariance.",
    "innovation": "Innovation, with its variance.",
    "accepted": "Gate: an outlier is left out, several in a row are another ground.",
    "x_next": "Update of the states, within their bounds, and of their factor.",
    "last_next": "What the next sample needs.",
    "result": "Output.",
}
"""Titles of the steps, before the first statement of each."""

ABOUT = {
    "clean": "The sample with missing values imputed.",
    "patch_signals": "What reaches the patch: angle, rate, load, time.",
    "filter": "Prediction, innovation, gate, update; exp(x[log_mu]) before the sample is mu.",
    "ekf_step": "A sample: prediction, patch, innovation and gate, update, output.",
    "motion": "Prediction: the states at the sample, their derivatives A, the variances Q of a walk.",
    "predict_covariance": "Prediction of the factor U D U' of the covariance.",
    "patch_update": "The patch after a sample: memory, M_z and its slopes.",
    "innovation": "Innovation, its variance, gate and monitor.",
    "gate": "An outlier is left out, several in a row are another ground.",
    "monitor": "Whether the innovations drift to one side, or are larger than their variance.",
    "update_covariance": "Update of the factor U D U' by a measurement, and the gain.",
    "retentions": "Shares of the memory's derivative by mu that a walk of mu and a new ground leave.",
    "predict": "Prediction to the sample.",
    "test_innovation": "Innovation and gate.",
    "accept": "Acceptance of a sample of the window after the gate.",
    "reset_arrival": "What a new ground before the window adds to the variance of ln mu.",
    "forward": "Update by a sample of the window, and prediction to the next.",
    "backward": "Back substitution of a sample of the window.",
    "limit": "States within their bounds.",
    "step_output": "Friction, effective friction and status.",
    "observe_torque": "Aligning torque without a model of it.",
    "added_torque": "What effects add to the torque of the patch.",
    "follow_turns": "The branch of the path, and the points at which the wheel turned back.",
    "new_ground": "The branches on a ground that has changed.",
    "hypothesis": "One hypothesis after a torque.",
    "verdict_of": "What all hypotheses say together.",
    "scale_excess": "What the scale of the torque adds to the deviation of friction.",
    "conclude": "Output and handover while friction is acquired.",
    "follow_output": "Output while the estimator tracks.",
}
"""Purpose of a Function, as a comment of the C."""


def expand_with_constants(
    name: str, function: ca.Function, numbers: Mapping[str, Any], *, last: ca.SX | None = None
) -> ca.Function:
    """A Function with some inputs as numbers, expanded to scalar operations, each done once.

    `numbers` has the elements of an input by its name: numbers, or expressions of `last`, a further
    input of the result, `constants`. Infinite parameters enter as 1/ε with ε = 0 after simplification,
    so that terms divided by them vanish. Outputs are dense columns.
    """
    names = [n for n in function.name_in() if n not in numbers]
    symbols = {n: ca.SX.sym(n, *function.size_in(n)) for n in names}
    epsilon = ca.SX.sym("epsilon")
    given = {n: _replace_infinity_by_epsilon(values, epsilon) for n, values in numbers.items()} | symbols
    outputs = function.expand().call([given[n] for n in function.name_in()])
    flat = ca.substitute(outputs, [epsilon], [ca.SX(0)])
    inputs = symbols if last is None else symbols | {"constants": last}
    columns = [ca.densify(ca.vec(output)) for output in flat]
    return named_function(name, inputs, dict(zip(function.name_out(), columns, strict=True)), cse=True)


@dataclass(frozen=True)
class ConstantSubstitution:
    """Puts constants into Functions of scalars: numbers in the code, or a vector of the state.

    Constants are theta, rig, tuning and `EQUIVALENT`, one after another. With parameters at run time C
    keeps all of them in its state, whichever of them are numbers in the code none the less.
    """

    observer: ModelObserver  # Whose constants they are.
    tunable: Tunable = ""  # Which of them C reads at run time.
    # Places in the observer's theta that the Functions take; None for all.
    theta: Sequence[int] | None = None

    def substitute_constants(self, name: str, function: ca.Function) -> ca.Function:
        """A Function of scalars without the inputs `constants`, `theta`, `rig`, `tuning`.

        Where something is taken at run time, the last input is the vector of all constants, used or not.
        """
        parts, last = self._constants_by_input()
        used = {given: parts[given] for given in function.name_in() if given in parts}
        return expand_with_constants(name, function, used, last=last)

    def _constants_by_input(self) -> tuple[dict[str, list[Any]], ca.SX | None]:
        numbers: list[Any] = self.observer.constants.tolist()
        last = ca.SX.sym("constants", len(numbers)) if self.tunable else None
        values = numbers if last is None else ca.vertsplit(last)
        rig = len(self.observer.model.coordinate_names)
        tuning = rig + len(RIG)
        if self.tunable == "tuning":
            values = [*numbers[:tuning], *values[tuning:]]
        theta = values[:rig] if self.theta is None else [values[i] for i in self.theta]
        after = values[tuning : tuning + len(TUNING_FIELDS)]
        parts = {"theta": theta, "rig": values[rig:tuning], "tuning": after}
        patch = numbers[-len(EQUIVALENT) :]
        return parts | {"constants": [*theta, *parts["rig"], *after, *patch]}, last


def _replace_infinity_by_epsilon(values: Iterable[Any], epsilon: ca.SX) -> ca.SX:
    return ca.vertcat(*(1 / epsilon if isinstance(v, float) and v == inf else v for v in values))


def with_exponential_input(function: ca.Function, exponent: tuple[str, int], known: str) -> ca.Function:
    """The same Function of scalars, where exp of an element of an input is another input."""
    inputs = [ca.SX.sym(function.name_in(i), *function.size_in(i)) for i in range(function.n_in())]
    outputs = [ca.SX(function.sparsity_out(i)) for i in range(function.n_out())]
    exponential = inputs[function.index_in(known)]
    at_exponent = [function.index_in(exponent[0]), exponent[1]]
    work: dict[int, ca.SX] = {}
    exponents: set[int] = set()
    for k in range(function.n_instructions()):
        operation, at = function.instruction_id(k), function.instruction_input(k)
        to = function.instruction_output(k)
        if operation == ca.OP_OUTPUT:
            outputs[to[0]].nz[to[1]] = work[at[0]]
            continue
        if operation == ca.OP_CONST:
            value = ca.SX(function.instruction_constant(k))
        elif operation == ca.OP_INPUT:
            value = inputs[at[0]].nz[at[1]]
        elif operation == ca.OP_EXP and at[0] in exponents:
            value = exponential
        else:
            operands = [work[i] for i in at]
            value = (ca.SX.unary if len(at) == 1 else ca.SX.binary)(operation, *operands)
        work[to[0]] = value
        exponents.discard(to[0])
        if operation == ca.OP_INPUT and list(at) == at_exponent:
            exponents.add(to[0])
    return ca.Function(
        function.name(), inputs, outputs, function.name_in(), function.name_out(), {"cse": True}
    )


def inputs_used(function: ca.Function) -> frozenset[str]:
    """Names of the inputs that an output of a Function of scalars depends on."""
    outputs = range(function.n_out())
    return frozenset(
        name
        for at, name in enumerate(function.name_in())
        if any(function.jac_sparsity(i, at).nnz() > 0 for i in outputs)
    )


def drop_unused_inputs(function: ca.Function, names: Collection[str]) -> ca.Function:
    """The same Function of scalars without these inputs, on which no output depends."""
    symbols = {name: ca.SX.sym(name, *function.size_in(name)) for name in function.name_in()}
    inputs = {name: symbol for name, symbol in symbols.items() if name not in names}
    return named_function(function.name(), inputs, outputs_of(function, *symbols.values()))


def without_outputs(function: ca.Function, names: Collection[str]) -> ca.Function:
    """The same Function without these outputs."""
    kept = [name for name in function.name_out() if name not in names]
    return function.factory(function.name(), function.name_in(), kept)


def estimator_c(function: ca.Function, real: Real, names: Mapping[str, Sequence[str]]) -> str:
    """C of a Function of scalars of an estimator, by `add_comment_and_own_exp_log`."""
    outputs = [function.name_out(i) for i in range(function.n_out())]
    elements = {
        name: names[_name_without_affix(name)] for name in outputs if _name_without_affix(name) in names
    }
    comments = Comments(elements=elements)
    if function.name() == "filter":
        between = {**BETWEEN, **elements}
        comments = Comments(sections=SECTIONS, elements=between, between=tuple(BETWEEN))
    text = c_function(function.name(), function, real.c_type, VECTORS, comments)
    return add_comment_and_own_exp_log(function, function.name(), text, names)


def add_comment_and_own_exp_log(
    function: ca.Function, name: str, text: str, names: Mapping[str, Sequence[str]]
) -> str:
    """C of a Function with a comment; exp and log are those of `templates/elementary_functions.c`.

    The comment says what it does, and names the elements of vectors, as far as `names` has them.
    """
    sizes = {function.name_in(i): function.numel_in(i) for i in range(function.n_in())}
    sizes |= {function.name_out(i): function.numel_out(i) for i in range(function.n_out())}
    vectors = {_name_without_affix(name): size for name, size in sizes.items()}
    known = [name for name, size in vectors.items() if name in names and len(names[name]) == size]
    legend = "; ".join(f"{vector}: {', '.join(names[vector])}" for vector in known)
    about = [ABOUT.get(name, ""), f"Elements of {legend}." if legend else ""]
    comment = f"/* {' '.join(filter(None, about))} */\n" if any(about) else ""
    return comment + re.sub(r"\b(?:natural_)?(log|exp)\(", r"any_\1(", text)


def _name_without_affix(name: str) -> str:
    """The vector that an output is the next of, the first of, or predicts."""
    return name.removesuffix("_next").removeprefix("first_").removeprefix("predicted_")


def add_function_comments(text: str) -> str:
    """C of CasADi's with a word on each of its functions that has a name here."""

    def add_meaning(line: re.Match[str]) -> str:
        about = ABOUT.get(line[1], "")
        return f"/* {about} {line[1]}:{line[2]} */" if about else line[0]

    return re.sub(r"^/\* (\w+):(.*) \*/$", add_meaning, text, flags=re.MULTILINE)
