"""The analytic method of [Györök 2022], section 3: figures 3.4, 3.6 to 3.9 and the filter of figure 5.9.

    python examples/thesis_analytic.py [FOLDER]

Three or five zones by the state machine, one root solve a sample, on our own simulations of the thesis's
profile; FOLDER, by default thesis_analytic, takes the pictures. With the torque in time the method is
right all along. One sample late, as in the published files, it errs, and most where the torque hardly
tells mu: at first, and once more after a reversal, where the ends of the patch slide the new way while
its middle still holds the old turn. The thesis puts these errors down to the numbers of its solver.
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.optimize import brentq

from brushgrip.pictures.style import (
    AFTER,
    BEFORE,
    MEASURED,
    QUIET,
    TRACKS,
    figure_saved_as_png,
    legend_above,
)
from identification import Recording
from observers import RootObserver, Sample, ZoneRootState
from observers.thesis.zone_state_machine import (
    TorqueCurve,
    ZoneState,
    advance_zones,
    turns_from_rest_and_reversal,
    zone_torque_curve,
)
from symbolic import deformation_limit, full_slide_torque
from thesis_profile import DT, FACTORS, LOAD, RIG, SETTLED, K, rmse, steered

BRISTLES = 201
"""As many as in the thesis's simulation."""
MIN_REVERSAL = 5e-4
"""Turn back by which a reversal counts [rad]."""
FIRST = 5
"""Samples, 50 ms, that the angle is given to become more than rounding."""
INSTANTS = (1.5, 3.2, 5.0)
"""Of figure 3.4: three zones, five zones turning back, five zones turning forth [s]."""
NOISE = 0.02
"""Standard deviation of the torque noise for figures 3.8 and 5.9, share of the torque's range [1]."""
BLIND = 0.03
"""Share of the full-slide slope of M_z by mu below which the torque hardly tells mu [1]."""
ALPHAS = (0.01, 0.99)
"""Of the filter (5.9): as the thesis prints it, and as its figure 5.9 looks [1]."""


def remembered(recording: Recording, at: int) -> ZoneState:
    """The state machine of figure 3.5 after the samples up to `at`."""
    state = ZoneState()
    for psi in recording.psi[: at + 1]:
        state = advance_zones(state, psi, MIN_REVERSAL)
    return state


def analytic(recording: Recording, at: int, x: np.ndarray) -> np.ndarray:
    """q(x) of three or five zones [m]: [Györök 2022], (3.4) to (3.6), without solving for boundaries.

    From rest a bristle follows the turn up to its limit; since a reversal, up to twice its limit.
    """
    turn, back = turns_from_rest_and_reversal(remembered(recording, at), recording.psi[at])
    most = deformation_limit(x, LOAD, RIG, recording.tyre)
    return np.clip(-turn * (x - RIG.e), -most, most) + np.clip(-back * (x - RIG.e), -2 * most, 2 * most)


def stepped(recording: Recording, at: int, x: np.ndarray) -> np.ndarray:
    """q(x) by bristles that take the samples one by one, [Györök 2022], (2.15) and (2.16) [m]."""
    q, most = np.zeros(x.size), deformation_limit(x, LOAD, RIG, recording.tyre)
    for turn in np.diff(recording.psi[: at + 1]):
        q = np.clip(q - (x - RIG.e) * turn, -most, most)
    return q


def states_of(recording: Recording, smoothing: float = 0.0) -> list[ZoneRootState]:
    """The method's state after every sample."""
    root = RootObserver(rig=RIG, k=K, smoothing=smoothing, least_turn=MIN_REVERSAL)
    state, states = None, []
    for psi, psi_dot, F_N, M_z in zip(
        recording.psi, recording.psi_dot, recording.F_N, recording.M_z, strict=True
    ):
        sample = Sample(psi=psi, psi_dot=psi_dot, F_N=F_N, dt=DT, M_z=M_z)
        state = root.step(root.init(sample) if state is None else state, sample)
        states.append(state)
    return states


def mu_of(states: list[ZoneRootState]) -> np.ndarray:
    """The estimates [1]."""
    return np.array([state.mu for state in states])


def late(recording: Recording) -> Recording:
    """The recording with its torque one sample late, as the published ones have it."""
    return replace(recording, M_z=np.append(0.0, recording.M_z[:-1]))


def noisy(recording: Recording) -> Recording:
    """The recording with `NOISE` on its torque, drawn from a fixed seed."""
    noise = NOISE * np.ptp(recording.M_z) * np.random.default_rng(0).standard_normal(recording.t.size)
    return replace(recording, M_z=recording.M_z + noise)


