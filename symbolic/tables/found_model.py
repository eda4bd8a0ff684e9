"""A model that a diagnosis found, and the values that it has for a recording, seen before or to come."""

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace

from symbolic.effects.base import parameter_name
from symbolic.errors import InvalidInputError
from symbolic.model import Model
from symbolic.rig_and_tyre import EVEN, USUAL, Rig

STIFFNESS_CHANGES = 0.05
"""Least tolerance of a found k, as a share of it [1]: warmth and pressure of a tyre change it."""
OTHER_SCALE = 3.0, 2.5
"""Tolerances of a declared k beyond which a found one is no tyre's but that of a torque or an angle in
another unit or before a gear [1]; and the factor that is always beyond, if not within the tolerance, and
where none is declared [1]. What is too large by a factor is too small by its inverse."""
ALIKE = 5.0
"""Ratio of two values up to which their mean is the geometric one [1]."""
SHARED = 0.5
"""Share of what k is off by that counts as the torque's scale [1]."""


@dataclass(frozen=True, kw_only=True)
class ModelError:
    """The torque error of a model on recordings to which its shared parameters were not fitted.

    Attributes:
        spread: root mean square of the error as a share of the torque of full slide with mu = 1,
            (3/8) F_N a, at least 0 [1].
        correlation_time: integrated autocorrelation time of the error, greater than 0 [s]: it is worth
            one independent sample in so much time. Twice the time constant of an error whose
            autocorrelation is an exponential.
        relative: the same root mean square as a share of the torque that there is, half the range of the
            recording's torque, at least 0 [1]; None in a file that does not tell it.
        friction_walk: change of the level of sliding friction from one slide to the next, as the
            random walk of mu that makes it, a share of mu, at least 0 [1/sqrt(s)]; None where unknown.

    Raises:
        InvalidInputError: a value is outside its range, or not a finite number.
    """

    spread: float
    correlation_time: float
    relative: float | None = None
    friction_walk: float | None = None

    def __post_init__(self) -> None:
        """Check every value against its range."""
        for name in ("spread", "relative", "friction_walk"):
            if not 0 <= (value := getattr(self, name) or 0.0) < math.inf:
                raise InvalidInputError(f"{name} must be a finite number of at least 0, got {value}")
        if not 0 < self.correlation_time < math.inf:
            raise InvalidInputError(
                f"correlation_time must be a finite number greater than 0 s, got {self.correlation_time}"
            )

    @property
    def share_of_torque(self) -> float:
        """The error as a share of the torque that there is [1]; the spread where that is not told."""
        return self.spread if self.relative is None else self.relative


@dataclass(frozen=True, kw_only=True)
class ModelBasis:
    """Numbers of recordings behind a found model, and the grade of each effect.

    Attributes:
        training: number of recordings that its shared values were fitted to.
        holdout: number of further recordings, which judged it.
        grades: how sure each effect is, by name: strong, weak, ambiguous or stands_in.
        unexplained: whether it leaves an error with a structure.
        loads: least and greatest load of all these recordings [N]; None where it is not told.

    Raises:
        InvalidInputError: a count is no whole number of at least 0, or a load is not greater than 0.
    """

    training: int
    holdout: int
    grades: Mapping[str, str] = field(default_factory=dict)
    unexplained: bool = False
    loads: tuple[float, float] | None = None

    @property
    def explains_nothing(self) -> bool:
        """Whether it leaves an error with a structure, and no effect surely explains a part."""
        return self.unexplained and not {"strong", "ambiguous"} & set(self.grades.values())

    def __post_init__(self) -> None:
        """Check the counts."""
        for name in ("training", "holdout"):
            count = getattr(self, name)
            if isinstance(count, bool) or not isinstance(count, int) or count < 0:
                raise InvalidInputError(f"{name} must be a whole number of at least 0, got {count}")
        if self.loads is not None and not 0 < self.loads[0] <= self.loads[1] < math.inf:
            raise InvalidInputError(f"loads must be greater than 0, in order, got {list(self.loads)}")


