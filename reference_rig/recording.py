"""Recordings made on the rig, with its sensors' faults, and the files they are written to."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from reference_rig.effects import LIBRARY_EFFECTS
from reference_rig.hooks import Array, PlantedEffect
from reference_rig.other_laws import OTHER_LAWS
from reference_rig.patch import RigTyre, simulate_bristles
from reference_rig.path import SAMPLE_RATE, STEP_RATE, SUBSTEPS, Hand, hand_path
from reference_rig.sensors import ENCODER_STEP, record_channels
from reference_rig.unmodelled import UNMODELLED_EFFECTS

RIG_EFFECTS = LIBRARY_EFFECTS | UNMODELLED_EFFECTS | OTHER_LAWS
"""Everything that can be planted, by name."""
EffectValues = Mapping[str, Mapping[str, float]]
"""Name of the effect -> its parameters."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RigRecording:
    """Channels of the sensors with the true values beside them; arrays of shape (n,) at 100 Hz.

    Time `t` [s], yaw angle `psi` in steps of the encoder [rad], and with noise the aligning torque
    `M_z`, the moment of the ground on the wheel [N m], and the load `F_N` [N]. True are the angle and
    its rate [rad/s] at the sensor, the torque with all effects, the load, and `psi_patch`, the angle of
    the contact patch [rad]; so are tyre and effects. `ground` is what is below the wheel.
    """

    name: str
    t: Array
    psi: Array
    M_z: Array
    F_N: Array
    psi_true: Array
    psi_dot_true: Array
    psi_patch: Array
    M_z_true: Array
    F_N_true: Array
    tyre: RigTyre
    effects: EffectValues
    ground: str | None = None


def build_effects(planted: EffectValues) -> tuple[PlantedEffect, ...]:
    """Effects by name and parameters; parameters left out are neutral."""
    return tuple(RIG_EFFECTS[name](**parameters) for name, parameters in planted.items())


def make_recording(
    seed: int,
    effects: EffectValues | None = None,
    *,
    a: float = 0.045,
    e: float = 0.009,
    k: float = 2.4e6,
    mu: float = 1.3,
    load: float = 400.0,
    duration: float = 14.0,
    hand: Hand | None = None,
    noise: float = 0.004,
    encoder_step: float = ENCODER_STEP,
    bristles: int = 2000,
    name: str = "rig",
) -> RigRecording:
    """Steer the rig by hand and record it.

    Args:
        seed: of the path and of the noise; equal arguments give equal recordings.
        effects: what to plant, e.g. ``{"rate_friction": {"c": 0.04}}``.
        a: half-length of the patch [m].
        e: caster [m].
        k: distributed lateral stiffness [N/m²].
        mu: friction coefficient [1].
        load: mean vertical load [N].
        duration: length [s].
        hand: how the wheel is turned; None for the usual way.
        noise: standard deviation of the torque channel in shares of the torque's range [1];
            0 also silences the load.
        encoder_step: angle step of the encoder [rad]; 0 for none.
        bristles: number of bristles.
        name: of the recording.
    """
    tyre, planted = RigTyre(a=a, e=e, k=k, mu=mu), effects or {}
    drive = hand_path(seed, duration, hand=hand, load=load, rate=STEP_RATE)
    history = simulate_bristles(drive, tyre, build_effects(planted), bristles=bristles)
    M_z, seen = history.M_z[::SUBSTEPS], drive.every(SUBSTEPS)
    psi, noisy_M_z, noisy_F_N = record_channels(
        seed, seen.psi, M_z, seen.F_N, load=load, noise=noise, encoder_step=encoder_step
    )
    return RigRecording(
        name=name,
        t=np.arange(len(psi)) / SAMPLE_RATE,
        psi=psi,
        M_z=noisy_M_z,
        F_N=noisy_F_N,
        psi_true=seen.psi,
        psi_dot_true=seen.psi_dot,
        psi_patch=history.psi_patch[::SUBSTEPS],
        M_z_true=M_z,
        F_N_true=seen.F_N,
        tyre=tyre,
        effects=planted,
    )


def recording_csv(recording: RigRecording) -> str:
    """The recording as the tool reads it: six significant digits, lines end in LF."""
    columns: Sequence[Array] = (recording.t, recording.psi, recording.M_z, recording.F_N)
    # Adding zero turns -0.0 into 0.0.
    rows = (",".join(f"{value + 0.0:.6g}" for value in row) for row in zip(*columns, strict=True))
    return "\n".join(["t,psi,M_z,F_N", *rows]) + "\n"


def rig_toml(nominal: RigTyre) -> str:
    """The rig file for the tool, with first guesses of k and mu."""
    return (
        "# a and e were measured; k and mu are first guesses.\n"
        "[rig]\n"
        f"a = {nominal.a:.6g}  # half-length of the contact patch, m\n"
        f"e = {nominal.e:.6g}  # caster length (trail), m\n"
        "\n"
        "[tyre]\n"
        f"k = {nominal.k:.3g}  # distributed lateral stiffness, N/m^2\n"
        f"mu = {nominal.mu:.3g}  # coefficient of friction, 1\n"
    )