def angle(recording: Recording) -> np.ndarray:
    """The yaw angle from the torque and the known mu, figure 3.6 [rad]."""
    mu, state, estimate = float(recording.tyre.mu or 0), ZoneState(), []
    reach = np.ptp(recording.psi)
    for psi, F_N, M_z in zip(recording.psi, recording.F_N, recording.M_z, strict=True):
        state = advance_zones(state, psi, MIN_REVERSAL)

        def misses(angle: float, M_z: float = M_z, F_N: float = F_N, state: ZoneState = state) -> float:
            return (
                M_z - zone_torque_curve(turns_from_rest_and_reversal(state, angle), F_N, K, RIG)(mu)[0]
            )

        estimate.append(brentq(misses, psi - reach, psi + reach))
    return np.array(estimate)


def torque_curve(recording: Recording, at: int) -> TorqueCurve:
    """The zones' torque over mu at a sample."""
    return zone_torque_curve(
        turns_from_rest_and_reversal(remembered(recording, at), recording.psi[at]), LOAD, K, RIG
    )


def draw_deformation(path: Path, recording: Recording) -> None:
    """Figure 3.4, at three instants; prints how far the two are apart."""
    x = np.linspace(-RIG.a, RIG.a, BRISTLES)
    limit = deformation_limit(x, LOAD, RIG, recording.tyre)
    with figure_saved_as_png(path, 3.2) as figure:
        for axes, instant in zip(figure.subplots(1, 3, sharey=True), INSTANTS, strict=True):
            at = round(instant / DT)
            q, bristles = analytic(recording, at, x), stepped(recording, at, x)
            count = remembered(recording, at).zones
            off = np.abs(q - bristles).max() / limit.max()
            print(f"t = {instant} s, {count} zones: q within {off:.1e} of its greatest limit")
            for side in (-1, 1):
                (bound,) = axes.plot(1e3 * x, side * 1e3 * limit, color=QUIET, label="±q_cr")
            (line,) = axes.plot(1e3 * x, 1e3 * q, color=AFTER, label="analytic")
            (dots,) = axes.plot(
                1e3 * x[::6], 1e3 * bristles[::6], "o", ms=3, color=BEFORE, label="bristles, stepped"
            )
            axes.set(title=f"t = {instant} s, {count} zones", xlabel="x [mm]")
        figure.axes[0].set_ylabel("lateral deformation q [mm]")
        legend_above(figure, [line, dots, bound])


def draw_angle(path: Path, recording: Recording) -> None:
    """Figure 3.6, in time and with the torque late; prints the errors."""
    with figure_saved_as_png(path, 4.6) as figure:
        above, below = figure.subplots(2, 1, sharex=True)
        lines = above.plot(recording.t, recording.psi, color=MEASURED, label="true")
        for case, label, colour in ((recording, "in time", AFTER), (late(recording), "late", BEFORE)):
            estimate = angle(case)
            print(f"angle from the torque {label}: rms error {np.std(estimate - recording.psi):.1e} rad")
            lines += above.plot(recording.t, estimate, "--", color=colour, label=f"torque {label}")
            below.plot(recording.t, 1e3 * (estimate - recording.psi), color=colour)
        above.set_ylabel("yaw angle ψ [rad]")
        below.set(ylabel="error [mrad]", xlabel="time [s]")
        figure.align_ylabels()
        legend_above(figure, lines)


def draw_friction(path: Path) -> None:
    """Figures 3.7, 6.1 and 6.2; prints the errors."""
    with figure_saved_as_png(path, 3.4) as figure:
        for axes, mu in zip(figure.subplots(1, 3), FACTORS, strict=True):
            recording = steered(mu)
            lines = [axes.axhline(mu, color=QUIET, label="true")]
            for case, label, colour in (
                (late(recording), "late", BEFORE),
                (recording, "in time", AFTER),
            ):
                estimate = mu_of(states_of(case))
                begin = np.abs(estimate - mu)[FIRST : round(SETTLED / DT)].max()
                print(
                    f"mu = {mu:g}: off by up to {begin:.4f} before {SETTLED} s;"
                    f" torque {label}: RMSE {rmse(recording, estimate):.4f}"
                )
                lines += axes.plot(recording.t, estimate, color=colour, label=f"torque {label}")
            axes.set(title=f"μ = {mu:g}", xlabel="time [s]", ylim=(0, 3 * mu))
        figure.axes[0].set_ylabel("friction coefficient μ [1]")
        legend_above(figure, lines)


