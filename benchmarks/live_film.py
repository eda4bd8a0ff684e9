"""The page of a live estimation as an animated picture, by headless Chromium.

``python benchmarks/live_film.py [--model demo_output/model.json] [--out docs/start/live.gif]`` runs the
command of ``make live`` on an embedded recording, looks at its page until the recording has ended, and
prints when friction became usable. The picture runs about twice as fast. Where the observer was compiled
first, which comes late into the picture, run it again.
"""

import argparse
import io
import shutil
import socket
import subprocess
import sys
from pathlib import Path

from PIL import Image
from playwright.sync_api import Page, sync_playwright

from tests.processes import wait_for

ROOT = Path(__file__).parents[1]
RECORDINGS = ROOT / "examples" / "recordings"
SIZE = {"width": 420, "height": 900}
STEP = 500
"""Between looks at the page [ms]."""
COLOURS = 32


def film(page: Page) -> list[Image.Image]:
    """Looks at a page, from the first sample to the end of the source."""
    words = page.locator(".now")
    wait_for(lambda: words.get_attribute("data-t") != "nan")
    looks, usable = list[Image.Image](), False
    while True:
        state = str(words.get_attribute("class")).split()
        if not usable and (usable := "usable" in state):
            print(f"usable at {words.get_attribute('data-t')} s")
        if "ended" in state:
            return looks
        looks.append(Image.open(io.BytesIO(page.screenshot())).convert("RGB"))
        page.wait_for_timeout(STEP)


def save(looks: list[Image.Image], out: Path) -> None:
    """Write them with the colours of the last one, on which they dwell."""
    colours = looks[-1].quantize(COLOURS)
    first, *others = (look.quantize(palette=colours, dither=Image.Dither.NONE) for look in looks)
    times = [STEP // 2] * len(others) + [4 * STEP]
    first.save(out, save_all=True, append_images=others, duration=times, loop=0, optimize=True)
    print(f"{len(looks)} looks, {out.stat().st_size / 1e3:.0f} kB")


def main() -> None:
    """Film the page."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--model", type=Path, default=ROOT / "demo_output" / "model.json")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "start" / "live.gif")
    given = parser.parse_args()
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    inputs = [RECORDINGS / "holdout_d.csv", "--rig", RECORDINGS / "rig.toml", "--model", given.model]
    command = [sys.executable, "-m", "brushgrip", "live", *inputs, "--no-browser", "--port", str(port)]
    with sync_playwright() as driver:
        chromium = driver.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox"]
        )
        page = chromium.new_page(viewport=SIZE)
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        try:
            wait_for(lambda: _answers(port))
            page.goto(f"http://127.0.0.1:{port}/")
            save(film(page), given.out)
        finally:
            process.terminate()
            process.wait()
            chromium.close()


def _answers(port: int) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


if __name__ == "__main__":
    main()
