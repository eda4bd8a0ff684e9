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

    layout = Layout.of(memory=MODEL.memory_size, last=len(CLEAN), log_mu=1, output=len(OUTPUT))

    @property
    def initial_function(self) -> ca.Function:
        """The patch at rest, mu = 1 with a deviation of 1."""
        sample, constants = ca.MX.sym("sample", len(SAMPLE)), ca.MX.sym("c", self.constants.size)
        memory = self.model.initial(sample[: len(SIGNALS)], constants[:-2], constants[-2:])
        first = dict(zip(SAMPLE, ca.vertsplit(sample), strict=True))
        first["F_N_first"] = first["F_N"]
        last, output = ca.vertcat(*(first.get(n, 0) for n in CLEAN)), self.output(mu=1, mu_std=1)
        return ca.Function("own_start", [sample, constants], [ca.vertcat(memory, last, 0, output)])

    @property
    def step_function(self) -> ca.Function:
        """One sample: predict M_z at the last mu, then correct ln mu along its slope."""
        numbers = (self.layout.size, len(SAMPLE), self.constants.size)
        state, sample, constants = symbols = list(map(ca.MX.sym, "sxc", numbers))
        before = self.layout.split(state)
        now, _ = build_clean(AligningTorque())(sample, before["last"])
        theta = ca.vertcat(ca.exp(before["log_mu"]), constants[1:-2])
        memory, M_z = self.model.step(before["memory"], now[: len(SIGNALS)], theta, constants[-2:])
        slope, measured = (
            ca.jtimes(M_z, state, self.layout.join_missing_as_zero({"log_mu": 1})),
            now[CLEAN.index("M_z")],
        )
        innovation = ca.if_else(ca.fabs(measured) < 1e9, measured - M_z, 0)
        log_mu = before["log_mu"] + GAIN * slope * innovation / (slope**2 + DAMPING**2)
        known = {"mu": ca.exp(log_mu), "mu_std": 0.1, "M_z_predicted": M_z}
        output = self.output(memory, now[CLEAN.index("F_N")], **known)
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
