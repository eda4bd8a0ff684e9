"""An observer of your own
=======================
"""

from pathlib import Path

import casadi as ca

from identification import read_recording, read_rig
from observers import CLEAN, OUTPUT, SAMPLE, AligningTorque, CasadiObserver, Layout, build_clean, run
from symbolic import SIGNALS, Model, effects_named

MODEL = Model(effects=effects_named(["rate_friction", "carcass_torsion"]))
VALUES = {"k": 2.4e6, "rate_friction.c": 0.04, "carcass_torsion.k_t": 390.0}
GAIN, DAMPING = 0.05, 3.0  # [1], [N m]: the gain is small where M_z hardly depends on mu


class ConstantGain(CasadiObserver):
    """A constant-gain filter on ln mu, made of two casadi Functions."""

    @property
    def layout(self) -> Layout:
        """Memory of the patch, last sample, ln mu, output."""
        sizes = (self.model.memory_size, len(CLEAN), 1, len(OUTPUT))
        names = ("memory", "last", "log_mu", "output")
        return Layout(tuple(zip(names, sizes, (1, 1, 1, 1), strict=True)))

    @property
    def initial_function(self) -> ca.Function:
        """The patch at rest, mu = 1 with a deviation of 0.5."""
        sample, constants = ca.MX.sym("sample", len(SAMPLE)), ca.MX.sym("c", self.constants.size)
        memory = self.model.initial(sample[: len(SIGNALS)], constants[:-2], constants[-2:])
        last = ca.vertcat(sample, 0, sample[SAMPLE.index("F_N")], 0)
        parts = {"memory": memory, "last": last, "output": self.output(mu=1, mu_std=0.5)}
        return ca.Function("own_start", [sample, constants], [self.layout.fill(parts)])

    @property
    def step_function(self) -> ca.Function:
        """One sample: predict M_z at the last mu, then correct ln mu along its slope."""
        sizes = (self.layout.size, len(SAMPLE), self.constants.size)
        state, sample, constants = symbols = [ca.MX.sym("s", size) for size in sizes]
        before = self.layout.split(state)
        now, _ = build_clean(AligningTorque())(sample, before["last"])
        theta = ca.vertcat(ca.exp(before["log_mu"]), constants[1:-2])
        memory, M_z = self.model.step(before["memory"], now[: len(SIGNALS)], theta, constants[-2:])
        slope, measured = ca.jtimes(M_z, state, self.layout.fill({"log_mu": 1})), now[CLEAN.index("M_z")]
        innovation = ca.if_else(ca.fabs(measured) < 1e9, measured - M_z, 0)
        log_mu = before["log_mu"] + GAIN * slope * innovation / (slope**2 + DAMPING**2)
        load, friction = now[CLEAN.index("F_N")], {"mu": ca.exp(log_mu), "mu_std": 0.1}
        output = self.output(memory, load, **friction, M_z_predicted=M_z)
        return ca.Function("own_step", symbols, [ca.vertcat(memory, now, log_mu, output), output])


def main() -> None:
    """Print the friction at the end of a recording."""
    folder = Path(__file__).resolve().parent / "recordings"
    recording = read_recording(folder / "holdout_c.csv", read_rig(folder / "rig.toml"))
    observer = ConstantGain(model=MODEL, values=VALUES, rig=recording.rig)
    end = run(observer, recording.t, recording.psi, recording.F_N, recording.M_z).mu[-1]
    print(f"constant gain: mu = {end:.3f} at the end, planted 1.370")


if __name__ == "__main__":
    main()
