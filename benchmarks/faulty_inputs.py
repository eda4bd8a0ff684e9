"""Faults of an input by name, for either torque: of its sensors, of what is declared, and of the patch.

A steering torque has the ground's with the other sign beside what turns the wheel, M = J_A psi'' +
b_t psi' - M_z. What a fault changes of the ground is changed in it for the same motion of the wheel.
"""

from collections.abc import Callable, Mapping
from itertools import product
from typing import Any

import numpy as np
from scipy.signal import lfilter

from reference_rig import free_path, simulate_bristles

Inputs = Mapping[str, Any]
"""psi [rad], F_N [N] and the measured torque [N m], (n,); a [m], k [N/m^2], J_A [kg m^2] and b_t [N m s]
as declared. What a fault needs of the recording: tyre and period [s]; angle [rad] and rate [rad/s] of
the wheel, (n,); ground, M_z in the torque [N m], and its sign there, 1 or -1."""
Fault = Callable[[Any, np.random.Generator], Inputs]
LOAD, BRISTLES, NOISE = 400.0, 500, 0.004
"""Load [N] and bristles of the rig; noise of its torque, as a share of the range [1]."""


def scaled(channel: str, factor: float) -> Fault:
    """A channel in another unit, before a gear, or with the other sign."""
    return lambda inputs, _: {**inputs, channel: inputs[channel] * factor}


def late(channel: str, time: float) -> Fault:
    """A channel that comes late [s]."""

    def fault(inputs: Any, _: Any) -> Inputs:
        samples = round(time / inputs["period"])
        held = np.full(samples, inputs[channel][0])
        return {**inputs, channel: np.concatenate([held, inputs[channel][:-samples]])}

    return fault


def clipped(share: float, *, one_sided: bool = False) -> Fault:
    """A torque sensor that ends at a share of the greatest torque."""

    def fault(inputs: Any, _: Any) -> Inputs:
        most = share * np.abs(inputs["torque"]).max()
        least = -np.inf if one_sided else -most
        return {**inputs, "torque": np.clip(inputs["torque"], least, most)}

    return fault


def clipped_before_noise(share: float) -> Fault:
    """An amplifier that ends there; the converter behind it has the sensor's noise."""

    def fault(inputs: Any, rng: np.random.Generator) -> Inputs:
        torque = clipped(share)(inputs, rng)["torque"]
        noise = NOISE * np.ptp(inputs["torque"]) * rng.standard_normal(torque.size)
        return {**inputs, "torque": torque + noise}

    return fault


def saturating(share: float) -> Fault:
    """A sensor, or a motor, that gives way before it ends at a share of the greatest torque."""

    def fault(inputs: Any, _: Any) -> Inputs:
        most = share * np.abs(inputs["torque"]).max()
        return {**inputs, "torque": most * np.tanh(inputs["torque"] / most)}

    return fault


def one_way(factor: float) -> Fault:
    """A torque sensor with another scale for one sign."""
    return lambda inputs, _: {
        **inputs, "torque": inputs["torque"] * np.where(inputs["torque"] > 0, factor, 1.0)
    }  # fmt: skip


def low_passed(time: float) -> Fault:
    """A torque behind a filter of first order [s]."""

    def fault(inputs: Any, _: Any) -> Inputs:
        torque, kept = inputs["torque"], time / (time + inputs["period"])
        return {**inputs, "torque": lfilter([1 - kept], [1, -kept], torque, zi=[torque[0] * kept])[0]}

    return fault


def stuck(channel: str, share: float) -> Fault:
    """A channel that stays as it is from a share of the recording on."""

    def fault(inputs: Any, _: Any) -> Inputs:
        values = inputs[channel].copy()
        at = int(share * values.size)
        values[at:] = values[at]
        return {**inputs, channel: values}

    return fault


def drifting(rate: float) -> Fault:
    """A torque whose zero drifts [N m/s]."""
    return lambda inputs, _: {
        **inputs, "torque": inputs["torque"] + rate * inputs["period"] * np.arange(inputs["torque"].size)
    }  # fmt: skip


def relaxed(M_z: Any, time: float, period: float = 0.01) -> Any:
    """The torque [N m] of a wheel that rolls: what it was relaxes within this time [s]."""
    kept = float(np.exp(-period / time))
    return lfilter([1.0], [1, -kept], np.diff(M_z, prepend=M_z[0]))


def rolling(time: float) -> Fault:
    """A wheel that rolls: its torque relaxes [s]."""
    return lambda inputs, _: _on_ground(inputs, relaxed(inputs["ground"], time, inputs["period"]))


def _on_ground(inputs: Any, M_z: Any) -> Inputs:
    """The inputs of the same motion where the ground's moment is M_z [N m]."""
    return {**inputs, "torque": inputs["torque"] + inputs["sign"] * (M_z - inputs["ground"])}


def _after(before: Any, inputs: Any) -> Inputs:
    """The inputs after angles [rad] that nobody recorded; they end at the first recorded one."""
    psi = np.concatenate([before[:-1] - before[-1], inputs["angle"]])
    return _on_ground(inputs, _torque(psi, inputs)[before.size - 1 :])


