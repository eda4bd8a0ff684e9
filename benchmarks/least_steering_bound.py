"""The least travel after which any estimate can know friction: an NLP over paths of three branches.

    python benchmarks/least_steering_bound.py

The wheel is that of `least_steering`. The torque is the exact patch's, by Masing's rules; ln mu, k,
half-length, caster, load and the torque's zero are unknowns with the variances of their tolerances; the
bound is that of [van Trees 1968], its Jacobian casadi's. The path turns at 0.0625 rad/s to a first
angle, back by a second turn and on by a third. Travel is least for a standard deviation of mu of 5 %:
with the sensor's noise alone, and with the error of the model that the observer reckons with, by
independent samples of a branch. Beside it, on the path of `plan`: the travel at which the observer's own
deviation is within the target, and that at which it is usable too, as its model is confirmed; between
them the least travel that the rule of confirmation alone allows on any path.
"""

import casadi as ca
import numpy as np

from benchmarks.least_steering import DT, LIMITS, LOAD, NOISE, OFF, SLIDE, K, observer_of
from observers import plan
from observers.quality.acquisition_and_tracking import CONFIRMS
from observers.quality.hysteresis_branches import FRACTION, START, sliding_onset_turn
from observers.quality.slow_change_and_misfit_alarms import FORGETTING_SAMPLES, MIN_SAMPLES
from symbolic import virgin_torque
from symbolic.rig_and_tyre import EVEN

GROUNDS, TARGET, RATE, NODES = (0.05, 0.2, 0.5, 0.9), 0.05, 0.0625, 24
VAGUE = 2.0
"""Standard deviation of ln mu before any torque [1]."""
STARTS = ((1.0, 1.0, 0.1), (1.0, 1.9, 0.5))
"""Branches that the NLP begins with, over the turn at which the patch begins to slide [1]."""


def variance(mu: float, turns: ca.MX, error: float, least: float) -> ca.MX:
    """Least variance of ln mu after the turns of three branches [rad]."""
    p = ca.MX.sym("p", 6)  # ln mu, ln k, a, e, ln load, zero
    stds = np.array(
        [VAGUE, *(EVEN * OFF[name] for name in ("k", "a", "e", "load")), EVEN * OFF["zero"] * SLIDE]
    )
    at = ca.DM([np.log(mu), np.log(K), 0.045, 0.009, np.log(LOAD), 0.0])
    given = (ca.exp(p[4]), ca.exp(p[0]), ca.exp(p[1]), p[2], p[3])
    places, weights = np.polynomial.legendre.leggauss(NODES)
    torques, shares, counts, before = [], [], [], 0
    for order, turn in enumerate(ca.vertsplit(turns)):
        # Even in the logarithm of the branch's turn, from which independent samples count.
        log = ca.log(turn / least)
        way = least * ca.exp(log * (places + 1) / 2)
        step = weights / 2 * log
        scale = 1 if order == 0 else 2
        side = (-1) ** order
        each = [scale * side * virgin_torque(way[i] / scale, *given) for i in range(NODES)]
        torques += [before + one + p[5] for one in each]
        before = before + scale * side * virgin_torque(turn / scale, *given)
        shares.append(step / FRACTION)
        counts.append(step * way / (RATE * DT))
    M, share, count = ca.vertcat(*torques), ca.vertcat(*shares), ca.vertcat(*counts)
    weight = 1 / ((NOISE * SLIDE) ** 2 / count + (error * M) ** 2 / share)
    J = ca.jacobian(M, p)
    information = ca.diag(stds**-2.0) + J.T @ (J * ca.repmat(weight, 1, 6))
    return ca.substitute(ca.inv(information)[0, 0], p, at)


def least_turns(mu: float, error: float, least: float) -> np.ndarray:
    """Turns of the path with the least travel that reaches the target [rad]."""
    turns = ca.MX.sym("turns", 3)
    unit = 3 * LOAD * mu / (4 * 0.045**2 * K)
    bound = variance(mu, unit * turns, error, least)
    problem = {
        "x": turns,
        "f": ca.sum1(turns),
        "g": ca.vertcat(
            ca.log(bound) / 2 - np.log(TARGET), 2 * turns[0] - turns[1], turns[1] - turns[2]
        ),
    }
    options = {"ipopt.print_level": 0, "print_time": 0, "ipopt.sb": "yes", "ipopt.max_iter": 300}
    solver = ca.nlpsol("least", "ipopt", problem, options)
    low = 1.02 * least / unit
    found = []
    for start in STARTS:
        got = solver(x0=start, lbx=low, ubx=8.0, lbg=[-ca.inf, 0, 0], ubg=[0, ca.inf, ca.inf])
        if solver.stats()["success"]:
            found.append((float(got["f"]), np.array(got["x"]).ravel() * unit))
    return min(found, key=lambda one: one[0])[1] if found else np.full(3, np.nan)


def least_confirmed(mu: float) -> float:
    """Least travel with which the supervision confirms a model, whatever the path [rad].

    A branch counts by the logarithm of its turn from `CONFIRMS` of the turn at which the patch begins
    to slide; so many independent samples as make `MIN_SAMPLES` while older ones are forgotten are
    spread evenly over some branches.
    """
    counts_from = CONFIRMS * float(sliding_onset_turn(mu, LOAD, [K, 0.045, 0.009]))
    samples = FORGETTING_SAMPLES * np.log(FORGETTING_SAMPLES / (FORGETTING_SAMPLES - MIN_SAMPLES))
    return min(n * counts_from * float(np.exp(samples * FRACTION / n)) for n in range(1, 6))


def main() -> None:
    """Print the table."""
    observer = observer_of()
    tuning = observer.effective_tuning
    print("| mu | noise alone | with the model's error | its turns | deviation | confirmed | usable |")
    print("|---|---:|---:|---|---:|---:|---:|")
    for mu in GROUNDS:
        by_noise, by_error = (
            least_turns(mu, error, START * tuning.psi_noise) for error in (0.0, tuning.error)
        )
        planned = plan(observer, TARGET, LIMITS, LOAD, mus=(mu,))
        known = planned.path.travel[int(np.argmax(planned.forecasts[0].deviation <= TARGET))]
        turns = ", ".join(f"{turn:.3f}" for turn in by_error)
        print(f"| {mu} | {by_noise.sum():.3f} | {by_error.sum():.3f} | {turns} | {known:.3f} |"
              f" {least_confirmed(mu):.3f} | {planned.travels_to_target[0]:.3f} |",
              flush=True)  # fmt: skip


if __name__ == "__main__":
    main()
