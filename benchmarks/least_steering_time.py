"""How long does a Probe block its caller? Processor time of its first plan, and of a new one.

    python benchmarks/least_steering_time.py

The rig's wheel of `least_steering` and a car of `least_steering_car`, led on ice, snow, wet and dry
ground, once each by an Ekf and on the rig by an Mhe. A new plan is made every 0.1 s of steering; the
first one is made by `Probe.prepare`, after everything is compiled. Beside them stand all other samples.
"""

import gc
from collections.abc import Callable
from time import process_time
from typing import Any

import numpy as np

from benchmarks import least_steering as rig
from benchmarks import least_steering_car as car
from observers import Ekf, Loop, Mhe, Probe, SteeringLimits
from observers.interfaces.car_observer import car_observer
from reference_rig import draw_car

MUS, RUNS, MAX_SAMPLES = (0.07, 0.2, 0.5, 0.9), 5, 1000


def timed(
    observer: Any, wheel: Callable[[int, float], Any], case: tuple[float, SteeringLimits, float, float]
) -> None:
    """Print the times of a probe; a case is the target, the limits, the load [N] and dt [s]."""
    target, limits, load, dt = case
    first, plans, others = (list[float]() for _ in range(3))
    probe = Probe(observer, target, limits, dt=dt)
    probe.prepare(load)
    for _ in range(RUNS):
        begin = process_time()
        probe.prepare(load)
        first.append(process_time() - begin)
    for seed in range(RUNS * len(MUS)):
        probe.reset()
        loop, turned, psi = Loop(observer), wheel(seed, MUS[seed % len(MUS)]), 0.0
        for _ in range(MAX_SAMPLES):
            sample = turned.follow(psi)
            loop(sample)
            before = probe._since
            begin = process_time()
            advice = probe(sample, loop.state)
            (plans if probe._since < before else others).append(1e3 * (process_time() - begin))
            psi = advice.psi
            if advice.finished or advice.stopped:
                break
    times = " | ".join(row(one) for one in (plans, others))
    print(f"| {np.median(first):.1f} s, {max(first):.1f} s | {times} |", flush=True)


def row(times: list[float]) -> str:
    """Median, 99th percentile and maximum [ms], and how many."""
    return f"{np.median(times):.2g}, {np.quantile(times, 0.99):.2g}, {max(times):.2g} ms ({len(times)})"


def main() -> None:
    """Print the table."""
    gc.freeze()
    print("| | prepare: median, most | with a new plan: median, p99, most | else |")
    print("|---|---:|---:|---:|")
    observer = rig.observer_of()
    of_rig = (0.05, rig.LIMITS, rig.LOAD, rig.DT)
    for kind in (Ekf, Mhe):
        names = ("model", "values", "rig", "tuning", "measurement_model")
        one = kind(**{name: getattr(observer, name) for name in names})
        print(f"| rig, {kind.__name__} ", end="")
        timed(one, rig.RigWheel, of_rig)
    drawn = draw_car(20_001)
    vehicle = car.CarWheel(drawn).vehicle
    print("| car, Ekf ", end="")
    timed(
        car_observer(Ekf, vehicle, brakes=drawn.brake), lambda _, mu: car.parked(drawn, mu),
        (0.15, car.LIMITS, vehicle.wheel_load, car.DT),
    )  # fmt: skip


if __name__ == "__main__":
    main()
