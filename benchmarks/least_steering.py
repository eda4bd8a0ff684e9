"""How far must a wheel turn until friction is known? Plan and Probe against a sine and a ramp.

    python benchmarks/least_steering.py --runs 40
    python benchmarks/least_steering.py --runs 40 --fixed
    python benchmarks/least_steering.py --runs 40 --stated

The wheel is the independent rig's, on bristles. mu is log-uniform within bands of 0.05 to 1.2; half-
length, caster, load, k and the torque's zero of the truth are drawn from the tolerances of a rig that
was measured, declared with the noise to an observer with the tuning `clean`. k is a state of the
observer, not so with --fixed. The torque has white noise of 0.5 % of full slide at mu = 1, the angle
steps of 14 bits, and the wheel follows its command with a lag of 30 ms. With --stated the truth has the
other errors that the observer reckons with, too: of the model, a walk of the zero, and a scale of the
torque that hides in k.

Travel counts until the observer's own estimate is usable with sigma/mu within the target: along a path
over the prior that is planned beforehand (plan), led by a Probe until it says so (probe), along the plan
that knew mu
(known), in a sine of 0.4 rad at 0.3 rad/s at most, and a ramp at 0.1 rad/s to 0.5 rad. Error is that of
the estimate there, predicted its sigma/mu there.
"""

import argparse
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from benchmarks.ice import error_kept, gain_error
from observers import PROFILES, AligningTorque, Ekf, Loop, Plan, Probe, Sample, SteeringLimits, plan
from reference_rig import FOURTEEN_BIT_STEP, RigTyre, SteeredWheel
from symbolic import Model, Rig, Tolerances

GROUNDS = {"ice": (0.05, 0.1), "snow": (0.1, 0.3), "wet": (0.3, 0.7), "dry": (0.7, 1.2)}
"""Bands of mu, drawn in turn [1]."""
PATHS = ("plan", "probe", "known", "sine", "ramp")
LIMITS = SteeringLimits(angle=0.4, rate=0.5, time=6.0)
K, LOAD, DT, LAG, SLIDE = 2.4e6, 400.0, 0.01, 0.03, 6.75
OFF = {"a": 5e-4, "e": 5e-4, "load": 0.01, "k": 0.1, "zero": 0.03}
"""How far off lengths [m], load and k [1], and the zero over 3/8 F_N a, `SLIDE` [N m], may be."""
NOISE, MAX_TIME = 0.005, 12.0
FIRST_SEED = 200_000
"""Seeds below were used to choose constants."""
Command = Callable[[float, Sample, Any], tuple[float, bool]]
"""(time, sample, state of the observer) -> angle of the next sample, and whether it ends."""


@dataclass(frozen=True, kw_only=True)
class Reached:
    """Where the target was reached: travel [rad], time [s], error and sigma over mu [1]."""

    travel: float = np.nan
    time: float = np.nan
    error: float = np.nan
    predicted: float = np.nan


