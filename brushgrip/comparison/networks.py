"""The source's two networks: what they see of a sample, and how they are trained."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from identification.reading.recordings import Recording
from identification.thesis.friction_network import Activation, Design, FrictionNetwork, train
from observers import ZoneRootSolver, run
from observers.thesis import ZoneState, advance_zones

Array = NDArray[np.float64]
ANALYTIC = 9
"""Column of `all_inputs` that holds the analytic estimate of mu."""
LEAST_TURN = 5e-4
"""Turn back by which a reversal counts [rad], as in `observers.ZoneRootSolver`."""


def plain_inputs(recording: Recording) -> Array:
    """What the neural network of the source's section 4.1 sees: psi, psi_max and M, shape (n, 3).

    M is the torque against the ground, -M_z, as in the source's own files; a missing one is held.
    """
    held = np.maximum.accumulate(np.where(np.isfinite(recording.M_z), np.arange(recording.t.size), 0))
    M = np.nan_to_num(-recording.M_z[held])
    psi_max = [state.psi_max for state in _memories(recording)]
    return np.column_stack([recording.psi - recording.psi[0], psi_max, M])


def all_inputs(recording: Recording) -> Array:
    """What the network of section 4.2 sees, shape (n, 10).

    psi, psi_max, M, e, F_N, direction, five zones or three, a, k and the analytic estimate of mu.
    """
    rig, k, memories = recording.rig, recording.tyre.k, _memories(recording)
    # The analytic estimate hears a missing torque itself.
    found = run(ZoneRootSolver(rig=rig, k=k), recording.t, recording.psi, recording.F_N, recording.M_z)
    constant = [np.full(recording.t.size, value) for value in (rig.e, rig.a, k)]
    return np.column_stack([
        plain_inputs(recording),
        constant[0],
        recording.F_N,
        [state.direction for state in memories],
        [state.zones == 5 for state in memories],
        *constant[1:],
        found.mu,
    ])  # fmt: skip


def neural_network(recordings: Sequence[Recording], design: Design | None = None) -> FrictionNetwork:
    """The source's neural network, section 4.1, trained on recordings with a declared mu.

    Args:
        recordings: to learn from.
        design: network and training; None for the defaults.
    """
    return train(recordings, plain_inputs, design, name="neural network")


def corrected_root(recordings: Sequence[Recording], design: Design | None = None) -> FrictionNetwork:
    """The source's scientific machine learning, section 4.2: the root solve and a network that mends it.

    Args:
        recordings: to learn from.
        design: network and training, tanh whatever it says, as the source found best; None for the
            defaults.
    """
    tanh = replace(design or Design(), activation=Activation.TANH)
    return train(recordings, all_inputs, tanh, base=ANALYTIC, name="root and network")


def _memories(recording: Recording) -> list[ZoneState]:
    state, states = ZoneState(), []
    for psi in recording.psi - recording.psi[0]:
        state = advance_zones(state, float(psi), LEAST_TURN)
        states.append(state)
    return states