def _torque(psi: Any, inputs: Any) -> Any:
    """The torque [N m] at these angles [rad] of a patch that was free at the first."""
    period = inputs["period"]
    drive = free_path(period * np.arange(psi.size), psi, load=LOAD, rate=1 / period)
    return simulate_bristles(drive, inputs["tyre"], bristles=BRISTLES).M_z


def twisted(turn: float) -> Fault:
    """A patch that stood twisted at the first sample, after a turn [rad]."""
    return lambda inputs, _: _after(np.linspace(0, turn, 200), inputs)


def released(turn: float) -> Fault:
    """A wheel that was turned so far [rad], then let go: it turned back until its torque was 0."""

    def fault(inputs: Any, _: Any) -> Inputs:
        psi = np.concatenate([np.linspace(0, turn, 200), np.linspace(turn, -turn, 2000)])
        back = _torque(psi, inputs)[200:] * turn > 0
        return _after(psi[: 201 + int(np.argmax(back))], inputs)

    return fault


def noisy(channel: str, std: float) -> Fault:
    """White noise beside that of the sensor."""
    return lambda inputs, rng: {
        **inputs, channel: inputs[channel] + std * rng.standard_normal(inputs[channel].size)
    }  # fmt: skip


def rubbing(torque: float) -> Fault:
    """Dry friction of a bearing between sensor and patch [N m]."""
    return lambda inputs, _: _on_ground(
        inputs, inputs["ground"] - torque * np.tanh(inputs["rate"] / 0.005)
    )


FAULTS: dict[str, Fault] = {
    "none": lambda inputs, _: inputs,
    **{f"torque × {f:g}": scaled("torque", f) for f in (
        1e-3, 0.1, 0.2, 0.33, 0.5, 0.67, 0.8, 0.9, 1.1, 1.2, 1.3, 1.5, 2, 3, 5, 10, 14.8, 1e3, -1)},
    "torque in lbf ft": scaled("torque", 0.7376),
    "torque in kgf m": scaled("torque", 1 / 9.81),
    **{f"psi × {f:.3g}": scaled("psi", f) for f in (57.3, -1, 0.5, 0.8, 1.25, 2, 1 / 14.8, 14.8, 1e-3)},
    **{f"load × {f:g}": scaled("F_N", f) for f in (
        1e-3, 0.102, 0.2248, 0.5, 0.8, 0.9, 1.1, 1.25, 2, 4.448)},
    **{f"torque clipped at {s:g}": clipped(s) for s in (0.3, 0.5, 0.7)},
    "torque clipped to one side": clipped(0.5, one_sided=True),
    **{f"torque clipped at {s:g} before noise": clipped_before_noise(s) for s in (0.3, 0.5, 0.7)},
    **{f"torque saturates at {s:g}": saturating(s) for s in (0.5, 0.8)},
    **{f"torque of one sign × {f:g}": one_way(f) for f in (0.5, 0.7, 0.85)},
    **{f"torque late by {1000 * t:g} ms": late("torque", t) for t in (0.03, 0.1, 0.3)},
    "psi late by 100 ms": late("psi", 0.1),
    **{f"torque low-passed, {t:g} s": low_passed(t) for t in (0.05, 0.2, 0.5)},
    **{f"{c} stuck from {s:g}": stuck(c, s) for c, s in product(("torque", "psi"), (0.1, 0.5))},
    **{f"torque drifts, {r:g} N m/s": drifting(r) for r in (0.1, 0.5)},
    **{f"wheel rolls, {t:g} s": rolling(t) for t in (0.3, 1.0, 3.0)},
    **{f"{n} × {f:g}": scaled(n, f) for n, f in product(("k", "a"), (0.8, 1.25))},
    "k × 0.5": scaled("k", 0.5), "k × 2": scaled("k", 2.0), "a × 0.95": scaled("a", 0.95),
    "a × 1.05": scaled("a", 1.05), "dry friction 0.5 N m": rubbing(0.5),
    **{f"patch twisted by {turn:g} rad at the start": twisted(turn) for turn in (0.02, -0.02, 0.1, 0.3)},
    **{f"wheel turned by {turn:g} rad, then let go": released(turn) for turn in (0.1, -0.1, 0.3, -0.3)},
    "torque noise 1 N m": noisy("torque", 1.0), "psi noise 0.01 rad": noisy("psi", 0.01),
    **{f"{n} × {f:g}": scaled(n, f) for n, f in product(("J_A", "b_t"), (0.5, 2.0))},
}  # fmt: skip
TOLERATED = {
    "none",
    "torque × 0.9",
    "torque × 1.1",
    "psi × 0.8",
    "psi × 1.25",
    "k × 0.8",
    "a × 0.95",
    "a × 1.05",
}
"""Faults inside the tolerances of k and a; the band has to hold."""
INVISIBLE = {f"load × {f:g}" for f in (0.5, 0.8, 0.9, 1.1, 1.25, 2, 4.448)}
"""Faults that are a friction off by a factor."""
OF_THE_WHEEL = {name for name in FAULTS if name.startswith(("J_A", "b_t"))}
"""Faults of what a steering torque alone has in it."""
OF_THE_PATCH = {name for name in FAULTS if "twisted" in name or "let go" in name}
"""Faults whose torque is simulated anew, by a patch without effects."""
