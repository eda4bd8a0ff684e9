"""The contact patch in motion
===========================

The contact patch in motion: bristles that stick and slide, and the torque loop they draw.

.. code-block:: sh

    python examples/patch_animation.py --out DIR [--frames 90]

A steering torque turns the wheel to and fro, the second loop inside the first. Written are
`patch.gif` and `patch.html`, a page with its own player that needs nothing beside itself.
"""

import argparse
import json
from base64 import b64encode
from io import BytesIO
from pathlib import Path
from string import Template

import matplotlib as mpl
import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from PIL import Image, ImageSequence

from brushgrip.pictures.style import AFTER, BEFORE, MEASURED, QUIET, TRACKS
from symbolic import (
    Rig,
    TorqueProfile,
    Tyre,
    WheelMotion,
    deformation_limit,
    lateral_deformation,
    simulate_motion,
    zone_boundaries,
)

RIG, TYRE, LOAD = Rig(a=0.045, e=0.009, J_A=0.15, b_t=1.04), Tyre(k=2.4e6, mu=1.3), 400.0
PROFILE = TorqueProfile(t=(0.0, 1.0, 1.7, 2.3, 2.9, 3.9, 4.5), M=(0.0, 8.5, -5.5, 4.5, -2.0, 8.4, 8.4))
"""Up to 0.9 of the torque that the ground holds."""
PLACES = RIG.a * (np.arange(-59, 60, 2) / 60)
"""Of the bristles drawn [m]."""
SLIDES, STICKS, SLID = BEFORE, AFTER, TRACKS[2]
LOOK = {
    "font.size": 9, "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True,
    "axes.axisbelow": True, "grid.color": "#e6e8ea", "grid.linewidth": 0.6, "legend.frameon": False,
    "axes.titlelocation": "left", "axes.titlesize": 9,
}  # fmt: skip
FRAMES_PER_SECOND = 18
DPI = 80
COLOURS = 64
"""In a frame of the page; chosen so that rare ones keep their place."""
PAGE = """<!DOCTYPE html>
<html lang="en"><meta charset="utf-8"><title>The contact patch in motion</title>
<style>
body { font: 15px sans-serif; max-width: 62em; margin: 2em auto }
img, input { width: 100% }
</style>
<h1>The contact patch in motion</h1>
<img id="picture" alt="bristles of the patch, and the torque loop"><br>
<input id="frame" type="range" min="0" value="0" aria-label="frame"><button id="play">stop</button>
<script>
const pictures = $pictures;
const [picture, frame, play] = ["picture", "frame", "play"].map(id => document.getElementById(id));
let running = true;
frame.max = pictures.length - 1;
const show = () => { picture.src = pictures[frame.value]; };
const turn = on => { running = on; play.textContent = on ? "stop" : "play"; };
frame.oninput = () => { turn(false); show(); };
play.onclick = () => turn(!running);
const step = () => { frame.value = (+frame.value + 1) % pictures.length; show(); };
setInterval(() => { if (running) step(); }, $pause);
show();
</script></html>
"""


def colours(motion: WheelMotion, i: int) -> list[str]:
    """What every bristle does at a sample: it slides, it sticks after having slid, or it never slid."""
    ends = zone_boundaries(float(motion.psi[i]), motion.memory[i], LOAD, RIG, TYRE)
    if not ends.size:
        return [STICKS] * PLACES.size
    middle = ends.size // 2
    # How many ends lie behind each bristle: none or all where it slides, half of them in the middle.
    behind = np.searchsorted(ends, PLACES).tolist()
    return [{0: SLIDES, ends.size: SLIDES, middle: STICKS}.get(count, SLID) for count in behind]


