"""Estimates over a recording: arrays, a data frame, a picture, a table; and their innovations."""

from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from observers.protocol import Status
from symbolic import InvalidInputError
from symbolic.float_array_type import Array
from symbolic.tables.notebook_html import html_table

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BAND_STDS = 2.0
"""Standard deviations to either side of an estimate that hold 95 of 100 values [1]."""
_SHOWN, _MARGIN = (0.05, 0.95), 0.15


@dataclass(frozen=True, kw_only=True, eq=False)
class Estimates:
    """Causal estimates over a recording; arrays of shape (n,), fields as in `Estimate`.

    And `turn`, the angle turned since the last sample that had one, without its sign [rad].
    """

    t: Array
    mu: Array
    mu_std: Array
    M_z_predicted: Array
    informed: NDArray[np.bool_]
    usable: NDArray[np.bool_]
    mu_eff: Array
    mu_eff_std: Array
    M_slide: Array
    nis: Array
    status: NDArray[np.int64]
    turn: Array

    @property
    def has_measured_torque(self) -> NDArray[np.bool_]:
        """True where the sample carried a torque: not all do where channels have rates of their own."""
        return np.asarray(self.status & Status.MISSING == 0, dtype=np.bool_)

    @property
    def is_too_uncertain(self) -> NDArray[np.bool_]:
        """Where nothing is flagged but mu's deviation, too large to be informed, shape (n,)."""
        return np.asarray(~self.informed & (self.status == Status.USED), dtype=np.bool_)

    @property
    def first_usable_time(self) -> float:
        """Time of the first usable sample [s], NaN where there is none."""
        return float(self.t[np.argmax(self.usable)]) if self.usable.any() else float("nan")

    @property
    def usable_share(self) -> float:
        """Share of the samples with a torque that are usable [1]."""
        return float(self.usable.sum()) / max(1, int(self.has_measured_torque.sum()))

    def __repr__(self) -> str:
        """One line: how many samples, how long, and friction at the end."""
        count = self.t.size
        if not count:
            return "<Estimates of no sample>"
        return f"<Estimates of {count} samples to {self.t[-1]:g} s: {self._final_friction_text()}>"

    def _repr_html_(self) -> str:
        """The same as a table, with when friction was known and what was odd."""
        if not self.t.size:
            return html_table("Estimates of no sample", [])
        known, changes = np.flatnonzero(self.usable), np.flatnonzero(self.status & Status.RESET)
        on_last = known[known >= changes[-1]] if changes.size else known
        since = "never"
        if known.size:
            since = f"{known.size} of {self.has_measured_torque.sum()} samples with a torque"
            ground = f"on the ground since {self.t[changes[-1]]:g} s " if changes.size else ""
            when = f"from {self.t[on_last[0]]:g} s" if on_last.size else "never"
            since = f"{ground}{when}, {since}"
        flags = [(flag, np.count_nonzero(self.status & flag.value)) for flag in Status if flag.value]
        odd = ", ".join(f"{flag.name} {count}" for flag, count in flags if count)
        rows = [
            ("samples", f"{self.t.size} to {self.t[-1]:g} s"),
            ("friction coefficient", self._final_friction_text()),
            ("usable", since),
            ("status", odd or "every sample used"),
        ]
        return html_table("Estimates", rows)

    def plot(self, axes: "Axes | None" = None, *, label: str = "μ") -> "Axes":
        """Draw friction over time: bold where it is usable, pale elsewhere.

        Args:
            axes: of matplotlib, to draw into; new ones of pyplot without.
            label: of the line in the legend.
        """
        new = axes is None
        if axes is None:
            from matplotlib import pyplot

            axes = pyplot.subplots(layout="constrained")[1]
        (line,) = axes.plot(self.t, np.where(self.usable, self.mu, np.nan), lw=1.8, label=label)
        axes.plot(self.t, self.mu, color=line.get_color(), lw=0.8, alpha=0.5, label="_pale")
        if np.isfinite(self.mu_std).any():
            reach = BAND_STDS * self.mu_std
            axes.fill_between(
                self.t, self.mu - reach, self.mu + reach, color=line.get_color(), alpha=0.15, lw=0,
                label=f"± {BAND_STDS:g} standard deviations",
            )  # fmt: skip
        if new:
            self._set_labels_and_limits(axes)
        axes.legend()
        return axes

    def to_frame(self) -> Any:
        """A data frame of pandas: one row a sample, `t` as its index [s], a column for each field.

        Raises:
            InvalidInputError: pandas is not installed.
        """
        try:
            pandas = import_module("pandas")
        except ImportError:
            raise InvalidInputError(
                "a data frame needs pandas; pip install 'brushgrip[pandas]'"
            ) from None
        return pandas.DataFrame(vars(self)).set_index("t")

    def _final_friction_text(self) -> str:
        known = "informed" if self.informed[-1] else "not informed"
        return f"mu {self.mu[-1]:.3f} ± {self.mu_std[-1]:.3f} at the end, {known}"

    def _set_labels_and_limits(self, axes: "Axes") -> None:
        """Labels, and limits for the informed estimates: the wide band before may be cut off."""
        axes.set_xlabel("time t [s]")
        axes.set_ylabel("friction coefficient μ [1]")
        shown = self.informed & np.isfinite(self.mu)
        if not shown.any():
            return
        mu, reach = self.mu[shown], BAND_STDS * np.nan_to_num(self.mu_std[shown])
        low, high = np.quantile(mu - reach, _SHOWN[0]), np.quantile(mu + reach, _SHOWN[1])
        margin = _MARGIN * max(high - low, 0.1)
        axes.set_ylim(max(0.0, float(low - margin)), float(high + margin))


@dataclass(frozen=True, kw_only=True, eq=False)
class Innovations:
    """Arrays of shape (n,), NaN where nothing was measured.

    Attributes:
        innovation: measured less predicted torque [N m].
        variance: of the innovation [N^2 m^2].
        log_likelihood: logarithm of its normal density [ln 1/(N m)], [Bar-Shalom 2001], section 5.4.
            Where the model's error lasts, samples are not independent, and their sum says too much.
    """

    innovation: Array
    variance: Array
    log_likelihood: Array


def innovations(estimates: Estimates, M_z: Array) -> Innovations:
    """The innovations of an observer of the aligning torque.

    Args:
        estimates: of `observers.run`.
        M_z: the aligning torque that it was given, shape (n,) [N m].

    Raises:
        InvalidInputError: M_z has another shape than the estimates.
    """
    M_z = np.asarray(M_z, dtype=float)
    if M_z.shape != estimates.t.shape:
        raise InvalidInputError(
            f"M_z must have the shape of the estimates, {estimates.t.shape}, got {M_z.shape}"
        )
    nis = np.where(estimates.nis > 0, estimates.nis, np.nan)
    innovation = np.where(np.isfinite(nis), M_z - estimates.M_z_predicted, np.nan)
    variance = innovation**2 / nis
    return Innovations(
        innovation=innovation,
        variance=variance,
        log_likelihood=-(np.log(2 * np.pi * variance) + nis) / 2,
    )
