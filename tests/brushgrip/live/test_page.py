import json
import re
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from brushgrip.live.page import CUT_OFF, PICTURES, STYLE, LiveView, friction_html
from tests.brushgrip.live.sessions import (
    RIG,
    ListSource,
    estimated,
    rows_of,
    run_to_end,
    session_of,
    state_of,
)
from tests.processes import wait_for

pytest.importorskip("bokeh", reason="needs brushgrip[live]")
RECORDING = RIG.with_name("train_a.csv")


def test_a_view_shows_the_newest_point_to_the_last_digit() -> None:
    rows = rows_of(300)
    for at, row in enumerate(rows):
        row["t"] = 0.001 * at
    session = session_of("udp:5005")
    session._open = lambda: ListSource(rows)
    view = LiveView(session)
    view.update()
    assert 'data-mu="nan"' in view.words.text
    assert not len(view.points.data["t"])
    run_to_end(session)
    view.update()
    # A browser that does not show yet what it was sent gets nothing else.
    assert 'data-mu="nan"' in view.words.text
    for _ in range(PICTURES):
        view.sent.text = view.sent.name
        view.update()
    newest = session.ring.since(299)

    assert f'data-mu="{float(newest.of("mu_eff")[0])!r}"' in view.words.text
    assert view.points.data["mu"][-1] == newest.of("mu_eff")[0]
    assert view.points.data["high"][-1] == newest.of("mu_eff")[0] + 2 * newest.of("mu_eff_std")[0]
    np.testing.assert_allclose(np.diff(view.points.data["t"]), 0.01, atol=1.5e-3)
    assert view.button.label == "Record"
    assert [type(m).__name__ for m in view.layout().children] == ["Div", "figure", "figure", "Button"]


def test_words_of_a_source_are_escaped() -> None:
    state = state_of(status="<script>alert(1)</script>", advice="<b>", counts={"<i>": 1}, note="<u>")
    text = friction_html(state, ())

    assert not re.search("<script|<b>|<i>|<u>", text)
    assert "&lt;u&gt;" in text
    assert "not usable" in text


def test_words_that_are_not_replaced_call_nothing_usable() -> None:
    style, text = STYLE.read_text("utf-8"), friction_html(state_of(usable=True), ())

    assert f'<div class="verdict"><span>usable</span>{CUT_OFF}</div>' in text
    # The browser itself has to see to that: nothing that it is sent can say that nothing comes.
    for rule in (".usable .cut-off", ".usable .verdict span:first-child, .advice"):
        assert re.search(rf"{re.escape(rule)} {{ animation: \w+ 0s 1s forwards; }}", style)


@pytest.mark.long
@pytest.mark.parametrize("page", ["1"], indirect=True)
@pytest.mark.parametrize("end", [signal.SIGKILL, signal.SIGSTOP])
def test_a_page_whose_process_is_gone_or_hangs_calls_nothing_usable(
    browser: Any, page: tuple[subprocess.Popen[bytes], str, Path], end: signal.Signals
) -> None:
    process, address, _ = page
    shown = browser.new_page()
    shown.goto(address)
    verdict = _verdict_once_usable(shown)
    process.send_signal(end)
    wait_for(lambda: verdict.inner_text().strip() == "not usable: this page is cut off")


@pytest.mark.long
@pytest.mark.parametrize("page", ["1"], indirect=True)
def test_a_slow_browser_calls_nothing_usable_that_is_long_past(
    browser: Any, page: tuple[subprocess.Popen[bytes], str, Path]
) -> None:
    _, address, _ = page
    desk, phone = browser.new_page(), browser.new_page(viewport={"width": 390, "height": 844})
    desk.goto(address)
    phone.goto(address)
    phone.context.new_cdp_session(phone).send("Emulation.setCPUThrottlingRate", {"rate": 6})
    verdict = _verdict_once_usable(phone)
    desk.locator(".ended").wait_for(timeout=60_000)
    ended = time.monotonic()
    wait_for(lambda: verdict.inner_text().strip() == "ended")
    assert time.monotonic() - ended < 6


