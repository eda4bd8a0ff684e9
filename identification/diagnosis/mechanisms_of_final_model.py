"""The mechanisms of a final model: families of its effects, with curves and their bands."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import prod

import casadi as ca
import numpy as np

from identification.diagnosis.result_parts import Curve, FoundEffect, FoundFamily
from identification.fits.covariance import covariance
from identification.fits.fitting import Fit
from identification.fits.least_squares_problem import owner_and_name
from identification.fits.values_by_ground_and_recording import replaced_rig
from identification.reading.recordings import Recording
from identification.selection.trial import RANKING, model_of
from symbolic import Effect, Expression, Model, Signals, parameter_name, simulate
from symbolic.bristle_patch import BristleTraits
from symbolic.bristle_slip import REST_SPEED, log_creep_factor
from symbolic.float_array_type import Array

POINTS = 60
"""Points of a curve, and of each leg of a loop."""


def families_with_curves(
    found: Sequence[FoundEffect], fitted: Fit, training: Sequence[Recording]
) -> tuple[FoundFamily, ...]:
    """Families of the effects found, in order; a curve is that of the recording of median error."""
    by_name = {effect.name: effect for effect in fitted.model.effects}
    sizes = [float(np.nanstd(fitted.residuals[r.name])) for r in training]
    recording = training[int(np.argsort(sizes)[(len(sizes) - 1) // 2])]
    groups: dict[str, list[FoundEffect]] = {}
    for one in found:
        groups.setdefault(one.family, []).append(one)
    families = []
    for name, members in groups.items():
        effects = tuple(by_name[member.name] for member in members)
        drawn = _FamilyModel(fitted, training, recording, effects)
        names = tuple(member.name for member in members)
        rivals = dict.fromkeys(r for m in members for r in m.indistinguishable_from if r not in names)
        curve = _CURVES[name](drawn) if name in _CURVES else None
        families.append(FoundFamily(name=name, effects=names, rivals=tuple(rivals), curve=curve))
    return tuple(families)


@dataclass(frozen=True)
class _FamilyModel:
    """A family's effects alone beside the declared model, with the final values of one recording."""

    fitted: Fit
    training: Sequence[Recording]
    recording: Recording
    effects: tuple[Effect, ...]

    @cached_property
    def values(self) -> Mapping[str, float]:
        """Every value of the final model for the recording."""
        return self.fitted.values.of(self.recording)

    @cached_property
    def model(self) -> Model:
        """The declared model with the family's effects."""
        return model_of(self.effects, RANKING)

    def theta(self, model: Model) -> Array:
        """The parameter vector of a model of some of the effects."""
        names = [parameter_name(effect, p) for effect, p in model.parameters]
        return np.array(model.coordinate_values({name: self.values[name] for name in names}))

    def std(self, jacobian: Array) -> Array:
        """Standard deviation (n,) of what has this Jacobian by `theta`; inf where it is undetermined."""
        parameters = {parameter_name(e, p): p for e, p in self.fitted.model.parameters}
        names = [parameter_name(e, p) for e, p in self.model.parameters]
        labels = [owner_and_name(name, parameters[name], self.recording) for name in names]
        free = [i for i, label in enumerate(labels) if label in self.fitted.labels]
        columns = [self.fitted.labels.index(labels[i]) for i in free]
        covariances = covariance(self.fitted, self.training)[np.ix_(columns, columns)]
        known = np.isfinite(np.diag(covariances))
        rows, blind = jacobian[:, free][:, known], jacobian[:, free][:, ~known]
        variance = np.einsum("ti,ij,tj->t", rows, covariances[np.ix_(known, known)], rows)
        return np.where((blind != 0).any(axis=1), np.inf, np.sqrt(np.maximum(variance, 0)))


def _friction_curve(
    drawn: _FamilyModel, x: Array, factor: Callable[[ca.MX], Expression], name: str, unit: str
) -> Curve:
    """Friction: mu times a factor that depends on theta, at places x."""
    theta = drawn.model.input_symbols()[1]
    law = theta[0] * factor(theta)
    both = ca.Function("law", [theta], [law, ca.jacobian(law, theta)])
    y, jacobian = (np.asarray(part) for part in both(drawn.theta(drawn.model)))
    mu = np.full(x.size, drawn.values["mu"])
    return Curve(
        x_name=name, x_unit=unit, y_name="friction", y_unit="1", x=x, y=y.ravel(),
        std=drawn.std(jacobian), declared=mu,
    )  # fmt: skip


def _friction_over_speed(drawn: _FamilyModel) -> Curve:
    rig, rates = drawn.recording.rig, np.abs(drawn.recording.psi_dot)
    v = np.geomspace(REST_SPEED, (rig.a + abs(rig.e)) * float(rates.max()), POINTS)

    def factor(theta: ca.MX) -> Expression:
        traits = BristleTraits()
        for effect, values in drawn.model.values_by_effect(theta):
            traits = effect.traits(traits, values)
        creeping = 1 if traits.creep is None else log_creep_factor(ca.DM(v), traits.creep)
        return creeping * prod(limit(ca.DM(v)) for limit in traits.limits)

    return _friction_curve(drawn, v, factor, "sliding speed", "m/s")


def _friction_over_load(drawn: _FamilyModel) -> Curve:
    F_N = np.linspace(float(drawn.recording.F_N.min()), float(drawn.recording.F_N.max()), POINTS)
    signals = Signals(psi=0, psi_dot=0, F_N=ca.DM(F_N), dt=1)

    def factor(theta: ca.MX) -> Expression:
        return prod(
            effect.friction(signals, ca.DM(), own) for effect, own in drawn.model.values_by_effect(theta)
        )

    return _friction_curve(drawn, F_N, factor, "vertical load", "N")


def _torque_over_angle(drawn: _FamilyModel) -> Curve:
    """Torque of a turn from rest to the largest angle, and back to the same on the other side."""
    recording = replaced_rig(drawn.recording, drawn.fitted.values)
    span, rate = float(np.abs(recording.psi).max()), float(np.quantile(np.abs(recording.psi_dot), 0.75))
    psi = np.concatenate([np.linspace(0, span, POINTS), np.linspace(span, -span, 2 * POINTS)[1:]])
    turn = np.diff(psi, prepend=psi[0])
    dt = np.full(psi.size, span / (POINTS - 1) / rate)
    signals = np.vstack([psi, np.sign(turn) * rate, np.full(psi.size, recording.F_N.mean()), dt])
    geometry = np.array([recording.rig.a, recording.rig.e])
    with_them, without = (
        simulate(model, signals, theta, geometry, np.eye(theta.size))
        for model in (drawn.model, model_of((), RANKING))
        for theta in [drawn.theta(model)]
    )
    return Curve(
        x_name="yaw angle", x_unit="rad", y_name="aligning torque", y_unit="N m", x=psi,
        y=with_them.M_z, std=drawn.std(with_them.sensitivities), declared=without.M_z,
    )  # fmt: skip


_CURVES: Mapping[str, Callable[[_FamilyModel], Curve]] = {
    "friction over speed": _friction_over_speed,
    "friction over load": _friction_over_load,
    "compliance and contact shape": _torque_over_angle,
}
"""By family."""
