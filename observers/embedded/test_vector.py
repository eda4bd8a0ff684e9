"""Samples to try generated code on, and what Python makes of them."""

from math import isfinite, nan

import numpy as np
from numpy.typing import NDArray

from observers.embedded.scalar_type import Real
from observers.loop import Loop
from observers.protocol import FunctionObserver, Sample
from symbolic import simulate

Array = NDArray[np.float64]
COLUMNS = (
    "psi",
    "psi_dot",
    "M_z",
    "M",
    "F_N",
    "dt",
    "mu",
    "mu_std",
    "M_z_predicted",
    "informed",
    "status",
)
"""Columns of `made_vector`: a sample, then what is expected after it."""
COUNT, STEP, SEED = 400, 0.01, 20
SAID = """Made from the model itself at mu = {mu:g}: a hand's path with reversals inside reversals, a
load that swings by a tenth, torque noise of 0.4 % of range (seed {seed}). Sensors fail as they may, and
the first two samples have no angle. Expected is what observers.Loop says in Python, in double."""


def made_vector(observer: FunctionObserver, real: Real) -> Array:
    """Samples and what `observers.Loop` says after each, rows as in `COLUMNS`, numbers of the type."""
    samples = real.round(made_samples(observer))
    loop = Loop(observer)
    said = []
    for psi, psi_dot, M_z, M, F_N, dt in samples.T.tolist():
        now = loop(Sample(psi=psi, psi_dot=psi_dot, M_z=M_z, M=M, F_N=F_N, dt=dt))
        said.append([now.mu, now.mu_std, now.M_z_predicted, now.informed, int(now.status)])
    return np.vstack([samples, np.array(said, dtype=float).T])


def made_samples(observer: FunctionObserver) -> Array:
    """Samples that turn the wheel through its zones, rows psi, psi_dot, M_z, M, F_N, dt."""
    rig, rng = observer.rig, np.random.default_rng(SEED)
    t = STEP * np.arange(COUNT)
    reach = np.minimum(t, 1.5) / 1.5
    psi = reach * (0.2 * np.sin(2 * np.pi * 0.5 * t) + 0.08 * np.sin(2 * np.pi * 1.7 * t))
    # So much load that the patch slides at about a tenth of a radian, whatever its size.
    F_N = 2 * observer.values["k"] * rig.a**3 * (1 + 0.1 * np.sin(2 * np.pi * 0.9 * t))
    rate = np.gradient(psi, STEP)
    dt = np.full(COUNT, STEP)
    theta = np.asarray(
        observer.model.theta({**observer.values, "mu": vector_friction(observer)})
    ).ravel()
    M_z = simulate(observer.model, np.vstack([psi, rate, F_N, dt]), theta, np.array([rig.a, rig.e])).M_z
    M = -M_z
    if observer.channel == "M":
        M = M + (rig.b_t or 0.0) * rate + (rig.J_A or 0.0) * np.gradient(rate, STEP)
    noise = 0.004 * np.ptp(M_z) * rng.standard_normal((2, COUNT))
    samples = np.vstack([psi, rate, M_z + noise[0], M + noise[1], F_N, dt])
    samples[1, COUNT // 2 :] = nan
    samples[:4, :2] = nan
    samples[:, 150:155], samples[2:4, 200:220] = _only_dt(), nan
    samples[2, 250], samples[4, 260:264], samples[0, 300] = np.inf, nan, nan
    return samples


def vector_friction(observer: FunctionObserver) -> float:
    """Friction at which the samples are simulated: a little more than that of the prior."""
    return 1.2 * observer.prior.mu


def vector_text(observer: FunctionObserver, real: Real, torque: str) -> str:
    """The samples and what is expected of them as a table; `torque` names the one that is measured."""
    made = made_vector(observer, real)
    names = [name for name in COLUMNS if name not in {"M_z", "M"} - {torque}]
    rows = [made[COLUMNS.index(name)].tolist() for name in names]
    said = SAID.format(mu=vector_friction(observer), seed=SEED).splitlines()
    lines = [*(f"# {line}" for line in said), ",".join(names)]
    lines += [",".join(_number(v, real) for v in row) for row in zip(*rows, strict=True)]
    return "\n".join(lines) + "\n"


def _only_dt() -> Array:
    """A sample whose sensors are all silent."""
    return np.array([[nan]] * 5 + [[STEP]])


def _number(value: float, real: Real) -> str:
    if value == int(value) if isfinite(value) else False:
        return str(int(value))
    return f"{value:.{real.digits}g}"
