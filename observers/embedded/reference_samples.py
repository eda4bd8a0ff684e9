"""Reference samples for generated code, and the estimates of `observers.Loop` for them."""

from math import isfinite, nan

import numpy as np

from observers.embedded.generated_file_overwriting import file_mark
from observers.embedded.scalar_type import Real
from observers.interfaces.control_loop import Loop
from observers.protocol import ESTIMATE, FunctionObserver, Sample
from symbolic import simulate
from symbolic.float_array_type import Array

INPUTS = ("psi", "psi_dot", "M_z", "M", "F_N", "dt")
COUNT, SAMPLE_PERIOD, SEED = 400, 0.01, 20
COMMENT = """\
Simulated with the observer's own model at mu = {mu:g}: a hand's path with nested reversals, a load that
swings by a tenth, torque noise of 0.4 % of range (seed {seed}), sensor faults, no angle in the first two
samples. Expected are the estimates of observers.Loop in Python, in double precision."""


def reference_csv(observer: FunctionObserver, real: Real) -> str:
    """The samples and the expected estimates as CSV, with the one torque that the observer uses."""
    samples = real.round(reference_samples(observer))
    inputs = [name for name in INPUTS if name not in {"M_z", "M"} - {observer.channel}]
    loop = Loop(observer)
    sequence = (Sample(**dict(zip(INPUTS, column, strict=True))) for column in samples.T.tolist())
    expected = np.array([loop(sample).numbers for sample in sequence]).T
    columns = [*(samples[INPUTS.index(name)] for name in inputs), *expected]
    comment = COMMENT.format(mu=reference_sample_friction(observer), seed=SEED).splitlines()
    lines = [f"# {file_mark()}", *(f"# {line}" for line in comment), ",".join((*inputs, *ESTIMATE))]
    lines += [",".join(_number_text(v, real) for v in row) for row in zip(*columns, strict=True)]
    return "\n".join(lines) + "\n"


def reference_samples(observer: FunctionObserver) -> Array:
    """Samples that take the wheel through its zones, rows as in `INPUTS`, shape (6, n)."""
    rig, rng = observer.rig, np.random.default_rng(SEED)
    t = SAMPLE_PERIOD * np.arange(COUNT)
    amplitude = np.minimum(t, 1.5) / 1.5
    psi = amplitude * (0.2 * np.sin(2 * np.pi * 0.5 * t) + 0.08 * np.sin(2 * np.pi * 1.7 * t))
    # The load at which the patch slides at about a tenth of a radian, whatever its size.
    F_N = 2 * observer.values["k"] * rig.a**3 * (1 + 0.1 * np.sin(2 * np.pi * 0.9 * t))
    rate, dt = np.gradient(psi, SAMPLE_PERIOD), np.full(COUNT, SAMPLE_PERIOD)
    theta = observer.model.theta({**observer.values, "mu": reference_sample_friction(observer)})
    signals, geometry = np.vstack([psi, rate, F_N, dt]), np.array([rig.a, rig.e])
    M_z = simulate(observer.model, signals, np.asarray(theta).ravel(), geometry).M_z
    M = -M_z
    if observer.channel == "M":
        M = M + (rig.b_t or 0.0) * rate + (rig.J_A or 0.0) * np.gradient(rate, SAMPLE_PERIOD)
    noise = 0.004 * np.ptp(M_z) * rng.standard_normal((2, COUNT))
    samples = np.vstack([psi, rate, M_z + noise[0], M + noise[1], F_N, dt])
    samples[1, COUNT // 2 :] = nan
    samples[:4, :2] = nan
    samples[:5, 150:155], samples[2:4, 200:220] = nan, nan
    samples[2, 250], samples[4, 260:264], samples[0, 300] = np.inf, nan, nan
    return samples


def reference_sample_friction(observer: FunctionObserver) -> float:
    """The friction coefficient of the samples, a little above that of the prior."""
    return 1.2 * observer.prior.mu


def _number_text(value: float, real: Real) -> str:
    if isfinite(value) and value == int(value):
        return str(int(value))
    return f"{value:.{real.digits}g}"
