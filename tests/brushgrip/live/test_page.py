import math
import os
import re
import shutil
import signal
import socket
import subprocess
import time
from collections.abc import Iterator
from contextlib import ExitStack
from itertools import chain, cycle, repeat, takewhile
from pathlib import Path
from threading import Event, Thread
from typing import Any

import numpy as np
import pytest

from brushgrip.live.page import CUT_OFF, PICTURES, STYLE, LiveView, friction_html
from tests.brushgrip.live.browsing import DRAWN, chromium, live_process
from tests.brushgrip.live.bus import MAP, Bus
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
MULTICAST = ("239.74.163.2", 43113)
"""Group and port that are python-can's own if none are given."""


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
    view.sent.text = view.sent.name
    view.update()
    newest = session.ring.since(299)
    assert f'data-mu="{float(newest.values_of_field("mu_eff")[0])!r}"' in view.words.text
    # The words wait for no picture.
    assert not len(view.points.data["t"])
    for _ in range(1, PICTURES):
        view.sent.text = view.sent.name
        view.update()

    assert view.points.data["mu"][-1] == newest.values_of_field("mu_eff")[0]
    assert (
        view.points.data["high"][-1]
        == newest.values_of_field("mu_eff")[0] + 2 * newest.values_of_field("mu_eff_std")[0]
    )
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
@pytest.mark.parametrize("page", ["0.4"], indirect=True)
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
@pytest.mark.parametrize("page", ["0.4"], indirect=True)
def test_a_slow_browser_calls_nothing_usable_that_is_long_past(browser: Any, address: str) -> None:
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
def test_a_page_whose_connection_broke_goes_on(browser: Any, address: str) -> None:
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
    # By then a slow machine is at the end of the recording.
    wait_for(lambda: float(now.get_attribute("data-t")) >= min(broke + 2, 14.0))
    wait_for(lambda: verdict.inner_text().strip() in ("usable", "ended"))


@pytest.fixture
def browser() -> Iterator[Any]:
    """Debian's chromium, driven by Playwright."""
    pytest.importorskip("playwright", reason="needs brushgrip[browser]")
    if shutil.which("chromium") is None:
        pytest.skip("needs Debian's chromium")
    with chromium() as started:
        yield started


@pytest.fixture
def page(
    tmp_path: Path, request: pytest.FixtureRequest
) -> Iterator[tuple[subprocess.Popen[bytes], str, Path]]:
    """The command as a user runs it, its page and its recording."""
    out, speed = tmp_path / "live.parquet", getattr(request, "param", "20")
    with live_process(RECORDING, "--rig", RIG, "--speed", speed, "--record", out) as (process, address):
        yield process, address, out


@pytest.fixture
def address(page: tuple[subprocess.Popen[bytes], str, Path]) -> str:
    """The address of the command's page."""
    return page[1]


@pytest.fixture
def bus() -> Iterator[Bus]:
    """A bus between processes of this machine alone, with identifiers of its own."""
    can = pytest.importorskip("can", reason="needs brushgrip[live]")
    place = {"interface": "udp_multicast", "channel": MULTICAST[0], "port": MULTICAST[1], "hop_limit": 0}
    with ExitStack() as stack:
        try:
            joined = Bus(base=(os.getpid() % 2**16 + 1) << 12, **place)
            stack.callback(joined.bus.shutdown)
            joined.torque(0.0, 0.0)
            comes = joined.bus.recv(1.0) is not None
        except (can.CanError, OSError) as error:
            pytest.skip(f"no multicast: {error}")
        if not comes:
            pytest.skip("no multicast comes back to this machine")
        yield joined


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
    shown = _digits(now)
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


@pytest.mark.long
def test_a_bus_that_dies_and_comes_back_is_on_the_page_and_in_the_recordings(
    browser: Any, bus: Bus, tmp_path: Path
) -> None:
    (tmp_path / "rig.dbc").write_text(bus.database)
    options = ("--dbc", tmp_path / "rig.dbc", "--map", MAP, "--record", tmp_path / "live.parquet")
    source = f"can:udp_multicast:{MULTICAST[0]}"
    with live_process(source, "--rig", RIG, *options) as (process, address):
        shown = browser.new_page()
        shown.add_init_script(DRAWN)
        shown.goto(address)
        last = [_last_words(bus, shown)]
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
            stranger.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
            stranger.sendto(b"no frame: python-can gives the bus up", MULTICAST)
        wait_for(lambda: "reopened" in shown.locator(".now").inner_text())
        last.append(_last_words(bus, shown))
        shown.close()
        process.send_signal(signal.SIGINT)
        assert process.wait(60) == 0
    said = [estimated(path) for path in sorted(tmp_path.glob("*.parquet"))]

    # Had the sender to wait for its processor, there are more.
    assert len(said) >= 2
    ends = [{"t": one.t[-1], "mu": one.mu_eff[-1], "std": one.mu_eff_std[-1]} for one in said]
    assert [words for words in last if words not in ends] == []


def _last_words(bus: Bus, shown: Any) -> dict[str, float]:
    """What a page says of a wheel that rests until it is shown, and turns until friction is usable."""
    rows, turns, ends = rows_of(1401), Event(), Event()

    def send() -> None:
        resting = takewhile(lambda _: not turns.is_set(), cycle(rows[:100]))
        turned = takewhile(lambda _: not ends.is_set(), repeat(rows[-1]))
        for row in chain(resting, rows, turned):
            bus.motion(math.degrees(row["psi"]), round(row["F_N"]), 0.0)
            bus.torque(row["M_z"], 0.0)
            time.sleep(0.01)  # As recorded: friction of a quicker turn is not known sooner.

    now, sender = shown.locator(".now"), Thread(target=send)
    before = now.get_attribute("data-t")
    shown.evaluate("drawn.length = 0")
    sender.start()
    try:
        wait_for(lambda: now.get_attribute("data-t") != before)
        turns.set()
        wait_for(lambda: shown.evaluate("drawn.some(one => one.verdict === 'usable')"))
    finally:
        turns.set()
        ends.set()
        sender.join()
    # Longer than the gap after which it begins anew.
    wait_for(lambda: re.search(r"no sample for ([3-9]|\d\d)", now.inner_text()))
    assert shown.locator(".verdict").inner_text().strip() == "not usable"
    return _digits(now)


def _digits(now: Any) -> dict[str, float]:
    return {name: float(now.get_attribute(f"data-{name}")) for name in ("t", "mu", "std")}


def _verdict_once_usable(shown: Any) -> Any:
    verdict = shown.locator(".verdict")
    wait_for(lambda: verdict.inner_text().strip() == "usable")
    return verdict
