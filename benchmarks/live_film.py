"""The page of a live estimation as an animated picture, by headless Chromium.

``python benchmarks/live_film.py [--model demo_output/model.json] [--out docs/start/live.gif]`` runs the
command of ``make live`` on an embedded recording, looks at its page until the recording has ended, and
prints when friction became usable. The picture runs about twice as fast. Where the observer was compiled
first, which comes late into the picture, run it again.
"""

import argparse
import io
from pathlib import Path

from PIL import Image
from playwright.sync_api import Page

from tests.brushgrip.live.browsing import chromium, live_process
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
    inputs = [RECORDINGS / "holdout_d.csv", "--rig", RECORDINGS / "rig.toml", "--model", given.model]
    with chromium() as browser:
        page = browser.new_page(viewport=SIZE)
        with live_process(*inputs) as (_, address):
            page.goto(address)
            save(film(page), given.out)


if __name__ == "__main__":
    main()
