"""`brushgrip plan`."""

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING

from brushgrip.commands.options import (
    EffectModules,
    ModelFile,
    RigAlone,
    TorqueMeasured,
    TuningProfile,
    TuningValues,
    VehicleAlone,
    option,
    output_file_option,
)
from brushgrip.inputs.option_choices import ModelObserverName, TorqueChannel

if TYPE_CHECKING:
    from observers import Plan
    from symbolic import Vehicle

Least = StrEnum("Least", {"TRAVEL": "travel", "TIME": "time", "ANGLE": "angle"})
OverPrior = StrEnum("OverPrior", {"WORST": "worst", "MEAN": "mean"})
"""What a user chooses from: what is least, and over which of the frictions."""


@dataclass(frozen=True, kw_only=True)
class PlanRequest:
    """Plan the least steering after which friction is known, whatever it is.

    Finds the path of the angle with the least travel (or time, or greatest angle) after which the
    observer's standard deviation of mu is within the target and usable, for the worst of the frictions
    of --mu or their mean. The deviation is that of the observer itself, with the tolerances of the rig
    file; for M_z with k as a state, which a little steering tells badly from mu. OUT.csv has a row a
    sample: t,psi,psi_dot,travel, F_N or, for a car, handwheel, and for each friction the deviation over
    mu, empty until it is usable. OUT.png shows both. What cannot be reached is told with its cause, and
    makes the exit status 1.
    """

    rig: RigAlone = None
    vehicle: VehicleAlone = None
    model: ModelFile = None
    effects: EffectModules = None
    target: str = option(
        "--target",
        "SHARE",
        "Standard deviation over mu, half of the 95 % band; 10% if left out.",
        default="10%",
    )
    limit: list[str] | None = option(
        "--limit",
        "NAME=VALUE",
        "What the wheel may do: angle=0.4 [rad, either way], rate=0.5 and slowest=0.05 [rad/s],"
        " torque [N m], time=10 [s], acceleration=10 [rad/s^2]. May be repeated; several may be"
        " separated by commas.",
    )
    load: float | None = option("--load", "N", "Vertical load [N]; needed with --rig, a car's is known.")
    mu: str | None = option(
        "--mu",
        "MU,...",
        "Frictions (mu_eff) that the ground may have; 0.05,0.1,0.2,0.4,0.8,1.2 if left out.",
    )
    least: Least = option(
        "--least", help="What is to be least.", default=Least.TRAVEL, show_default=True
    )
    over: OverPrior = option(
        "--over", help="Over the frictions.", default=OverPrior.WORST, show_default=True
    )
    observer: ModelObserverName = option(
        "--observer", help="Observer that estimates.", default=ModelObserverName.EKF, show_default=True
    )
    torque: TorqueMeasured = TorqueChannel.GROUND
    tuning: TuningProfile = None
    tune: TuningValues = None
    out: Path | None = output_file_option(
        "--out", "OUT.csv", "Table to write; OUT.png beside it shows it."
    )

    def run(self) -> None:
        """Write the path and say how far to turn on each ground."""
        from brushgrip.inputs.command_inputs import gather_inputs, staged_files_with_provenance
        from brushgrip.inputs.model_observer_from_options import model_observer_from_options
        from brushgrip.inputs.option_values import (
            chosen_limits,
            chosen_tuning,
            parse_frictions,
            parse_share,
            wheel_load,
        )
        from brushgrip.outputs.atomic import table_and_picture, write_utf8
        from brushgrip.outputs.console import print_line, progress
        from brushgrip.outputs.plan_texts import plan_csv, turning_instruction
        from brushgrip.pictures.plan import draw_plan_and_forecast
        from observers import aligning_torque_for, plan
        from observers.interfaces.observer_from_files import read_vehicle_file
        from observers.planning.forecast import assumed_torque_noise
        from observers.planning.plan_request_check import MUS

        limits, target = chosen_limits(self.limit), parse_share(self.target)
        mus = MUS if self.mu is None else parse_frictions(self.mu)
        tuning = chosen_tuning(self.tuning, self.tune)
        inputs = gather_inputs(
            rig=self.rig, model=self.model, effects=self.effects, vehicle=self.vehicle
        )
        of_wheel = self.vehicle is None and self.torque == "M_z"
        observer = model_observer_from_options(
            self.observer, self.torque, inputs, tuning, stiffness_state=of_wheel or None
        )
        car = read_vehicle_file(self.vehicle) if self.vehicle else None
        F_N = wheel_load(car, self.load)
        finals = table_and_picture(self.out)
        settings = {
            "target": target, "limits": vars(limits), "load": F_N, "mu": list(mus),
            "least": self.least.value, "over": self.over.value, "observer": self.observer.value,
            "torque": self.torque.value, "tuning": tuning and tuning.to_dict(),
        }  # fmt: skip
        with staged_files_with_provenance(inputs, finals, settings) as stages, progress() as report:
            planned = plan(
                observer, target, limits, F_N, mus=mus, objective=self.least.value, over=self.over.value,
                progress=report,
            )  # fmt: skip
            if stages:
                write_utf8(stages[0], plan_csv(planned, car, F_N))
                draw_plan_and_forecast(stages[1], planned)
        print_line(turning_instruction(planned, car, inputs.signals.of("psi")))
        asked = of_wheel and not aligning_torque_for(inputs.read_found_model()).stiffness
        self._print_plan(planned, finals, car, assumed_torque_noise(observer, F_N), counts_k=asked)

    def _print_plan(
        self, planned: "Plan", finals: list[Path], car: "Vehicle | None", noise: float, *, counts_k: bool
    ) -> None:
        """Print what the plan tells on each ground; a target that is missed on one is a fault."""
        from brushgrip.estimation.friction_budget import declared_uncertainty_text
        from brushgrip.outputs.console import print_line, print_table, show_json
        from brushgrip.outputs.plan_texts import plan_document, rows_by_ground
        from observers.planning.forecast import ENOUGH, RUNS
        from symbolic import BrushgripError

        of, unit = ("handwheel, ", "deg") if car else ("", "rad")
        headings = ("mu", f"{of}travel [{unit}]", "time [s]", f"{of}angle [{unit}]", "sigma/mu")
        title = f"until sigma/mu is {planned.target:.1%} (95 % band ± {2 * planned.target:.0%} of mu)"
        if counts_k:
            print_line("k counts as a state: give estimate, and codegen, --stiffness-state too")
        print_table(title, headings, rows_by_ground(planned, car), right=True)
        print_line("one path for all grounds: on most its first turns do; stop once friction is as good")
        if planned.reasons:
            runs = f"fewer than {ENOUGH} of {RUNS} simulated runs"
            print_line(f"a dash: with noise in {runs}; sigma/mu is there the least without noise")
        else:
            of_torque = "" if car else f" of {noise:.2g} N m"
            print_line(
                f"this is enough in {ENOUGH} of {RUNS} simulated runs, noise{of_torque} on the torque"
            )
        if car:
            if declared := declared_uncertainty_text(car, brakes=car.brakes):
                print_line(declared)
            print_line("this is for a car as declared; off within its tolerances it may take more")
        elif self.model is None:
            print_line(
                "this is for the declared model: plan with --model where brushgrip diagnose found one"
            )
        for reason in planned.reasons:
            print_line(reason)
        if finals:
            print_line(f"wrote {' and '.join(map(str, finals))}")
        show_json(plan_document(planned))
        if planned.reasons:
            missed = (mu for mu, at in zip(planned.mus, planned.reached, strict=True) if at is None)
            raise BrushgripError(
                f"no path within the limits reaches {planned.target:.1%} in {ENOUGH} of {RUNS} simulated"
                f" runs on mu = {', '.join(f'{mu:g}' for mu in missed)}; the best one was found"
            )
