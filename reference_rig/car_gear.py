"""Parts of the gear: dry friction with presliding, joints with play, the assistance and its motor."""

from dataclasses import dataclass
from math import copysign, sin


@dataclass(frozen=True, kw_only=True)
class GearFriction:
    """Dry friction of the rack after LuGre [Canudas de Wit 1995], without Stribeck effect."""

    level: float = 180.0  # Friction of the unloaded gear [N].
    by_load: float = 0.02  # Growth with the force on the rack [1].
    asymmetry: float = 0.05  # Share by which it is larger to the left and smaller to the right [1].
    stiffness: float = 5e6  # Stiffness of the bristles between rack and housing [N/m].
    damping: float = 800.0  # Viscous part [N s/m].

    def bound(self, load: float, speed: float) -> float:
        """Friction while the rack slides at a force of the tie rods [N]."""
        side = 1 + copysign(self.asymmetry, speed)
        return (self.level + self.by_load * abs(load)) * side

    def step(self, stretch: float, speed: float, load: float, dt: float) -> tuple[float, float]:
        """Stretch of the bristles after a step [m], and the force against the motion [N]."""
        rate = self.stiffness * abs(speed) / self.bound(load, speed)
        after = (stretch + speed * dt) / (1 + rate * dt)
        return after, self.stiffness * after + self.damping * speed


@dataclass(frozen=True, kw_only=True)
class Joint:
    """A rod with play between its ends."""

    stiffness: float = 4e6  # [N/m]
    play: float = 0.1e-3  # Play from flank to flank [m].

    def force(self, gap: float) -> float:
        """Pull [N] where the ends are farther apart by a gap [m] than the middle of the play."""
        half = 0.5 * self.play
        if gap > half:
            return self.stiffness * (gap - half)
        return self.stiffness * (gap + half) if gap < -half else 0.0


@dataclass(frozen=True, kw_only=True)
class Assistance:
    """Electric motor on the pinion."""

    ratio: float = 20.0  # Turns of the motor for one of the pinion [1].
    efficiency: float = 0.9  # Efficiency of the reduction [1].
    inertia: float = 6e-5  # Inertia of the rotor [kg m²].
    gain: float = 14.0  # Torque at the pinion for the torsion bar's above the threshold [1].
    threshold: float = 0.4  # Torque of the torsion bar without assistance [N m].
    largest: float = 110.0  # Torque at the pinion [N m].
    lag: float = 0.004  # Delay of the motor's torque behind the command [s].
    lead: float = 0.01  # Of the command before the torsion bar's torque [s].
    ripple: float = 0.015  # Share of the torque that goes up and down [1].
    cogging: float = 0.01  # Torque of the rotor without current [N m].
    waves: int = 12  # Of both in one turn of the rotor.

    def command(self, torque: float, torque_rate: float) -> float:
        """Torque at the pinion asked for [N m], from the torsion bar's torque and its rate."""
        led = torque + self.lead * torque_rate
        size = self.gain * max(abs(led) - self.threshold, 0.0)
        return copysign(min(size, self.largest), led)

    def at_pinion(self, torque: float, pinion: float) -> float:
        """Torque on the pinion [N m] for the motor's mean torque [N m] and the pinion's angle [rad]."""
        wave = sin(self.waves * self.ratio * pinion)
        return self.ratio * self.efficiency * (torque * (1 + self.ripple * wave) + self.cogging * wave)