def draw_roots(path: Path, recording: Recording) -> None:
    """Figure 3.8: f(mu) where it has a root, and where noise leaves it none."""
    case, tried = noisy(recording), np.linspace(0.02, 4.0, 400)
    settled = range(round(SETTLED / DT), recording.t.size)
    curves = {at: torque_curve(recording, at) for at in settled}
    f = {at: case.M_z[at] - np.array([curves[at](mu)[0] for mu in tried]) for at in settled}
    rootless = [at for at in settled if (f[at] > 0).all() or (f[at] < 0).all()]
    print(f"torque noise {NOISE:.0%} of range: no root in {len(rootless) / len(f):.0%} of the samples")
    with figure_saved_as_png(path, 3.4) as figure:
        for axes, at in zip(figure.subplots(1, 2), (settled[0], rootless[0]), strict=True):
            axes.plot(tried, f[at], color=AFTER)
            axes.axhline(0, color=MEASURED, ls="--", lw=0.8)
            axes.axvline(float(recording.tyre.mu or 0), color=QUIET)
            axes.set_title(f"t = {recording.t[at]:.2f} s: {'no root' if at in rootless else 'a root'}")
            axes.set(xlabel="tried μ [1]", ylabel="f(μ) [N m]")


def draw_causes(path: Path, recording: Recording) -> None:
    """Figure 3.9: what is wrong where, and why; prints where the torque hardly tells mu."""
    t, mu, states = recording.t, float(recording.tyre.mu or 0), states_of(recording)
    slide = full_slide_torque(LOAD, RIG.a)
    slope = np.array([abs(torque_curve(recording, at)(mu)[1]) for at in range(t.size)]) / slide
    reversals = t[1:][np.diff([state.zones.psi_max for state in states]) != 0]
    blind = (slope < BLIND) & (t > SETTLED)
    print(f"torque hardly tells mu: to {t[slope >= BLIND][0]:.2f} s,", end=" ")
    print(f"{t[blind][0]:.2f} to {t[blind][-1]:.2f} s; reversals at {reversals} s")
    with figure_saved_as_png(path, 3.6) as figure:
        axes = figure.subplots()
        artists = [axes.axhline(mu, color=QUIET, label="true")]
        for case, label, colour in ((late(recording), "late", BEFORE), (recording, "in time", AFTER)):
            artists += axes.plot(t, mu_of(states_of(case)), color=colour, label=f"torque {label}")
        artists.append(
            axes.fill_between(
                t, 0, 1, where=slope < BLIND, transform=axes.get_xaxis_transform(), color=QUIET,
                alpha=0.3, lw=0, label="torque hardly tells μ",
            )
        )  # fmt: skip
        for reversal in reversals:
            line = axes.axvline(reversal, color=TRACKS[2], ls="--", label="reversal")
        axes.set(ylabel="friction coefficient μ [1]", xlabel="time [s]", ylim=(0, 3 * mu))
        legend_above(figure, [*artists, line])


def draw_filter(path: Path, recording: Recording) -> None:
    """Figure 5.9: the filter (5.9) on estimates from a noisy torque; prints the errors."""
    with figure_saved_as_png(path, 3.6) as figure:
        axes = figure.subplots()
        artists = [axes.axhline(recording.tyre.mu, color=MEASURED, ls="--", lw=0.8, label="true")]
        for alpha, colour in zip((0.0, *ALPHAS), (QUIET, BEFORE, AFTER), strict=True):
            estimate = mu_of(states_of(noisy(recording), alpha))
            label = f"α = {alpha:g}" if alpha else "raw"
            print(f"torque noise {NOISE:.0%} of range, {label}: RMSE {rmse(recording, estimate):.4f}")
            artists += axes.plot(
                recording.t, estimate, color=colour, label=label, lw=1.2 if alpha else 3
            )
        axes.set(ylabel="friction coefficient μ [1]", xlabel="time [s]", ylim=(0, 2))
        legend_above(figure, artists)


def main() -> None:
    """Print every figure's numbers; the pictures go into the folder, if one is named."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "thesis_analytic")
    folder.mkdir(parents=True, exist_ok=True)
    slow = steered(0.5)
    draw_deformation(folder / "figure_3_4.png", slow)
    draw_angle(folder / "figure_3_6.png", slow)
    draw_friction(folder / "figure_3_7.png")
    draw_roots(folder / "figure_3_8.png", slow)
    draw_causes(folder / "figure_3_9.png", slow)
    draw_filter(folder / "figure_5_9.png", slow)


if __name__ == "__main__":
    main()