class RigWheel:
    """The rig's wheel as drawn, steered sample by sample."""

    def __init__(self, seed: int, mu: float, *, stated: bool = False) -> None:
        """Draw it."""
        self.rng, off = np.random.default_rng([seed, 3]), np.random.default_rng([seed, 7])
        self.off = {name: float(off.uniform(-most, most)) for name, most in OFF.items()}
        a, e, k = 0.045 + self.off["a"], 0.009 + self.off["e"], K * (1 + self.off["k"])
        load = LOAD * (1 + self.off["load"])
        self.late, self.stated = np.random.default_rng([seed, 8]), stated
        self.gain = 1 + stated * gain_error(self.late, self.off["k"], OFF["k"] / np.sqrt(3))
        self.error, self.walk = float(self.late.standard_normal()), 0.0
        self.wheel = SteeredWheel(RigTyre(a=a, e=e, k=k / self.gain, mu=mu), load=load)

    @property
    def psi(self) -> float:
        """Present angle [rad]."""
        return self.wheel.psi

    def follow(self, command: float) -> Sample:
        """The sample after a step toward the command."""
        before = self.psi
        M_z = self.wheel.turn(before + (command - before) * DT / (DT + LAG), DT)
        M_z = self._with_stated_errors(M_z, abs(self.psi - before)) if self.stated else M_z
        noise = SLIDE * (self.off["zero"] + NOISE * self.rng.standard_normal())
        psi = FOURTEEN_BIT_STEP * round(self.psi / FOURTEEN_BIT_STEP)
        return Sample(psi=psi, psi_dot=(self.psi - before) / DT, F_N=LOAD, dt=DT, M_z=M_z + noise)

    def _with_stated_errors(self, M_z: float, turned: float) -> float:
        """The torque [N m] with the scale, the model's error after a turn [rad], and the zero's walk."""
        tuning, (one, other) = PROFILES["clean"], self.late.standard_normal(2)
        kept = error_kept(turned, tuning)
        self.error = kept * self.error + np.sqrt(1 - kept**2) * one
        self.walk += SLIDE * tuning.zero_walk * np.sqrt(DT) * other
        return float(self.gain * M_z * (1 + tuning.error * self.error) + self.walk)


def observer_of(*, fixed: bool = False) -> Ekf:
    """The observer of the rig, with its tolerances; a fixed k is no state."""
    tolerances = Tolerances(**OFF | {"k": OFF["k"] * K, "zero": OFF["zero"] * SLIDE})
    return Ekf(
        model=Model(), values={"k": K}, tuning=PROFILES["clean"],
        rig=Rig(a=0.045, e=0.009, noise=NOISE * SLIDE, tolerances=tolerances),
        measurement_model=AligningTorque(stiffness=not fixed),
    )  # fmt: skip


@cache
def plan_over_grounds(fixed: bool, target: float) -> Plan:
    """The plan over the prior, the same for all wheels."""
    return plan(observer_of(fixed=fixed), target, LIMITS, LOAD)


@cache
def prepared(fixed: bool, target: float) -> Probe:
    """A Probe with its first plan, which is the same for all wheels; to be reset."""
    probe = Probe(observer_of(fixed=fixed), target, LIMITS)
    probe.prepare(LOAD)
    return probe


def steered(
    observer: Ekf, wheel: Any, mu: float, target: float, command: Command, *, decides: bool = False
) -> Reached:
    """A wheel under a command until the target is reached; by the command where that decides."""
    loop, angle, travel, step, t = Loop(observer), 0.0, 0.0, 0, 0.0
    while t < MAX_TIME:
        before = wheel.psi
        sample = wheel.follow(angle)
        travel += abs(wheel.psi - before)
        now = loop(sample)
        angle, ends = command(t, sample, loop.state)
        if now.usable and now.mu_std <= target * now.mu and (ends or not decides):
            return Reached(travel=travel, time=t, error=now.mu / mu - 1, predicted=now.mu_std / now.mu)
        step += 1
        t = step * sample.dt
        if ends:
            break
    return Reached()


def along(planned: Plan) -> Command:
    """Along a planned path, then to and fro as it ended."""
    path = planned.path
    far = max(np.abs(path.psi).max(), 0.02)
    swing = np.concatenate([path.psi, *[np.linspace(s * far, -s * far, 200) for s in (1, -1) * 4]])
    return lambda t, *_: (float(swing[min(round(t / path.dt), swing.size - 1)]), False)


def led(probe: Probe) -> Command:
    """As the probe says, from its begin."""
    probe.reset()

    def command(_: float, sample: Sample, state: Any) -> tuple[float, bool]:
        advice = probe(sample, state)
        return advice.psi, advice.stopped or advice.finished

    return command


def in_every_way(
    observer: Ekf, park: Callable[[], Any], mu: float, target: float, planned: Plan, probe: Probe,
    known: Plan, *, pulse: float,
) -> dict[str, Reached]:  # fmt: skip
    """Where the target is reached along each of `PATHS`, each with a wheel of its own.

    known is the plan for this mu, pulse the sine's [rad/s].
    """
    commands: tuple[Command, ...] = (
        along(planned),
        led(probe),
        along(known),
        lambda t, *_: (0.4 * np.sin(pulse * t), False),
        lambda t, *_: (min(0.1 * t, 0.5), t > 5),
    )
    return {
        name: steered(observer, park(), mu, target, command, decides=name == "probe")
        for name, command in zip(PATHS, commands, strict=True)
    }