@pytest.mark.long
@pytest.mark.parametrize("page", ["0.4"], indirect=True)
def test_a_page_whose_connection_broke_goes_on(
    browser: Any, page: tuple[subprocess.Popen[bytes], str, Path]
) -> None:
    _, address, _ = page
    shown = browser.new_page()
    shown.add_init_script(
        "const Own = WebSocket; window.own = [];"
        "window.WebSocket = class extends Own { constructor(...a) { super(...a); own.push(this) } }"
    )
    shown.goto(address)
    verdict = _verdict_once_usable(shown)
    now = shown.locator(".now")
    broke = float(now.get_attribute("data-t"))
    shown.evaluate("own.at(-1).close()")
    wait_for(lambda: "cut off" in verdict.inner_text())
    wait_for(lambda: float(now.get_attribute("data-t")) > broke)
    # On a slow machine the recording has ended by then.
    wait_for(lambda: verdict.inner_text().strip() in ("usable", "ended"))


@pytest.fixture
def browser() -> Iterator[Any]:
    """Debian's chromium, driven by Playwright."""
    driver = pytest.importorskip("playwright.sync_api", reason="needs brushgrip[browser]")
    if (chromium := shutil.which("chromium")) is None:
        pytest.skip("needs Debian's chromium")
    with driver.sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        yield started
        started.close()


@pytest.fixture
def page(
    tmp_path: Path, request: pytest.FixtureRequest
) -> Iterator[tuple[subprocess.Popen[bytes], str, Path]]:
    """The command as a user runs it, its page and its recording."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    out = tmp_path / "live.parquet"
    command = [sys.executable, "-m", "brushgrip", "live", RECORDING, "--rig", RIG, "--no-browser"]
    options = ["--speed", getattr(request, "param", "20"), "--port", str(port), "--record", out]
    process = subprocess.Popen([*command, *options], stdout=subprocess.DEVNULL)
    try:
        wait_for(lambda: _answers(port))
        yield process, f"http://127.0.0.1:{port}/", out
    finally:
        process.kill()
        process.wait()


@pytest.mark.long
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_browser_shows_what_estimate_says_of_the_recording(
    browser: Any, page: tuple[subprocess.Popen[bytes], str, Path], scheme: str
) -> None:
    process, address, out = page
    phone = browser.new_page(viewport={"width": 390, "height": 844}, color_scheme=scheme)
    asked: list[str] = []
    phone.on("request", lambda request: asked.append(request.url))
    phone.goto(address)
    now = phone.locator(".now.ended")
    now.wait_for(timeout=60_000)
    wait_for(lambda: float(now.get_attribute("data-t") or 0) == 14)
    shown = {name: json.loads(now.get_attribute(f"data-{name}")) for name in ("t", "mu", "std")}
    background = phone.evaluate("getComputedStyle(document.body).backgroundColor")
    wide = phone.evaluate("document.documentElement.scrollWidth")
    size = phone.locator(".mu").evaluate("e => parseFloat(getComputedStyle(e).fontSize)")
    phone.get_by_role("button", name="Stop recording").click()
    phone.get_by_role("button", name="Record", exact=True).wait_for()
    wait_for(out.exists)
    phone.close()
    process.send_signal(signal.SIGINT)
    assert process.wait(60) == 0
    said = estimated(out)

    assert shown == {"t": said.t[-1], "mu": said.mu_eff[-1], "std": said.mu_eff_std[-1]}
    assert background == {"light": "rgb(255, 255, 255)", "dark": "rgb(0, 0, 0)"}[scheme]
    assert wide <= 390
    assert size > 50
    assert all(url.startswith((address, "data:", "blob:")) for url in asked)


def _answers(port: int) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


def _verdict_once_usable(shown: Any) -> Any:
    verdict = shown.locator(".verdict")
    wait_for(lambda: verdict.inner_text().strip() == "usable")
    return verdict
