"""A torque that no known effect explains, learned from recordings: a fit, not physics.

One layer of tanh units over dimensionless signals, with a tanh around the sum: outside the range of what
it was trained on the torque goes no further than `bound` times the full slide torque. It was trained to
what a physical model left, so it is added last and knows what the others make.

The load is no signal of its own: within a recording it hardly changes, so that units that see it learn
recordings by heart. It is in the full slide torque to which torques are referred.

Sources: Cybenko, Approximation by superpositions of a sigmoidal function, Math. Control Signals
Systems 2 (1989) 303. The way since a reversal is read off stops, Visintin, Differential Models of
Hysteresis (1994): each follows the angle and stays within its width, so that small reversals move the
narrow ones alone.
"""

import math
from dataclasses import dataclass

import casadi as ca

from symbolic.deformation import Expression
from symbolic.effects.base import Effect, Parameter, Signals, Values
from symbolic.effects.patch_output import PatchOutput
from symbolic.errors import InvalidInputError

TURNING = 0.01
"""Yaw rate above which the wheel counts as turning [rad/s]."""
BRISK = 3.0
"""Size of the signed logarithm of a rate of 0.1 rad/s over `TURNING` [1]."""
WAYS = (0.03, 0.1, 0.3)
"""Half-widths of the stops, in shares of the size of an angle [1]."""
INPUTS = 4 + len(WAYS)
"""Signals that the units see: angle, direction, log speed, torque, and the stops."""
LEAST_SLIDE = 1e-6
"""Guard against a wheel without load [N m]."""


@dataclass(frozen=True, kw_only=True)
class LearnedTorque(Effect):
    """Adds bound 3/8 F_N a tanh(v' tanh(W u + w_0) + v_0), u the signals below. Not in the library.

    Attributes:
        angle: size of an angle [rad].
        bound: greatest share of the full slide torque at mu = 1 [1].
        units: tanh units.
        weights: [W, w_0] row by row, then [v, v_0], shape (weights_needed(units),).

    Raises:
        InvalidInputError: a size is not greater than 0, or the weights are too few, too many or not
            finite.
    """

    angle: float
    bound: float
    units: int
    weights: tuple[float, ...]
    name: str = "learned"
    summary: str = "a torque learned from the recordings, not physics"
    parameters: tuple[Parameter, ...] = ()
    memory: int = 1 + len(WAYS)

    def __post_init__(self) -> None:
        """Check the numbers."""
        for name in ("angle", "bound"):
            if not 0 < getattr(self, name) < math.inf:
                raise InvalidInputError(
                    f"learned.{name} must be a finite number greater than 0, got {getattr(self, name)}"
                )
        needed = weights_needed(self.units)
        if self.units < 1 or len(self.weights) != needed:
            raise InvalidInputError(
                f"learned.weights must hold {needed} numbers for {self.units} units, got"
                f" {len(self.weights)}; at least 1 unit is needed"
            )
        if not all(math.isfinite(weight) for weight in self.weights):
            raise InvalidInputError("learned.weights must be finite numbers")

    def initial(self, signals: Signals) -> Expression:
        """The last angle [rad], and every stop in its middle [1]."""
        return ca.vertcat(signals.psi, ca.DM.zeros(len(WAYS)))

    def transform_inputs(
        self, signals: Signals, memory: Expression, values: Values
    ) -> tuple[Signals, Expression]:
        """Move the stops with the angle: each is the way since a reversal, in half-widths, -1 ... 1."""
        del values
        moved = memory[1:] + (signals.psi - memory[0]) / (self.angle * ca.DM(WAYS))
        return signals, ca.vertcat(signals.psi, ca.fmax(-1, ca.fmin(1, moved)))

    def inputs(self, signals: Signals, memory: Expression, made: PatchOutput) -> Expression:
        """What the units see, all dimensionless, shape (INPUTS,)."""
        rate = signals.psi_dot / TURNING
        return ca.vertcat(
            signals.psi / self.angle,
            ca.tanh(rate),
            ca.asinh(rate) / BRISK,
            made.M_z / ca.fmax(made.mu * made.slide, LEAST_SLIDE),
            memory[1:],
        )

    def leftover(self, signals: Signals, memory: Expression, made: PatchOutput) -> Expression:
        """The learned torque [N m]."""
        seen = self.inputs(signals, memory, made)
        return made.slide * network_share(seen, ca.DM(self.weights), self.units, self.bound)


def weights_needed(units: int) -> int:
    """Number of weights of so many units, offsets included."""
    return units * (INPUTS + 1) + units + 1


def network_share(inputs: Expression, weights: Expression, units: int, bound: Expression) -> Expression:
    """The share of the full slide torque, bound tanh(v' tanh(W u + w_0) + v_0) [1].

    Args:
        inputs: u, casadi, shape (INPUTS,).
        weights: [W, w_0] row by row, then [v, v_0], shape (weights_needed(units),).
        units: tanh units.
        bound: greatest share [1].
    """
    split = units * (INPUTS + 1)
    hidden, output = ca.reshape(weights[:split], INPUTS + 1, units).T, weights[split:]
    raised = ca.tanh(ca.mtimes(hidden[:, :INPUTS], inputs) + hidden[:, INPUTS])
    return bound * ca.tanh(ca.dot(output[:units], raised) + output[units])
