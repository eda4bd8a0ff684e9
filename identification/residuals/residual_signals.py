"""Signals of a recording that a residual may follow, and what each means."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from identification.fits.loss import rmse_of
from identification.reading.recordings import Recording
from identification.reading.trimming_and_thinning import MIN_REVERSAL
from symbolic import Effect, InvalidInputError
from symbolic.float_array_type import Array

MIN_MOVING_SHARE = 0.05
"""Below this share of its rms yaw rate the wheel counts as resting [1]."""

SMALL = 0.4
"""Torques of about this share of their rms are near zero [1]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MotionSignals:
    """The motion of a recording, from which signals are computed; arrays of shape (n,)."""

    t: Array  # Time since the first sample [s].
    psi: Array  # Yaw angle [rad].
    psi_dot: Array  # Yaw rate [rad/s].
    F_N: Array  # Vertical load [N].
    M_z: Array  # Torque of the model [N m], without noise; interpolated where none was measured.
    heading: Array  # 1 or -1 from one reversal to the next, 0 before the first turn.
    travel: Array  # Angle turned since the last reversal [rad].
    elapsed: Array  # Time since the last reversal [s].

    @property
    def direction(self) -> Array:
        """Direction of turning, -1 to 1, near 0 at rest."""
        return self.psi_dot / self._speed

    @property
    def log_speed(self) -> Array:
        """Logarithm of the speed over its geometric mean while turning [1]."""
        speed = self._speed
        moving = np.abs(self.psi_dot) > MIN_MOVING_SHARE * rmse_of(self.psi_dot)
        usual = np.mean(np.log(speed[moving])) if moving.any() else 0.0
        return np.asarray(np.log(speed) - usual)

    @property
    def range_so_far(self) -> Array:
        """Range of the angles up to each sample over the whole range [1]."""
        extent = np.maximum.accumulate(self.psi) - np.minimum.accumulate(self.psi)
        return np.asarray(extent / max(float(extent[-1]), 1e-12))

    @property
    def _speed(self) -> Array:
        slow = max(MIN_MOVING_SHARE * rmse_of(self.psi_dot), 1e-9)
        return np.hypot(self.psi_dot, slow)


@dataclass(frozen=True)
class Signal:
    """One signal that a residual may follow."""

    name: str  # In plain words, as in "the residual follows ..."; signatures refer to it.
    unit: str  # Of its values.
    of: Callable[[MotionSignals], Array]  # Its values, shape (n,).
    positive_cause: str  # What usually leaves a residual, simulated minus measured, of its sign.
    negative_cause: str = ""  # What leaves one of the opposite sign; empty where the sign tells nothing.
    differs_by_recording: bool = False  # Whether strength and sign are those of each recording.
    centred: bool = True  # Whether its mean over each recording is taken out, left to the constant.


_FALLING = "friction that falls with speed, or a delayed torque channel"
_AFTER_REVERSAL = ("friction grows after a reversal", "friction falls after a reversal")
_TWISTED = "the patch is twisted at the first sample"

RESIDUAL_SIGNALS: tuple[Signal, ...] = (
    Signal(
        "a constant of each recording",
        "1",
        lambda motion: np.ones(motion.t.size),
        f"a zero error of the torque channel, or {_TWISTED}",
        differs_by_recording=True,
        centred=False,
    ),
    Signal(
        "the angle",
        "rad",
        lambda motion: motion.psi,
        "a return torque, stress that relaxes, or a pressure centre off the middle",
        "the loop's curvature differs from that of parabolic pressure on a rigid carcass",
    ),
    Signal(
        "the yaw rate",
        "rad/s",
        lambda motion: motion.psi_dot,
        "viscous damping, or friction that grows with speed",
        _FALLING,
    ),
    Signal(
        "the direction of turning",
        "1",
        lambda motion: motion.direction,
        "dry friction in the kingpin or the sensor's mount",
        _FALLING,
    ),
    Signal(
        # Where the patch slides, -M_z is the direction times the level of friction; where it sticks,
        # friction does not show. The direction alone times log speed follows neither.
        "the direction of friction times log speed",
        "N m",
        lambda motion: -motion.M_z * motion.log_speed,
        "friction grows with sliding speed",
        "friction falls with sliding speed",
    ),
    Signal(
        "the load",
        "N",
        lambda motion: motion.F_N,
        "the torque channel is sensitive to the load, or the length of the patch depends on it",
    ),
    Signal(
        "the torque times the load",
        "N m",
        lambda motion: motion.M_z * (motion.F_N / motion.F_N.mean() - 1),
        "friction, or the length of the patch, depends on the load",
    ),
    Signal(
        "the magnitude of the torque",
        "1",
        lambda motion: np.abs(motion.M_z),
        "friction differs by direction of turning",
        # Friction that differs by direction shifts the loop as a whole.
        centred=False,
    ),
    Signal(
        # A gap that is crossed at no torque takes from small torques what it leaves of large ones.
        "the torque near zero",
        "1",
        lambda motion: motion.M_z * np.exp(-0.5 * (motion.M_z / (SMALL * rmse_of(motion.M_z))) ** 2),
        "a dead zone: the angle moves and the torque is near zero",
        "contact that stiffens around zero torque",
    ),
    Signal(
        "the signed angle since the last reversal",
        "rad",
        lambda motion: motion.heading * motion.travel,
        *_AFTER_REVERSAL,
    ),
    Signal(
        "the signed time since the last reversal",
        "s",
        lambda motion: motion.heading * motion.elapsed,
        *_AFTER_REVERSAL,
    ),
    Signal(
        "time",
        "s",
        lambda motion: motion.t,
        f"the torque channel drifts, or {_TWISTED}",
        differs_by_recording=True,
    ),
    Signal(
        "the torque times the time",
        "N m s",
        lambda motion: motion.M_z * (motion.t - motion.t.mean()),
        "friction changes in the course of a recording",
    ),
    Signal(
        "the rate of the torque",
        "s",
        lambda motion: np.gradient(motion.M_z, motion.t),
        "a delayed torque channel, or a compliance in series",
        "stress that relaxes, or damping",
    ),
    Signal(
        "the initial twist that remains",
        "1",
        lambda motion: 1 - motion.range_so_far,
        _TWISTED,
        differs_by_recording=True,
    ),
)
"""In the order in which a person would look; slopes are in N m per unit of the signal."""