@dataclass(frozen=True, kw_only=True)
class FoundModel:
    """A model that a diagnosis found.

    Attributes:
        model: the structure.
        tyre: values that hold everywhere, by name, `k` among them where it belongs to no ground.
        own: values of the recordings of the diagnosis, by recording.
        grounds: values of each ground, by its name; empty where nothing belongs to a ground.
        rig: what became of the declared values that have a tolerance, by recording: `a`, `e`, `load`, a
            factor on the recorded load, and `zero`, that of the torque channel.
        error: how wrong the model is on recordings that it was not fitted to; None where unknown.
        basis: what it stands on; None in a file that does not tell it.
        k_std: standard deviation of `k` [N/m^2]; None where it is not told, or belongs to a ground.

    Raises:
        InvalidInputError: the deviation is negative, or not a finite number.
    """

    model: Model
    tyre: Mapping[str, float]
    own: Mapping[str, Mapping[str, float]]
    grounds: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    rig: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    error: ModelError | None = None
    basis: ModelBasis | None = None
    k_std: float | None = None

    @property
    def surpasses_declared(self) -> bool:
        """Whether it explains more than the declared model."""
        none = self.basis is not None and self.basis.explains_nothing
        return bool(self.model.effects) and not none

    def __post_init__(self) -> None:
        """Check the deviation."""
        if self.k_std is not None and not 0 <= self.k_std < math.inf:
            raise InvalidInputError(f"k_std must be a finite number of at least 0, got {self.k_std}")

    def rig_with_k_tolerance(self, rig: Rig, declared: float, ground: str | None = None) -> Rig:
        """The rig with the tolerance of this model's k: that of the declared k is of another number.

        It is as wide as the diagnosis knows k. What k is off by may be the tyre or the torque's scale:
        where a tolerance of k is declared, half of what k is off by, in its logarithm, is a standard
        deviation of the scale.

        Args:
            rig: with the tolerance of the declared k.
            declared: k of the rig file [N/m^2].
            ground: whose k is taken, where it belongs to a ground.

        Raises:
            InvalidInputError: k is farther from the declared one than `OTHER_SCALE` allows.
        """
        k, tolerance = self.values_for_estimation(ground).get("k", declared), rig.tolerances.k
        if has_implausible_stiffness(k, declared, tolerance):
            raise InvalidInputError(
                f"the model's stiffness k is {k:.3g} N/m^2, {k / declared:.2g} times the declared one; a"
                " torque or an angle in another unit or before a gear, or a wrong load or half-length,"
                " looks like that, and makes friction wrong by as much: check the torque with a weight."
                " If k was measured otherwise, declare that value and its tolerance in the rig file"
            )
        known, scale = tolerance, 0.0
        if self.k_std is not None:
            known = min(max(self.k_std / EVEN, STIFFNESS_CHANGES * k), USUAL["k"] * k)
        if tolerance is not None and k != declared:
            scale = SHARED * abs(math.log(k / declared)) / EVEN
        scale = math.hypot(rig.tolerances.scale, scale)
        return replace(rig, tolerances=replace(rig.tolerances, k=known, scale=scale))

    def values_for_recording(
        self, recording: str, mu: float | None = None, ground: str | None = None
    ) -> dict[str, float]:
        """All parameter values for a recording.

        A recording that the file does not know gets `mu` and the neutral value of whatever else
        belongs to a recording, as a torque zero. For grounds see `values_on_ground`.

        Raises:
            InvalidInputError: neither the file nor the caller gives mu.
        """
        own = dict(self.own.get(recording, {}))
        if mu is not None and "mu" not in own:
            own["mu"] = mu
        if "mu" not in own:
            raise InvalidInputError(
                f"{recording}: no mu in the model file for this recording and none in the rig;"
                " add mu under [tyre] of the rig file"
            )
        return {**self.values_for_estimation(ground, tared=True), **own}

    def values_on_ground(self, ground: str | None = None) -> dict[str, float]:
        """Value of a ground; the mean over grounds where this one is unknown or none of them."""
        known = self.grounds.get(ground) if ground is not None else None
        return mean_over_grounds(self.grounds) if known is None else dict(known)

    def ground_used_text(self, ground: str | None = None) -> str:
        """The ground whose values `values_on_ground` takes, in words; empty where there is no ground."""
        if not self.grounds:
            return "" if ground is None else f"{ground}: the model has the same values on every ground"
        if ground in self.grounds:
            return f"values of {ground}"
        known = " and ".join(self.grounds)
        return f"{'ground not given' if ground is None else f'{ground} is unknown'}: mean of {known}"

    def values_for_estimation(
        self, ground: str | None = None, *, tared: bool = False
    ) -> dict[str, float]:
        """All parameter values but mu for a recording to come, as an observer needs them.

        Other parameters of a recording, such as a torque zero, have their neutral values. For grounds
        see `values_on_ground`.

        Args:
            ground: the ground whose values are taken.
            tared: whether the torque was set to zero just before, on a wheel that was aligned as for the
                recordings of the diagnosis; else an effect with a tare is neutral, see `Effect.tare`.
        """
        neutral = {
            parameter_name(effect, parameter): parameter.neutral
            for effect, parameter in self.model.parameters
            if parameter.neutral is not None
            and (parameter.scope == "recording" or (effect is not None and effect.tare and not tared))
        }
        values = {**self.tyre, **self.values_on_ground(ground), **neutral}
        return {name: value for name, value in values.items() if name != "mu"}


def has_implausible_stiffness(k: float, declared: float, tolerance: float | None) -> bool:
    """Whether a stiffness that was found is farther from the declared one than `OTHER_SCALE` allows.

    All are in N/m^2; the tolerance is None where none is declared.
    """
    tolerances, factor = OTHER_SCALE
    if tolerance is not None:
        share = tolerance / declared
        factor = max(min(1 + tolerances * max(share, STIFFNESS_CHANGES), factor), 1 + share)
    return not 1 / factor <= k / declared <= factor


def units_of(model: Model) -> dict[str, str]:
    """The unit of every parameter of a model, by name."""
    return {parameter_name(effect, parameter): parameter.unit for effect, parameter in model.parameters}


def mean_over_grounds(grounds: Mapping[str, Mapping[str, float]]) -> dict[str, float]:
    """For each parameter the mean of its values on these grounds, see `geometric_or_arithmetic_mean`."""
    names = dict.fromkeys(name for values in grounds.values() for name in values)
    return {
        name: geometric_or_arithmetic_mean([v[name] for v in grounds.values() if name in v])
        for name in names
    }


def geometric_or_arithmetic_mean(values: Collection[float]) -> float:
    """The geometric mean of values of one sign; the arithmetic mean where there are two or a zero.

    Also where one is more than `ALIKE` times another: one of them may be all but zero.
    """
    least, most = min(values), max(values)
    if least == most:
        return least
    if least * most > 0 and max(least / most, most / least) < ALIKE:
        logarithms = [math.log(abs(value)) for value in values]
        return math.copysign(math.exp(math.fsum(logarithms) / len(values)), most)
    return math.fsum(values) / len(values)
