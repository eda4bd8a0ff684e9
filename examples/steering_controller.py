"""A steering controller that knows the friction
=============================================

Turn a wheel at standstill along a reference, friction compensated by what an observer says of it.

The closed loop is python-control's: a wheel with inertia on a contact patch, state feedback by LQR, and
the observer as one more system. The compensation asks the brush model for the aligning torque of the
reference on a ground of friction mu. The controller does not know the ground; it guesses mu, or acts on
the mu_eff of an observer, who has an encoder and a torque sensor. The wheel stands on the very model
that controller and observer use: the figures show what knowing mu is worth, not what a wrong model
costs.
"""

from functools import cache

import control
import numpy as np

from observers import Ekf, Sample, SteeringTorque, Tuning
from observers.interfaces.control_system import as_system
from symbolic import Model, Rig, compiled, simulate

STEP, SECONDS = 1e-3, 4.0
RIG = Rig(a=0.045, e=0.009, J_A=0.15, b_t=1.0)
GEOMETRY, LOAD, K = np.array([RIG.a, RIG.e]), 400.0, 2.4e6
GROUND, GUESS = 0.6, 1.0
ENCODER, NOISE = 2 * np.pi / 2**14, 0.03
"""Step of the encoder [rad]; standard deviation of the torque sensor [N m]."""
MODEL = Model()
PATCH = compiled(MODEL.step)
EKF = Ekf(
    model=MODEL,
    values={"k": K},
    rig=RIG,
    tuning=Tuning(mu=GUESS, noise=0.03, error=float("inf")),
    measurement_model=SteeringTorque(),
)
KNOWN = 1.0
"""Time after which friction has been found [s]; the controller acts on a guess before."""
MUS = np.linspace(0.05, 3.0, 60)


@cache
def reference() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Time [s], angle, rate and acceleration of a sway that begins gently, at every step."""
    t = np.arange(round(SECONDS / STEP)) * STEP
    psi = (1 - np.exp(-(t**2) / 0.1)) * (0.25 * np.sin(2.0 * t) + 0.1 * np.sin(5.0 * t))
    rate = np.gradient(psi, STEP)
    return t, psi, rate, np.gradient(rate, STEP)


@cache
def reference_torques() -> np.ndarray:
    """M_z of the whole reference on grounds of every friction in `MUS`, one column each [N m]."""
    t, psi, rate, _ = reference()
    signals = np.vstack([psi, rate, np.full(t.size, LOAD), np.full(t.size, STEP)])
    torques = [simulate(MODEL, signals, np.array([mu, K]), GEOMETRY).M_z for mu in MUS]
    return np.array(torques).T


def wheel() -> control.NonlinearIOSystem:
    """The wheel on the ground, J_A psi'' = -b_t psi' + M_z + M, with its encoder and torque sensor."""

    def update(_t: float, x: np.ndarray, u: np.ndarray, _params: object) -> np.ndarray:
        psi, rate, M_z = x[:3]
        rate += STEP / RIG.J_A * (u[0] + M_z - RIG.b_t * rate)
        psi += STEP * rate
        memory, M_z = PATCH(x[3:], [psi, rate, LOAD, STEP], [GROUND, K], GEOMETRY)
        return np.array([psi, rate, float(M_z), *memory.full().ravel()])

    def output(_t: float, x: np.ndarray, u: np.ndarray, _params: object) -> np.ndarray:
        return np.array([x[0], round(x[0] / ENCODER) * ENCODER, u[0] + u[1]])

    return control.nlsys(
        update, output, inputs=["M_motor", "noise"], outputs=["angle", "psi", "M"],
        states=3 + MODEL.memory_size, dt=STEP, name="wheel",
    )  # fmt: skip


