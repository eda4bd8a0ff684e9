"""The two networks of [Györök 2022]: their inputs and their training."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from brushgrip.comparison.cases import Case
from brushgrip.comparison.methods import Method
from identification import Recording
from identification.thesis import Activation, Design, FrictionNetwork, label_mean, train
from observers import ZoneHistory, ZoneRootSolver, run, zone_history
from symbolic.array_alias import Array

ANALYTIC = 9
"""Column of `all_inputs` that holds the analytic estimate of mu."""
MIN_REVERSAL = 5e-4
"""Least turn back that is taken for a reversal [rad], as in `observers.ZoneRootSolver`."""


def angle_and_torque_inputs(recording: Recording) -> Array:
    """Inputs of the neural network of [Györök 2022], section 4.1: psi, psi_max and M, shape (n, 3).

    M is -M_z, as in the files published with it; where it is missing, the last value is imputed.
    """
    last_measured = np.maximum.accumulate(
        np.where(np.isfinite(recording.M_z), np.arange(recording.t.size), 0)
    )
    M = np.nan_to_num(-recording.M_z[last_measured])
    return np.column_stack([recording.psi - recording.psi[0], _zones(recording).psi_max, M])


def all_inputs(recording: Recording) -> Array:
    """Inputs of the network of [Györök 2022], section 4.2, shape (n, 10).

    psi, psi_max, M, e, F_N, direction, five zones or three, a, k and the analytic estimate of mu.
    """
    rig, k, history = recording.rig, recording.tyre.k, _zones(recording)
    # The root solver takes missing torques as they are.
    analytic = run(
        ZoneRootSolver(rig=rig, k=k), recording.t, recording.psi, recording.F_N, recording.M_z
    )
    constant = [np.full(recording.t.size, value) for value in (rig.e, rig.a, k)]
    return np.column_stack([
        angle_and_torque_inputs(recording),
        constant[0],
        recording.F_N,
        history.direction,
        history.zones == 5,
        *constant[1:],
        analytic.mu,
    ])  # fmt: skip


def neural_network(recordings: Sequence[Recording], design: Design | None = None) -> FrictionNetwork:
    """The neural network of [Györök 2022], section 4.1, trained on recordings with a declared mu."""
    return train(recordings, angle_and_torque_inputs, design, name="neural network")


def corrected_root(recordings: Sequence[Recording], design: Design | None = None) -> FrictionNetwork:
    """Root solve with a correcting network: scientific machine learning, [Györök 2022], section 4.2.

    Args:
        recordings: training data.
        design: network and training; the activation is always tanh, the best in section 4.2. None for
            the defaults.
    """
    tanh = replace(design or Design(), activation=Activation.TANH)
    return train(recordings, all_inputs, tanh, base=ANALYTIC, name="root and network")


def trained_methods(training: Sequence[Case]) -> list[Method]:
    """The networks of [Györök 2022] trained on these cases, and the mean that a method has to beat."""
    labelled = [
        replace(case.recording, tyre=replace(case.recording.tyre, mu=case.declared)) for case in training
    ]
    return [neural_network(labelled), corrected_root(labelled), label_mean(labelled)]


def _zones(recording: Recording) -> ZoneHistory:
    """Angles of the last reversals and zones, counted from the first sample."""
    return zone_history(recording.psi - recording.psi[0], MIN_REVERSAL)
