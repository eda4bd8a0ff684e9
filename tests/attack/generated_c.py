"""Generated C on samples without end: random bytes, a wheel at random, and then a sane one.

After every round the wheel turns to and fro as the model says, at a known friction, quickly and slowly
in turn, until the estimate is back; on this way it never may be usable and more than three deviations
off. Where it takes more than 10 s, the round counts as late: the zero of the torque channel, to which no
change of the ground gives a new variance, may have been dragged away. It never may take 2 min.
After a first load of twenty times the size all others count as missing, as documented: there the
observer is reset, as an application has to.
"""

from collections.abc import Iterator
from functools import partial
from itertools import count
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import numpy as np

from observers import AligningTorque, Ekf, Mhe, Status, SteeringTorque
from observers.embedded import SINGLE
from symbolic import compiler, simulate
from tests.attack.attack_class import Effort, Tried
from tests.attack.workplace import workplace
from tests.observers.conftest import RIG
from tests.observers.embedded.generated_code import (
    DECLARED,
    EFFECTS,
    ESTIMATE,
    FOUND,
    MEASURED_RUN,
    NO_COMPILER,
    RunningCode,
    generate_code,
    observer_of,
)

ROUND = 20_000
"""Samples between two checks that the estimate comes back, half of each kind."""
USUAL = [0.5, 1.0, 8.0, 400.0, 0.01]
TURN = 0.06
"""Of the wheel at random in a sample [rad]: within the limit of the rate."""
SANE = 1000
"""Samples of 10 s."""
PATIENCE = 12
"""How often these are given before the estimate has to be back."""
MU, NEAR = 0.9, 0.1
FREQUENCIES = (0.4, 0.1)
"""Of the turning to and fro, whole periods in `SANE` samples [Hz]."""
MODELS = {
    "declared": DECLARED, "torsion_rate": EFFECTS, "torsion_creep": FOUND, "measured_run": MEASURED_RUN
}  # fmt: skip
SENSING = {"aligning": AligningTorque(), "steering": SteeringTorque()}


def sane(observer: Any, frequency: float) -> np.ndarray:
    """Samples (n, 5) of a wheel that turns through its full slide, without noise.

    It has turned for as long before, so that friction that drifts with the turn has come to rest.
    """
    t = np.arange(2 * SANE) * USUAL[4]
    pulse = 2 * np.pi * frequency
    psi, rate = 0.35 * np.sin(pulse * t), 0.35 * pulse * np.cos(pulse * t)
    load = np.full(t.size, USUAL[3])
    signals = np.stack([psi, rate, load, np.full(t.size, USUAL[4])])
    theta = np.array(observer.model.theta({"mu": MU, **observer.values})).ravel()
    torque = simulate(observer.model, signals, theta, np.array([RIG.a, RIG.e])).M_z
    if observer.channel == "M":
        torque = -RIG.J_A * pulse**2 * psi + RIG.b_t * rate - torque
    return np.column_stack([psi, rate, torque, load, signals[3]])[SANE:]


def endure(kind: type[Ekf] | type[Mhe], model: str, sensing: str, effort: Effort) -> Iterator[Tried]:
    """One observer; inputs are samples."""
    if compiler() is None:
        yield Tried(0, note=f"({NO_COMPILER})")
        return
    observer = observer_of(kind, MODELS[model], SENSING[sensing])
    # Of its own: a library that is loaded must not be written over.
    folder = Path(mkdtemp(dir=workplace()))
    running = RunningCode(generate_code(observer, SINGLE, folder))
    drives = [sane(observer, frequency) for frequency in FREQUENCIES]
    seed, late, longest = effort.seed + 1, 0, 0
    for rounds in count(1):
        invalid = running.fuzz(ROUND // 2, seed, USUAL)[0]
        invalid += running.wander(ROUND // 2, seed, USUAL, TURN)
        if invalid:
            yield Tried(0, f"seed {seed}: {invalid} invalid estimates")
        attempts, is_back = 0, False
        while attempts < PATIENCE and not is_back:
            estimates = running.run(drives[rounds % len(drives)])
            last, wrong = estimates[-1], _usable_and_wrong(estimates)
            if wrong:
                yield Tried(
                    0, f"seed {seed}: usable and beyond 3 deviations in {wrong} of {SANE} samples"
                )
            attempts, is_back = attempts + 1, bool(abs(last[0] / MU - 1) < NEAR and last[3] == 1)
            if int(last[-1]) & Status.HELD:
                running.reset()
        away = f"seed {seed}: after {PATIENCE * 10} s mu is {last[0]:.3f}, not {MU}"
        late, longest = late + (attempts > 1), max(longest, attempts)
        samples, note = ROUND + attempts * SANE, f"(late in {late} of {rounds} rounds, {longest * 10} s)"
        yield Tried(samples, None if is_back else away, note)
        seed += samples


def _usable_and_wrong(estimates: np.ndarray) -> int:
    mu, std, usable = (estimates[:, ESTIMATE.index(name)] for name in ("mu", "mu_std", "usable"))
    return int(np.count_nonzero((usable == 1) & (np.abs(mu - MU) > 3 * std)))


CLASSES = {
    f"c_{kind.__name__.lower()}_{model}_{sensing}": partial(endure, kind, model, sensing)
    for model in MODELS
    for sensing in SENSING
    for kind in (Ekf, Mhe)
}
"""Each observer, model and torque in single precision."""