def run(task: tuple[int, bool, float, bool]) -> tuple[float, dict[str, Reached]]:
    """One wheel, steered in every way."""
    seed, fixed, target, stated = task
    rng = np.random.default_rng([seed, 1])
    mu = float(np.exp(rng.uniform(*np.log([*GROUNDS.values()][seed % len(GROUNDS)]))))
    observer = observer_of(fixed=fixed)
    known = plan(observer, target, LIMITS, LOAD, mus=(mu,), coarse=True)
    plans = (plan_over_grounds(fixed, target), prepared(fixed, target), known)
    return mu, in_every_way(
        observer, lambda: RigWheel(seed, mu, stated=stated), mu, target, *plans, pulse=0.75
    )


def report(outcomes: Sequence[tuple[float, dict[str, Reached]]]) -> None:
    """The table, and the figures over all runs."""
    print(f"| ground | runs | {' | '.join(PATHS)} | probe over known | probe: error rms, predicted |")
    print("|---|---:|" + "---:|" * (len(PATHS) + 2))
    bands = [*GROUNDS.items(), ("all", (0.0, np.inf))]
    for ground, (low, high) in bands:
        of = [outcome for mu, outcome in outcomes if low <= mu < high]
        cells = []
        if not of:
            continue
        for name in PATHS:
            travels = np.array([one[name].travel for one in of])
            # Never is the most.
            median = np.median(np.nan_to_num(travels, nan=np.inf))
            missed = int(np.isnan(travels).sum())
            cells.append(f"{median:.3f}{f' ({missed} never)' if missed else ''}")
        ratios = np.array([one["probe"].travel / one["known"].travel for one in of])
        both = ratios[np.isfinite(ratios)]
        ratio = f"{np.median(both):.2f}" if both.size else "–"
        print(f"| {ground} | {len(of)} | {' | '.join(cells)} | {ratio} |"
              f" {honesty(of, 'probe')} |")  # fmt: skip
    everything = [outcome for _, outcome in outcomes]
    for name in PATHS:
        travels = np.array([one[name].travel for one in everything])
        known = travels[np.isfinite(travels)]
        turned = f"{known.mean():.3f} rad, worst {known.max():.3f} rad" if known.size else "–"
        beyond = [abs(one[name].error) > 3 * one[name].predicted for one in everything]
        print(
            f"{name}: mean travel {turned}, never {np.isnan(travels).sum()}, error rms, predicted"
            f" {honesty(everything, name)}, {sum(beyond)} beyond 3 sigma"
        )


def honesty(outcomes: Sequence[dict[str, Reached]], name: str) -> str:
    """Rms of the errors beside that of the predicted deviations; a dash where none reaches it."""
    errors, predicted = (
        np.array([getattr(one[name], of) for one in outcomes]) for of in ("error", "predicted")
    )
    if np.isnan(errors).all():
        return "–"
    rms = [100 * np.sqrt(np.nanmean(values**2)) for values in (errors, predicted)]
    return f"{rms[0]:.1f} %, {rms[1]:.1f} %"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--runs", type=int, default=40)
    parser.add_argument("--seed", type=int, default=FIRST_SEED, help="of the first run")
    parser.add_argument("--fixed", action="store_true", help="k is no state of the observer")
    parser.add_argument("--target", type=float, default=0.05)
    parser.add_argument("--stated", action="store_true", help="draw all errors that the observer states")
    given = parser.parse_args()
    tasks = [(given.seed + i, given.fixed, given.target, given.stated) for i in range(given.runs)]
    with ProcessPoolExecutor() as pool:
        report(list(pool.map(run, tasks)))


if __name__ == "__main__":
    main()
