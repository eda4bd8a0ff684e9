"""A hand-made diagnosis and its parts."""

from collections.abc import Sequence
from dataclasses import fields, replace
from typing import Any

import numpy as np

from brushgrip.estimation.friction_by_both_models import EKF_FOUND, FrictionByBothModels
from brushgrip.estimation.observe_recording import FrictionTrack
from identification.diagnosis.result import Diagnosis
from identification.diagnosis.result_parts import (
    Candidate,
    Curve,
    FoundEffect,
    FoundFamily,
    Series,
    TorqueErrors,
)
from identification.experiments.manoeuvre_in_recorded_range import SampledManoeuvre
from identification.experiments.model_separation import Proposal
from identification.fits.values_by_ground_and_recording import ParameterEstimate, Values
from identification.residuals.partial_correlations import Autocorrelation, SignalCorrelation, Signatures
from identification.residuals.residual_signals import RESIDUAL_SIGNALS, effects_with_signature
from identification.residuals.residual_structure import Unexplained
from observers import Estimates, SelfConsistency, Status
from symbolic import EFFECTS, Model, effects_named


def make_estimates(status: Sequence[int] | np.ndarray, **columns: np.ndarray) -> Estimates:
    """Estimates every 10 ms with these flags; what is not given is 1, and informed and usable."""
    size = len(status)
    usual = {field.name: np.ones(size) for field in fields(Estimates)} | {
        "t": 0.01 * np.arange(size), "status": np.array(status, dtype=np.int64),
        "informed": np.ones(size, dtype=bool), "usable": np.ones(size, dtype=bool),
    }  # fmt: skip
    return Estimates(**(usual | columns))


def rising(*status: Status, std: float = 0.02, off: float = 0.0, last: int | None = None) -> Estimates:
    """Friction that rises from 1 to 1.25; usable in the second half, to the sample `last`."""
    size, places, mu = len(status), np.arange(len(status)), np.linspace(1.0, 1.25, len(status))
    usable = (places >= size / 2) & (places <= (size if last is None else last))
    return make_estimates(
        status, mu=mu, mu_eff=mu + off, mu_std=np.full(size, std), mu_eff_std=np.full(size, 2 * std),
        M_z_predicted=np.zeros(size), informed=places >= size / 2, usable=usable,
    )  # fmt: skip


def _series(name: str, number: int, held_out: bool) -> Series:
    noise = np.random.default_rng(number).normal(0, 0.08, 600)
    t = np.arange(600) * 0.02
    psi = (0.2 + 0.03 * number) * np.sin(1.1 * t) * np.cos(0.31 * t + number)
    true = -8 * np.tanh(9 * (psi + 0.05 * np.cos(1.1 * t)))
    measured = true + noise
    measured[100:110] = np.nan
    modelled = {"before": true + 0.5 * np.sin(2 * t), "after": true + 0.1 * np.sin(2 * t)}
    torques = {"measured": measured, **modelled}
    return Series(name=name, held_out=held_out, t=t, psi=psi, F_N=np.full(600, 400.0), **torques)


def _errors(shares: dict[str, float], training: tuple[str, ...]) -> TorqueErrors:
    rmse = {name: 16 * share for name, share in shares.items()}
    holdout = tuple(name for name in shares if name not in training)
    left_out = shares if len(training) == len(shares) > 1 else {}
    errors = {"rmse": rmse, "nrmse": shares, "left_out": left_out}
    return TorqueErrors(training=training, holdout=holdout, **errors)


def signatures(strength: float, band: float = 0.3) -> Signatures:
    """Every signal with the same correlation, the even ones against it."""
    lags = 0.01 * np.arange(1, 101)
    alike = {"band": band, "slope": 1.0, "size": 0.01 * strength}
    each = []
    for number, signal in enumerate(RESIDUAL_SIGNALS):
        own = {"signal": signal.name, "unit": signal.unit, "reading": signal.positive_cause}
        own["effects"] = effects_with_signature(signal, 1, EFFECTS.values())
        each.append(SignalCorrelation(correlation=strength * (-1) ** number, **own, **alike))
    autocorrelation = Autocorrelation(lags=lags, values=np.exp(-lags), band=0.04, memory=0.5)
    found = {"signatures": tuple(each), "followed": tuple(each[:1]) if strength > 0.3 else ()}
    return Signatures(rms=0.01, autocorrelation=autocorrelation, **found)


def experiment(load: float = 0.0, instruction: str = "sweep to and fro, 10 s") -> Proposal:
    """A proposed experiment, whose load changes by so much to either side [N]."""
    t = np.arange(500) * 0.02
    turned = {"psi": np.sin(t), "psi_dot": np.cos(t), "F_N": 400 + load * np.sign(np.sin(t))}
    torques = {"torque": 5 * np.sin(t), "rival_torque": 5 * np.sin(t) + 0.1 * np.cos(t)}
    told = {"separation": 0.01, "now": 0.002, "noise": 0.004, "times": 1, "standard_errors": 5.0}
    manoeuvre = SampledManoeuvre(instruction=instruction, t=t, **turned)
    return Proposal(found="carcass_torsion", rival="patch_width", manoeuvre=manoeuvre, **torques, **told)


