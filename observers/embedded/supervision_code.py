"""Supervision in C: the Functions of `observers.quality.acquisition` around an estimator.

C loops over the hypotheses and calls one Function for each; `templates/supervision.c` is the glue.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import casadi as ca

from observers.embedded.casadi_c import EmbeddedCode
from observers.embedded.compact_bristles import has_bristles
from observers.embedded.constants import Constants, Tunable
from observers.embedded.scalar_type import Real
from observers.embedded.templating import Body, render
from observers.estimators.model_observer import ModelObserver
from observers.layout import Layout, named
from observers.measurement.measurement_model import LEAST_LOAD, RIG
from observers.protocol import OUTPUT, SAMPLE
from observers.quality import acquisition, branches, hypotheses, supervision
from observers.quality.equivalent_patch import equivalent_patch
from observers.tuning import TUNING_FIELDS


def supervision_functions(observer: ModelObserver, tunable: Tunable) -> list[ca.Function]:
    """The Functions that C calls beside those of the estimator; none without supervision."""
    if not observer.acquire:
        return []
    functions = [
        branches.build_track().expand("follow_turns", {"cse": True}),
        branches.build_turn(),
        branches.build_branch(),
        hypotheses.build_hypothesis(),
        hypotheses.build_error(),
        hypotheses.build_verdict().expand("verdict_of", {"cse": True}),
        supervision.build_tracking(),
        acquisition.build_conclusion(
            equivalent_patch(observer.model, observer.values, observer.rig),
            is_scaled=bool(observer.measurement_model.scaled),
        ),
    ]
    return [*functions, _observe_torque(observer, tunable)]


def supervised(
    observer: ModelObserver, real: Real, terms: Mapping[str, Any], body: Body, code: EmbeddedCode,
    parts: Layout | None,
) -> Body:  # fmt: skip
    """The code of an estimator with its supervision; as it is where that is switched off.

    Args:
        observer: the observer.
        real: the type.
        terms: values of the placeholders that all templates share.
        body: code of the estimator alone.
        code: C of the Functions, those of `supervision_functions` among them.
        parts: of its state where that is one vector; None for a window.
    """
    if not observer.acquire:
        return body
    values = {**terms, **_terms(observer, terms, parts), **_handover_terms(observer, parts)}
    values |= {
        "verdict_arg": code.arg, "verdict_res": code.res, "verdict_work": max(code.w, 1),
        "verdict_integers": max(code.iw, 1), "ratios": [real.literal(r) for r in hypotheses.RATIOS],
    }  # fmt: skip
    values["hand_over"] = render("hand_over.c", values)
    sizes = {
        "own": len(acquisition.OWN), "verdict": len(hypotheses.VERDICT),
        "block": len(observer.measurement_model.torque_state),
        "track": len(branches.TRACK), "points": branches.POINTS, "result": len(OUTPUT),
    }  # fmt: skip
    fields = ", ".join(f"{name}[{size}]" for name, size in sizes.items() if size)
    rows, columns = len(hypotheses.RATIOS), len(hypotheses.PER_HYPOTHESIS)
    return replace(
        body,
        stepping=f"{body.stepping}\n{render('supervision.c', values)}",
        private=f"{body.private}\n    {real.c_type} {fields}; /* of the supervision */\n"
        f"    {real.c_type} hypotheses[{rows}][{columns}];",
        bytes=body.bytes + (sum(sizes.values()) + rows * columns) * real.size,
        supervised=True,
        scaled=bool(observer.measurement_model.scaled),
    )


def _renamed(name: str, function: ca.Function) -> ca.Function:
    """The same Function under a name that no other function of the file has."""
    inputs = [ca.MX.sym(function.name_in(i), *function.size_in(i)) for i in range(function.n_in())]
    outputs = function.call(inputs, True, False)
    return ca.Function(name, inputs, outputs, function.name_in(), function.name_out())


def _observe_torque(observer: ModelObserver, tunable: Tunable) -> ca.Function:
    """(block, sample, again) -> (block_next, psi, M_z, added, limits)."""
    model = observer.measurement_model
    block, sample = ca.SX.sym("block", len(model.torque_state)), ca.SX.sym("sample", len(SAMPLE))
    rig, tuning = ca.SX.sym("rig", len(RIG)), ca.SX.sym("tuning", len(TUNING_FIELDS))
    after, *rest = model.observed_torque(
        named(model.torque_state, block), named(SAMPLE, sample), rig, tuning
    )
    patch = equivalent_patch(observer.model, observer.values, observer.rig)
    again = ca.SX.sym("again")
    limits = hypotheses.limits_of(named(TUNING_FIELDS, tuning), patch.misfit, again)
    function = ca.Function(
        "observe_torque", [block, sample, again, rig, tuning],
        [ca.vertcat(*(after[name] for name in model.torque_state)), *rest, limits],
        ["block", "sample", "again", "rig", "tuning"], ["block_next", "psi", "M_z", "added", "limits"],
    )  # fmt: skip
    return Constants(observer, tunable).fill("observe_torque", function)


def _terms(observer: ModelObserver, terms: Mapping[str, Any], parts: Layout | None) -> dict[str, Any]:
    """Values of the placeholders of `templates/supervision.c`; C of the constants that it reads."""
    patch = equivalent_patch(observer.model, observer.values, observer.rig)
    begin = len(observer.model.coordinates)
    places = {"k": observer.model.coordinates.index("k")}
    places |= {name: begin + i for i, name in enumerate(RIG)}
    places["zero_std"] = begin + len(RIG) + TUNING_FIELDS.index("zero_std")
    numbers = observer.constants.tolist()
    literal = {name: repr(float(numbers[at])) for name, at in places.items()}
    if terms["tunable"]:
        tuned = places if terms["tunable"] == "all" else ("zero_std",)
        literal |= {name: f"state->constants[{places[name]}]" for name in tuned}
    states = observer.states
    x = "state->x[state->newest]["
    x = x if parts is None else f"state->values[state->now][{parts.places['x'][0].start} + "
    return {
        "own": acquisition.OWN, "track": branches.TRACK, "parts": hypotheses.PER_HYPOTHESIS,
        "points": branches.POINTS, "verdict": len(hypotheses.VERDICT),
        "block": len(observer.measurement_model.torque_state),
        "vague": repr(hypotheses.VAGUE), "slid": repr(hypotheses.SLID), "least_load": repr(LEAST_LOAD),
        "restart_std": repr(hypotheses.RESTART_STD),
        "a": literal["a"], "limits": len(hypotheses.LIMITS),
        "tyre": [f"{literal['k']} * {patch.stiffness!r}", literal["a"], literal["e"]],
        "zero_std": _zero_std(observer, literal),
        "zero_limit": hypotheses.LIMITS.index("zero_std"),
        "noise_limit": hypotheses.LIMITS.index("psi_noise"),
        "error_limit": hypotheses.LIMITS.index("error"),
        "zero_state": f"{x}{states.index('M_0')}]" if "M_0" in states else "0.0",
    }  # fmt: skip


def _zero_std(observer: ModelObserver, literal: Mapping[str, str]) -> str:
    """C of the deviation of the torque's zero before the first sample [N m]."""
    return (
        f"{literal['zero_std']} * slide"
        if observer.rig.zero_std is None
        else repr(observer.rig.zero_std)
    )


def _handover_terms(observer: ModelObserver, parts: Layout | None) -> dict[str, Any]:
    """Values of the placeholders of `templates/hand_over.c`."""
    handed = [
        {"index": observer.states.index(name), "at": at}
        for name, at in (("log_mu", 0), ("M_0", 2))
        if name in observer.states
    ]
    places = {} if parts is None else {name: at.start for name, (at, _) in parts.places.items()}
    return {
        "handed": handed, "bristles": has_bristles(observer),
        "states": len(observer.states),
        "window": getattr(observer, "window", 0) if parts is None else 0,
        **{name: places.get(name, 0) for name in ("x", "factor", "counts", "monitor", "output")},
    }  # fmt: skip
