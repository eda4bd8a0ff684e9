"""The state before the first sample as a casadi Function of that sample, for a target to begin with."""

from dataclasses import dataclass
from typing import Any

import casadi as ca

from observers.base import ModelObserver, constants_size, split_constants
from observers.layout import Layout
from observers.measurement_model import CLEAN, is_known
from observers.mhe import Mhe
from observers.protocol import SAMPLE
from symbolic import SIGNALS, full_slide_torque

Expression = Any


@dataclass(frozen=True)
class _First:
    """What a prior may ask of the first sample, as expressions."""

    psi: Expression
    psi_dot: Expression
    F_N: Expression
    dt: Expression


def build_start(observer: ModelObserver, layout: Layout | None = None) -> ca.Function:
    """(sample, constants) -> state: `observer.init` for any first sample with a known psi and F_N > 0 N.

    What depends on neither stands in it as numbers; sample and constants are those of
    `ModelObserver.function`.

    Args:
        observer: the observer.
        layout: of another state, where the memory is not the model's and begins as zeros.
    """
    sample, constants = (
        ca.MX.sym("sample", len(SAMPLE)),
        ca.MX.sym("constants", constants_size(observer.model)),
    )
    theta, rig, _ = split_constants(observer.model, constants)
    given = dict(zip(SAMPLE, ca.vertsplit(sample), strict=True))
    rate = ca.if_else(is_known(given["psi_dot"]), given["psi_dot"], 0)
    first: Any = _First(psi=given["psi"], psi_dot=rate, F_N=given["F_N"], dt=given["dt"])
    prior = observer.measurement_model.prior(
        observer.tuning, first, full_slide_torque(first.F_N, rig[0])
    )
    mean, std = (ca.vertcat(*(prior[name][i] for name in observer.states)) for i in range(2))
    signals = [getattr(first, name) for name in SIGNALS]
    held_at = ca.DM([observer.tuning.mu, 1.0])[: 1 + ("stiffness" in observer.states)]
    last = _column(CLEAN, first)
    parts: dict[str, Expression] = {
        "held_at": held_at,
        "x": mean,
        "factor": ca.diag(std**2),
        "last": last,
        "said": ca.DM([observer.tuning.mu, observer.tuning.mu_std, float("nan"), 0]),
    }
    if isinstance(observer, Mhe):
        # The rows of a window's samples go on behind those of a cleaned one.
        rows = observer.layout.places["samples"][1][0]
        parts |= {
            "turned": ca.vertcat(first.psi, 0),
            "seen": _column(SIGNALS, first),
            "samples": ca.vertcat(last, ca.DM(rows - len(CLEAN), 1)),
            "mean": mean,
            "P_newest": ca.diag(std**2),
        }
    if layout is None:
        parts["memory"] = observer.model.initial(ca.vertcat(*signals), theta, rig[:2])
    state = _filled(layout or observer.layout, parts)
    return ca.Function("start", [sample, constants], [state], ["sample", "constants"], ["state"])


def _column(names: tuple[str, ...], first: _First) -> Expression:
    """The angle and the load by name, 0 for everything else."""
    return ca.vertcat(*(getattr(first, n) if n in ("psi", "F_N") else 0 for n in names))


def _filled(layout: Layout, parts: dict[str, Expression]) -> Expression:
    """All parts; one column stands for every one, nothing for zeros."""
    whole = {}
    for name, rows, columns in layout.fields:
        part = ca.MX(parts.get(name, ca.DM(rows, columns)))
        whole[name] = ca.densify(ca.repmat(part, 1, columns // part.shape[1]))
    return layout.join(whole)
