"""What effects add to the torque of a patch is not taken for friction while that is acquired."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from observers import Ekf, Estimates, SteeringTorque, causal_rate, run
from reference_rig import RigTyre, constant_friction, make_recording, make_steering_recording
from symbolic import Model, effects_named
from tests.observers.conftest import RIG, K

ADDED = {
    "steering_return": ("stiffness", lambda psi, _, stiffness: -stiffness * psi),
    "contact_damping": ("c", lambda _, psi_dot, c: -c * psi_dot),
    "bearing_friction": ("M_c", lambda _, psi_dot, M_c: -M_c * np.tanh(psi_dot / 0.01)),
}
"""Parameter of an effect, and its torque [N m]."""


def estimates_of(
    made: Any, torque: Any, name: str = "", value: float = 0.0, **settings: Any
) -> Estimates:
    """Estimates of a filter that knows rate friction, of nearly no strength, and a further effect."""
    values = {"k": K, "rate_friction.c": 1e-6}
    if name:
        values |= {f"{name}.{ADDED[name][0]}": value}
    model = Model(effects=effects_named(["rate_friction", *([name] if name else [])]), bristles=40)
    observer = Ekf(model=model, values=values, rig=RIG, **settings)
    return run(observer, made.t, made.psi, made.F_N, **{observer.channel: torque})


@pytest.mark.parametrize("mu", [0.05, 0.8])
@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("steering_return", 6.0),
        ("steering_return", -10.0),
        ("bearing_friction", 0.5),
        ("contact_damping", 1.0),
    ],
)
def test_a_torque_that_the_model_knows_changes_nothing(mu: float, name: str, value: float) -> None:
    made = make_recording(21, mu=mu, k=K, bristles=500, duration=8.0)
    without = estimates_of(made, made.M_z)
    added = ADDED[name][1](made.psi, causal_rate(made.t, made.psi), value)
    estimates = estimates_of(made, made.M_z + added, name, value)

    both = estimates.usable & without.usable
    assert without.usable.mean() > 0.3
    # The noise that a torque shows is taken before.
    assert np.mean(estimates.status == without.status) > 0.98
    np.testing.assert_allclose(estimates.mu[both], without.mu[both], rtol=5e-3)
    np.testing.assert_allclose(estimates.mu_std[both], without.mu_std[both], rtol=0.05)
    predicted = without.M_z_predicted + added
    np.testing.assert_allclose(estimates.M_z_predicted[both], predicted[both], atol=0.02)


def test_one_step_serves_all_rigs_and_values() -> None:
    model = Model(effects=effects_named(["carcass_torsion"]), bristles=40)
    softer, stiffer = (
        Ekf(model=model, values={"k": K, "carcass_torsion.k_t": k_t}, rig=rig)
        for k_t, rig in ((200.0, RIG), (2000.0, replace(RIG, a=1.1 * RIG.a)))
    )

    assert softer.screened_step is stiffer.screened_step
    # The softer carcass looks like a softer patch.
    assert softer.equivalent_patch.stiffness < stiffer.equivalent_patch.stiffness < 1.02
    for observer in (softer, stiffer):
        patch = observer.equivalent_patch
        assert observer.constants[-2:].tolist() == [patch.stiffness, patch.friction]
        assert observer.constant_labels[-2:] == (
            "equivalent patch: stiffness [1]", "equivalent patch: friction [1]",
        )  # fmt: skip


def test_a_spring_beside_the_steering_torque_is_no_friction() -> None:
    made = make_steering_recording(
        5, constant_friction(0.1), tyre=RigTyre(k=K, mu=0.1), duration=6.0, rate=200.0
    )
    measured = {"measurement_model": SteeringTorque()}
    without = estimates_of(made, made.M, **measured)
    estimates = estimates_of(made, made.M - 8.0 * made.psi, "steering_return", -8.0, **measured)

    assert estimates.usable.mean() > 0.9 * without.usable.mean() > 0
    off = np.abs(estimates.mu - 0.1)[estimates.usable]
    assert (off < 3 * estimates.mu_std[estimates.usable]).all()