def controller(compensates: bool) -> control.NonlinearIOSystem:
    """State feedback, and the torque that the reference takes, that against the ground only if asked.

    It acts on mu_eff where that is usable; else on the last that was, and on the guess before.
    """
    (_, psi_ref, rate_ref, acceleration_ref), M_z_ref = reference(), reference_torques()
    on_psi, on_rate = gains()
    new = STEP / (0.01 + STEP)

    def rate_of(x: np.ndarray, psi: float) -> float:
        return x[1] + new * ((psi - x[0]) / STEP - x[1])

    def mu_of(x: np.ndarray, u: np.ndarray) -> float:
        return float(u[1] if u[2] else x[2] or GUESS)

    def update(_t: float, x: np.ndarray, u: np.ndarray, _params: object) -> np.ndarray:
        return np.array([u[0], rate_of(x, u[0]), mu_of(x, u)])

    def output(t: float, x: np.ndarray, u: np.ndarray, _params: object) -> np.ndarray:
        at = round(t / STEP)
        M = on_psi * (psi_ref[at] - u[0]) + on_rate * (rate_ref[at] - rate_of(x, u[0]))
        M += RIG.J_A * acceleration_ref[at] + RIG.b_t * rate_ref[at]
        mu = mu_of(x, u)
        return np.array([M - np.interp(mu, MUS, M_z_ref[at]) if compensates else M, mu])

    return control.nlsys(
        update, output, inputs=["psi", "mu_eff", "usable"], outputs=["M_motor", "mu_used"],
        states=3, dt=STEP, name="controller",
    )  # fmt: skip


def gains() -> np.ndarray:
    """LQR gains on angle and rate of the wheel off the ground: 0.05 rad and 1 rad/s weigh like 2 N m."""
    free = control.ss([[0, 1], [0, -RIG.b_t / RIG.J_A]], [[0], [1 / RIG.J_A]], np.eye(2), 0)
    weights = np.diag([1 / 0.05**2, 1 / 1.0**2]), np.array([[1 / 2.0**2]])
    return np.asarray(control.dlqr(control.sample_system(free, STEP), *weights)[0]).ravel()


def observer() -> control.NonlinearIOSystem:
    """Friction by the sensors, up to the last sample: the torque of this one is yet to be chosen."""
    return as_system(EKF, Sample(psi=0.0, psi_dot=0.0, F_N=LOAD, dt=STEP), direct=False)


def run(compensates: bool = True, mu: float | None = None) -> tuple[float, float, float]:
    """The rms of the tracking error, of all and after `KNOWN` [rad], and the last mu; None: observed."""
    t, psi_ref, *_ = reference()
    inputs = {"noise": NOISE * np.random.default_rng(1).standard_normal(t.size)}
    parts = [wheel(), controller(compensates)]
    if mu is None:
        parts.append(observer())
        inputs["F_N"] = np.full(t.size, LOAD)
    else:
        inputs |= {"mu_eff": np.full(t.size, mu), "usable": np.ones(t.size)}
    loop = control.interconnect(
        parts, inputs=list(inputs), outputs=["angle", "mu_used"], check_unused=False
    )
    response = control.input_output_response(loop, t, np.array(list(inputs.values())))
    squares = (response.outputs[0] - psi_ref) ** 2
    after = float(np.sqrt(np.mean(squares[t > KNOWN])))
    return float(np.sqrt(np.mean(squares))), after, float(response.outputs[1, -1])


def main() -> None:
    """Track the reference with different knowledge of the ground, and print the rms error of each."""
    tries = {
        "friction not compensated": run(compensates=False, mu=GUESS),
        f"compensated, mu guessed as {GUESS:.2f}": run(mu=GUESS),
        "compensated, mu_eff by the observer": run(),
        f"compensated, mu known as {GROUND:.2f}": run(mu=GROUND),
    }
    for name, (error, after, _) in tries.items():
        print(f"{name}: {1000 * error:.2f} mrad rms, {1000 * after:.2f} after the first second")
    print(f"the observer's mu_eff at the end: {tries['compensated, mu_eff by the observer'][2]:.3f}")


if __name__ == "__main__":
    main()