class Film:
    """The picture, and how a sample of the motion is put into it."""

    def __init__(self, motion: WheelMotion) -> None:
        """Draw what stays."""
        self._motion = motion
        self.figure = Figure(figsize=(10, 4.4), dpi=DPI, layout="constrained", facecolor="white")
        patch, loop = self.figure.subplots(1, 2, width_ratios=[3, 2])
        self._patch = patch
        limit = 1e3 * deformation_limit(PLACES, LOAD, RIG, TYRE)
        for side in (1, -1):
            patch.plot(1e3 * PLACES, side * limit, color=MEASURED, lw=1.0, ls="--")
        patch.axvline(1e3 * RIG.e, color=QUIET, lw=1.0)
        patch.text(1e3 * RIG.e + 0.7, -1.12 * limit.max(), "kingpin", color="#7a7f85")
        self._rods = patch.vlines(1e3 * PLACES, 0, np.zeros(PLACES.size), lw=2.6)
        self._tips = patch.scatter(1e3 * PLACES, np.zeros(PLACES.size), s=9, zorder=3)
        patch.set_ylim(-1.2 * limit.max(), 1.2 * limit.max())
        patch.set_xlabel("place in the patch x [mm], front on the right")
        patch.set_ylabel("lateral deformation q [mm]")
        self._label(patch)
        loop.plot(motion.psi, -motion.M_z, color=QUIET, lw=1.0)
        (self._trace,) = loop.plot([], [], color=AFTER, lw=1.6)
        (self._dot,) = loop.plot([], [], "o", color=BEFORE, ms=6)
        loop.xaxis.set_major_locator(MaxNLocator(5))
        loop.set(xlabel="yaw angle ψ [rad]", ylabel="torque on the ground $-M_z$ [N m]")

        self.show(0)
        # Laid out once: every frame anew would take half of the time.
        self.figure.draw_without_rendering()
        self.figure.set_layout_engine("none")

    def _label(self, axes: Axes) -> None:
        keys = ((SLIDES, "slides"), (SLID, "sticks, has slid"), (STICKS, "sticks, never slid"))
        lines = [axes.plot([], [], color=colour, lw=2.6, label=label)[0] for colour, label in keys]
        lines += axes.plot([], [], color=MEASURED, lw=1.0, ls="--", label="friction's limit")
        self.figure.legend(handles=lines, loc="outside upper center", ncols=4)

    def show(self, i: int) -> list[Artist]:
        """Put sample i into the picture."""
        motion = self._motion
        q = 1e3 * lateral_deformation(PLACES, float(motion.psi[i]), motion.memory[i], LOAD, RIG, TYRE)
        now = colours(motion, i)
        self._rods.set_segments([[(1e3 * x, 0), (1e3 * x, y)] for x, y in zip(PLACES, q, strict=True)])
        self._rods.set_color(now)
        self._tips.set_offsets(np.column_stack([1e3 * PLACES, q]))
        self._tips.set_color(now)
        self._trace.set_data(motion.psi[: i + 1], -motion.M_z[: i + 1])
        self._dot.set_data([motion.psi[i]], [-motion.M_z[i]])
        self._patch.set_title(
            f"t = {motion.t[i]:.2f} s, M = {motion.M[i]:+.1f} N m; zones: {motion.zone_count[i]}"
        )
        return []


def player(gif: Path) -> str:
    """A page that plays the frames of a GIF and stops at any of them.

    matplotlib's own page holds every frame in full colour, four times as large.
    """
    pictures = []
    with Image.open(gif) as film:
        for frame in ImageSequence.Iterator(film):
            buffer = BytesIO()
            frame.convert("RGB").quantize(COLOURS, Image.Quantize.MAXCOVERAGE).save(
                buffer, "PNG", optimize=True
            )
            pictures.append("data:image/png;base64," + b64encode(buffer.getvalue()).decode())
    return Template(PAGE).substitute(pictures=json.dumps(pictures), pause=1000 // FRAMES_PER_SECOND)


def main() -> None:
    """Simulate, film, and say what was written."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--frames", type=int, default=90)
    options = parser.parse_args()
    motion = simulate_motion(RIG, TYRE, PROFILE, LOAD)
    samples = np.linspace(0, motion.t.size - 1, options.frames).round().astype(int)
    options.out.mkdir(parents=True, exist_ok=True)
    with mpl.rc_context(LOOK):
        film = Film(motion)
        animation = FuncAnimation(film.figure, film.show, samples.tolist(), blit=False)
        gif, page = options.out / "patch.gif", options.out / "patch.html"
        animation.save(gif, PillowWriter(fps=FRAMES_PER_SECOND), dpi=DPI)
    page.write_text(player(gif), encoding="utf-8")
    zones = motion.zone_count
    print(f"zones on the way: {', '.join(map(str, zones[np.diff(zones, prepend=0) != 0]))}")
    for path in (gif, page):
        print(f"{path.name}: {options.frames} frames, {path.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
