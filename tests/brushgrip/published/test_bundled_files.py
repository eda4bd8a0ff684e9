"""The demo's recordings."""

import runpy

import numpy as np

from brushgrip.published.bundled_files import TRUE_FRICTION, demo_folder
from symbolic import Model, Rig, effects_named


def test_the_demo_states_the_friction_that_it_simulates() -> None:
    made = runpy.run_path(str(demo_folder().parent / "make_recordings.py"))
    effects, tyre = made["EFFECTS"], made["TYRE"]
    model = Model(effects=effects_named(list(effects)))
    values = {f"{name}.{p}": v for name, own in effects.items() for p, v in own.items()}
    friction = [
        model.full_slide(
            np.zeros(model.memory_size), run["load"],
            model.theta(values | {"mu": run["mu"], "k": tyre.k}),
            [tyre.a, tyre.e], Rig(a=tyre.a, e=tyre.e).slide_rate,
        )[0] for run in made["RUNS"].values()
    ]  # fmt: skip
    assert f"{float(min(friction)):.2f} to {float(max(friction)):.2f}" == TRUE_FRICTION