def effects_with_signature(signal: Signal, sign: int, effects: Iterable[Effect]) -> tuple[str, ...]:
    """Names of the effects that declare this signature, the likeliest first.

    The sign of the correlation, 1 or -1, has no meaning for signals with a strength per recording.
    """
    declared = [
        (signature.rank, effect.name)
        for effect in effects
        for signature in effect.signatures
        if signature.signal == signal.name
        and (signal.differs_by_recording or signature.sign in (0, sign))
    ]
    return tuple(name for _, name in sorted(declared, key=lambda one: one[0]))


def correlation_meaning_text(
    signal: Signal, correlation: float, effects: Sequence[Effect], added: Sequence[Effect]
) -> str:
    """What a correlation with a signal means beside the effects that the model has."""
    sign = 1 if correlation >= 0 else -1
    signs = {e.name: {s.sign for s in e.signatures if s.signal == signal.name} for e in added}
    against = [name for name, own in signs.items() if own == {-sign}]
    if against and not signal.differs_by_recording:
        return f"{_effect_names_in_words(against)} may be too strong there"
    tried = effects_with_signature(signal, sign, [e for e in effects if e not in added] if added else ())
    beside = f" (tried, not added: {_effect_names_in_words(tried)})" * bool(tried)
    opposite = signal.negative_cause or signal.positive_cause
    return f"usually {signal.positive_cause if sign > 0 else opposite}{beside}"


def _effect_names_in_words(effects: Iterable[str]) -> str:
    return " and ".join(effects).replace("_", " ")


def check_signatures(effects: Iterable[Effect]) -> None:
    """Check that the signatures which effects declare are of signals that are looked at."""
    known = [signal.name for signal in RESIDUAL_SIGNALS]
    for effect in effects:
        for signature in effect.signatures:
            if signature.signal not in known:
                raise InvalidInputError(
                    f"effect {effect.name!r} declares a signature of an unknown signal"
                    f" {signature.signal!r}; known are {', '.join(known)}"
                )


def motion_and_model_torque(recording: Recording, residual: Array) -> MotionSignals:
    """The motion of a recording, with the torque of the model that left this residual [N m]."""
    modelled = residual + recording.M_z
    known = np.isfinite(modelled)
    heading, travel, elapsed = motion_since_reversal(recording.t, recording.psi)
    return MotionSignals(
        t=recording.t - recording.t[0],
        psi=recording.psi,
        psi_dot=recording.psi_dot,
        F_N=recording.F_N,
        M_z=np.interp(recording.t, recording.t[known], modelled[known]),
        heading=heading,
        travel=travel,
        elapsed=elapsed,
    )


def motion_since_reversal(t: Array, psi: Array) -> tuple[Array, Array, Array]:
    """Heading [1], angle [rad] and time [s] since the last reversal, from where the wheel turned."""
    heading = np.zeros(psi.size)
    start = np.zeros(psi.size, dtype=int)
    now, turn, low, high = 0.0, 0, 0, 0
    for i, angle in enumerate(psi):
        low, high = (i if angle < psi[low] else low), (i if angle > psi[high] else high)
        if now <= 0 and angle > psi[low] + MIN_REVERSAL:
            now, turn, high = 1.0, low, i
        elif now >= 0 and angle < psi[high] - MIN_REVERSAL:
            now, turn, low = -1.0, high, i
        if now > 0 and high == i:
            low = i
        if now < 0 and low == i:
            high = i
        heading[turn : i + 1], start[turn : i + 1] = now, turn
    return heading, np.abs(psi - psi[start]), t - t[start]
