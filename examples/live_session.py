"""Friction while the wheel turns
==============================

A live estimation without its page: the session of ``brushgrip live`` replays an embedded recording.

.. code-block:: sh

    python examples/live_session.py [PICTURE.png]

The replay waits for no clock. The model is what `find_the_missing_effect.py` finds on other recordings
of the same rig, rounded. :doc:`/start/live` tells the rest, and shows the page on this recording, with
the model of ``make demo`` and its error, which is less than the one assumed here:

.. image:: /start/live.gif
   :align: center
   :alt: The page of a live estimation

And what this script draws:
"""

import sys
import time
from pathlib import Path

import numpy as np

from brushgrip.inputs.command_inputs import gather_inputs
from brushgrip.live.estimate_ring import EstimatePoints
from brushgrip.live.session import Session
from brushgrip.live.session_setup import source_and_estimator
from brushgrip.live.session_state_in_words import state_line
from brushgrip.pictures.friction import OVERVIEW_WIDTH
from brushgrip.pictures.style import AFTER, QUIET, figure_saved_as_png
from identification.loop_plot import draw_loops
from observers import AligningTorque, Ekf
from symbolic import Model, effects_named

RECORDINGS = Path(__file__).resolve().parent / "recordings"
MODEL = Model(effects=effects_named(["rate_friction", "carcass_torsion"]))
VALUES = {"k": 2.4e6, "rate_friction.c": 0.04, "carcass_torsion.k_t": 390.0}


def replayed(recording: Path) -> Session:
    """A session that has followed a recording to its end."""
    opened, estimator = source_and_estimator(
        str(recording),
        gather_inputs(rig=RECORDINGS / "rig.toml"),
        lambda of, _: Ekf(
            model=MODEL, values=VALUES, rig=of.rig, measurement_model=AligningTorque(stiffness=True)
        ),
        speed=1e6,
    )
    session = Session(opened, estimator)
    session.start()
    while not session.state().ended:
        time.sleep(0.02)
    session.stop()
    return session


def draw(path: Path, points: EstimatePoints) -> None:
    """Friction with its band over time, the torque over the angle."""
    t, mu, reach = points.t, points.values_of_field("mu_eff"), 2 * points.values_of_field("mu_eff_std")
    usable = points.values_of_field("usable") == 1
    with figure_saved_as_png(path, 6.4, OVERVIEW_WIDTH) as figure:
        friction, torque = figure.subplots(2, 1)
        for shown, colour, label in ((~usable, QUIET, "not usable"), (usable, AFTER, "usable")):
            friction.plot(t, np.where(shown, mu, np.nan), color=colour, lw=1.8, label=label)
            low, high = np.maximum(mu - reach, 0), mu + reach
            friction.fill_between(t, low, high, where=shown, color=colour, alpha=0.2, lw=0)
        friction.set(ylim=(0, 2), xlabel="time t [s]", ylabel="effective friction μ_eff [1]")
        friction.legend(loc="lower right")
        loops = {
            "measured": points.values_of_field("torque"),
            "model": points.values_of_field("M_z_predicted"),
        }
        draw_loops(torque, points.values_of_field("psi"), loops)


def main() -> None:
    """Replay, print when friction becomes usable and how the session ends."""
    session = replayed(RECORDINGS / "holdout_d.csv")
    points = session.ring.since(0)
    first = int(np.argmax(points.values_of_field("usable")))
    print(f"{len(points.t)} samples; friction is usable from {points.t[first]:.2f} s on")
    print(state_line(session.state()))
    if sys.argv[1:]:
        draw(Path(sys.argv[1]), points)


if __name__ == "__main__":
    main()
