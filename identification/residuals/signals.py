"""What a residual may follow: signals of a recording, what each means, and the effects that leave it."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identification.reading.recordings import Recording

Array = NDArray[np.float64]
REVERSAL = 1e-3
"""Turning back by this much is a reversal, not the encoder's noise [rad]."""
SLOW = 0.05
"""Below this share of its rms yaw rate the wheel counts as resting [1]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Motion:
    """A recording as the signals see it; arrays of shape (n,).

    Attributes:
        t: time since the first sample [s].
        psi: yaw angle [rad].
        psi_dot: yaw rate [rad/s].
        F_N: vertical load [N].
        M_z: torque of the model [N m], which has no noise; interpolated where no torque was measured.
        heading: 1 or -1 from one reversal to the next, 0 before the first turn.
        way: angle turned since the last reversal [rad].
        pause: time since the last reversal [s].
    """

    t: Array
    psi: Array
    psi_dot: Array
    F_N: Array
    M_z: Array
    heading: Array
    way: Array
    pause: Array

    @property
    def direction(self) -> Array:
        """Direction of turning, -1 to 1, near 0 at rest."""
        return self.psi_dot / self._speed

    @property
    def log_speed(self) -> Array:
        """Logarithm of the speed over its geometric mean while turning [1]."""
        speed = self._speed
        moving = np.abs(self.psi_dot) > SLOW * _rms(self.psi_dot)
        usual = np.mean(np.log(speed[moving])) if moving.any() else 0.0
        return np.asarray(np.log(speed) - usual)

    @property
    def _speed(self) -> Array:
        slow = max(SLOW * _rms(self.psi_dot), 1e-9)
        return np.hypot(self.psi_dot, slow)


@dataclass(frozen=True, kw_only=True)
class Reading:
    """What physics usually leaves a signature.

    Attributes:
        meaning: it in plain words.
        effects: names of the candidate effects that do, in `symbolic.EFFECTS`.
    """

    meaning: str
    effects: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Signal:
    """One signal that a residual may follow.

    Attributes:
        name: it in plain words, as in "the residual follows ...".
        unit: of its values.
        of: its values, shape (n,).
        along: what it means if the residual, simulated minus measured, has the signal's sign.
        against: what it means if it has the opposite sign.
        own: True where every recording has a strength and a sign of its own; both then mean the same.
        centred: whether its mean over each recording is taken out, which leaves that to the constant.
    """

    name: str
    unit: str
    of: Callable[[Motion], Array]
    along: Reading
    against: Reading
    own: bool = False
    centred: bool = True


def _own(name: str, unit: str, of: Callable[[Motion], Array], reading: Reading) -> Signal:
    """A signal to which every recording has a strength of its own, with either sign."""
    return Signal(name=name, unit=unit, of=of, along=reading, against=reading, own=True)


_LOOP = Reading(
    meaning="the loop is bent otherwise than a parabola of pressure over stiff bristles bends it",
    effects=("carcass_torsion", "pressure_shape", "pressure_skew", "patch_width"),
)
_DIRECTION = Reading(
    meaning="friction differs by direction of turning", effects=("asymmetric_friction",)
)
_LOAD = Reading(
    meaning="friction, or the length of the patch, depends on the load",
    effects=("load_dependent_friction", "contact_length"),
)
_DRIFT = Reading(meaning="friction changes as the patch beds in", effects=("friction_drift",))
_LEAKING = Reading(
    meaning="the load enters the torque channel, or changes the length of the patch",
    effects=("contact_length",),
)
_SINCE_REVERSAL = Reading(
    meaning="friction builds up as the wheel turns on",
    effects=("rate_friction", "frictional_creep", "asymmetric_friction", "friction_drift"),
)
_FADING = Reading(
    meaning="friction is less the longer the wheel turns on", effects=("stribeck", "sensor_delay")
)

SIGNALS: tuple[Signal, ...] = (
    replace(
        _own(
            "a constant of each recording",
            "1",
            lambda motion: np.ones(motion.t.size),
            Reading(
                meaning="a zero error of the torque channel, or a patch that came twisted",
                effects=("torque_offset", "pretwist"),
            ),
        ),
        centred=False,
    ),
    Signal(
        name="the angle",
        unit="rad",
        of=lambda motion: motion.psi,
        along=Reading(
            meaning="a return torque, stress that relaxes, or a pressure centre off the middle",
            effects=("steering_return", "viscoelastic_relaxation", "frictional_creep", "pressure_skew"),
        ),
        against=_LOOP,
    ),
    Signal(
        name="the yaw rate",
        unit="rad/s",
        of=lambda motion: motion.psi_dot,
        along=Reading(
            meaning="viscous damping, or friction that grows with speed",
            effects=("contact_damping", "rate_friction", "frictional_creep"),
        ),
        against=Reading(
            meaning="friction that falls with speed, or a late torque channel",
            effects=("stribeck", "sensor_delay"),
        ),
    ),
    Signal(
        name="the direction of turning",
        unit="1",
        of=lambda motion: motion.direction,
        along=Reading(
            meaning="dry friction in the kingpin or the sensor's mount",
            effects=("bearing_friction", "rate_friction"),
        ),
        against=Reading(
            meaning="friction that falls with speed, or a late torque channel",
            effects=("stribeck", "sensor_delay"),
        ),
    ),
    Signal(
        # Where the patch slides, -M_z is the direction times the level of friction; where it sticks,
        # friction does not show. The direction alone times log speed follows neither.
        name="the direction of friction times log speed",
        unit="N m",
        of=lambda motion: -motion.M_z * motion.log_speed,
        along=Reading(
            meaning="friction grows with sliding speed", effects=("rate_friction", "frictional_creep")
        ),
        against=Reading(meaning="friction falls with sliding speed", effects=("stribeck",)),
    ),
    Signal(name="the load", unit="N", of=lambda motion: motion.F_N, along=_LEAKING, against=_LEAKING),
    Signal(
        name="the torque times the load",
        unit="N m",
        of=lambda motion: motion.M_z * (motion.F_N / motion.F_N.mean() - 1),
        along=_LOAD,
        against=_LOAD,
    ),
    Signal(
        # Not centred: friction that differs by direction shifts the loop as a whole.
        name="the size of the torque",
        unit="1",
        of=lambda motion: np.abs(motion.M_z),
        along=_DIRECTION,
        against=_DIRECTION,
        centred=False,
    ),
    Signal(
        name="the way since the last reversal, signed",
        unit="rad",
        of=lambda motion: motion.heading * motion.way,
        along=_SINCE_REVERSAL,
        against=_FADING,
    ),
    Signal(
        name="the time since the last reversal, signed",
        unit="s",
        of=lambda motion: motion.heading * motion.pause,
        along=_SINCE_REVERSAL,
        against=_FADING,
    ),
    _own(
        "time",
        "s",
        lambda motion: motion.t,
        Reading(meaning="the torque channel drifts, or the patch came twisted", effects=("pretwist",)),
    ),
    Signal(
        name="the torque times the time",
        unit="N m s",
        of=lambda motion: motion.M_z * (motion.t - motion.t.mean()),
        along=_DRIFT,
        against=_DRIFT,
    ),
    Signal(
        name="the rate of the torque",
        unit="s",
        of=lambda motion: np.gradient(motion.M_z, motion.t),
        along=Reading(
            meaning="a late torque channel, or a compliance in series",
            effects=("sensor_delay", "carcass_torsion", "pressure_shape"),
        ),
        against=Reading(
            meaning="stress that relaxes, or damping",
            effects=("viscoelastic_relaxation", "frictional_creep", "contact_damping"),
        ),
    ),
    _own(
        "what is not yet overturned of the first twist",
        "1",
        lambda motion: 1 - _extent(motion.psi),
        Reading(meaning="the patch came twisted", effects=("pretwist",)),
    ),
)
"""In the order in which a person would look; slopes are in N m per unit of the signal."""


def motion_of(recording: Recording, residual: Array) -> Motion:
    """The recording as the signals see it, with the torque of the model that left this residual."""
    modelled = residual + recording.M_z
    known = np.isfinite(modelled)
    heading, way, pause = _since_reversal(recording.t, recording.psi)
    return Motion(
        t=recording.t - recording.t[0],
        psi=recording.psi,
        psi_dot=recording.psi_dot,
        F_N=recording.F_N,
        M_z=np.interp(recording.t, recording.t[known], modelled[known]),
        heading=heading,
        way=way,
        pause=pause,
    )


def _since_reversal(t: Array, psi: Array) -> tuple[Array, Array, Array]:
    """Heading, way and time since the last reversal.

    A reversal is known once the wheel has turned back by `REVERSAL`, and counts from where it turned.
    """
    heading = np.zeros(psi.size)
    start = np.zeros(psi.size, dtype=int)
    now, turn, low, high = 0.0, 0, 0, 0
    for i, angle in enumerate(psi):
        low, high = (i if angle < psi[low] else low), (i if angle > psi[high] else high)
        if now <= 0 and angle > psi[low] + REVERSAL:
            now, turn, high = 1.0, low, i
        elif now >= 0 and angle < psi[high] - REVERSAL:
            now, turn, low = -1.0, high, i
        if now > 0 and high == i:
            low = i
        if now < 0 and low == i:
            high = i
        heading[turn : i + 1], start[turn : i + 1] = now, turn
    return heading, np.abs(psi - psi[start]), t - t[start]


def _extent(psi: Array) -> Array:
    """Range of angles met so far over the whole range [1]."""
    met = np.maximum.accumulate(psi) - np.minimum.accumulate(psi)
    return np.asarray(met / max(float(met[-1]), 1e-12))


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