def _effects() -> tuple[FoundEffect, ...]:
    k_t = ParameterEstimate(value=391.234, std=4.2, unit="N m/rad")
    torsion = {"parameters": {"k_t": k_t}, "holdout_nrmse_after": 0.03, "delta_bic": -412.3}
    torsion |= {"indistinguishable_from": ("patch_width",), "experiment": experiment()}
    M_0 = ParameterEstimate(value=-0.12, std=None, unit="N m")
    offset = {"parameters": {"M_0 [train_a]": M_0}, "holdout_nrmse_after": 0.023, "delta_bic": -55.1}
    offset |= {"indistinguishable_from": ()}
    found = {"carcass_torsion": ("compliance and contact shape", torsion)}
    found |= {"torque_offset": ("sensor and steering", offset)}
    return tuple(
        FoundEffect(name=name, summary=EFFECTS[name].summary, family=family, **values)
        for name, (family, values) in found.items()
    )


def make_diagnosis(
    training: tuple[str, ...] = ("train_a", "train_b"),
    holdout: tuple[str, ...] = ("held_c", "held_d", "held_e"),
    *,
    found: bool = True,
    unexplained: bool = True,
    worse: tuple[str, ...] = (),
) -> Diagnosis:
    """A diagnosis without any estimation; `worse` names recordings that got worse."""
    names = (*training, *holdout)
    before = {name: 0.04 + 0.001 * i for i, name in enumerate(names)}
    final = {n: (share + 0.01 if n in worse else 0.55 * share) for n, share in before.items()}
    after = final if found else before
    effects = _effects() if found else ()
    candidates = tuple(
        Candidate(name=n, summary=e.summary, holdout_nrmse=0.03 + 0.001 * i, delta_bic=-400.0 + 30 * i)
        for i, (n, e) in enumerate(EFFECTS.items())
    )
    k_t = {"carcass_torsion.k_t": 391.234} if found else {}
    evidence = {"evidence": "follows psi_dot <by> 0.4 & F_N", "structured": 0.012}
    return Diagnosis(
        recordings=training,
        holdout=holdout,
        declared=_errors({name: 1.6 * share for name, share in before.items()}, training),
        before=_errors(before, training),
        after=_errors(after, training),
        effects=effects,
        candidates=candidates,
        unexplained=Unexplained(present=unexplained, **evidence),
        parameters={
            "k": ParameterEstimate(value=2.4312e6, std=1.2e4, unit="N/m^2"),
            **{f"mu [{n}]": ParameterEstimate(value=1.3, std=0.012, unit="1") for n in names},
            "carcass_torsion.k_t": ParameterEstimate(value=391.234, std=4.2, unit="N m/rad"),
        },
        signatures_before=signatures(0.8),
        signatures_after=signatures(0.1),
        model=Model(effects=effects_named([effect.name for effect in effects])),
        values=Values(tyre={"k": 2.4312e6, **k_t}, own={name: {"mu": 1.3} for name in names}),
        series=tuple(_series(name, i, name in holdout) for i, name in enumerate(names)),
        families=_families() if found else (),
        notes=tuple(f"{name} got worse" for name in worse),
    )


def _consistency(settling: float) -> SelfConsistency:
    return SelfConsistency(
        mu_eff=1.0, mu_eff_std=0.1, settling=settling, drift=0.1, coverage=1.0, relative_band=0.1,
        reference_coverage=settling / 10,
    )  # fmt: skip


def make_outcome(*holdout: str, **changes: Any) -> FrictionByBothModels:
    """Figures of friction of the recordings a, b, c and d."""
    before = {name: _consistency(s) for name, s in (("a", 1.0), ("b", 2.0), ("c", 6.0), ("d", 8.0))}
    after = {name: _consistency(1.0) for name in before}
    usual = {"before": before, "after": after, "grounds": {"": tuple(before)}, "holdout": holdout}
    return FrictionByBothModels(**(usual | changes))


def _track(name: str, usable: slice, value: float, status: Status = Status.USED) -> FrictionTrack:
    """Friction that ends at 9, but for the samples that are usable."""
    t = np.linspace(0.0, 10.0, 11)
    known = np.zeros(11, dtype=bool)
    known[usable] = True
    mu = np.where(known, value, 9.0)
    return FrictionTrack(
        name=name, label=EKF_FOUND, t=t, mu=mu, mu_std=np.full(11, 0.05), usable=known,
        usable_share=float(known.mean()), last_status=status,
    )  # fmt: skip


TRACKS = (
    _track("a", slice(5, None), 1.2),
    _track("b", slice(5, 8), 1.1, Status.INCONSISTENT | Status.HELD),
    _track("c", slice(0, 0), 1.0, Status.ACQUIRING),
    _track("d", slice(0, 0), 1.0),
)
"""Of these recordings: usable to the end, usable for a while, and twice never."""


def make_track(name: str, mu: float = 1.2, **changes: Any) -> FrictionTrack:
    """The first of them under another name, of one friction from the beginning to the end."""
    return replace(TRACKS[0], name=name, mu=np.full(11, mu), **changes)


def _families() -> tuple[FoundFamily, ...]:
    """A loop with a band of which one end is unknown, and a mechanism without a curve."""
    psi = np.array([0.0, 0.2, 0.4, 0.0, -0.4])
    torque = np.array([0.0, -5.0, -7.0, 4.0, 7.0])
    std = np.array([0.0, 0.1, 0.1, 0.1, np.inf])
    curve = Curve(
        x_name="yaw angle", x_unit="rad", y_name="aligning torque", y_unit="N m", x=psi, y=torque,
        std=std, declared=1.1 * torque,
    )  # fmt: skip
    names = ("compliance and contact shape", "sensor and steering")
    return tuple(
        FoundFamily(name=name, effects=(effect.name,), rivals=(), curve=drawn)
        for name, effect, drawn in zip(names, _effects(), (curve, None), strict=True)
    )
