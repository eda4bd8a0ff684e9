"""The command `live` with its page, the browser that looks at it, and what that has drawn when."""

import shutil
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from tests.processes import wait_for

DRAWN = """
window.drawn = []
const attach = Element.prototype.attachShadow
Element.prototype.attachShadow = function (options) {
  const root = attach.call(this, options)
  new MutationObserver(() => {
    const now = root.querySelector(".now")
    if (now === null) return
    const words = { ...now.dataset, verdict: now.classList[1], text: now.textContent }
    requestAnimationFrame(() => setTimeout(() => drawn.push({ ...words, at: Date.now() / 1000 })))
  }).observe(root, { childList: true, subtree: true })
  return root
}"""
"""Has a page keep in `drawn` each of its words and the time [s] when the frame that shows them was done:
the words are in a shadow root."""


@contextmanager
def live_process(
    *arguments: object, stdout: int = subprocess.DEVNULL
) -> Iterator[tuple[subprocess.Popen[bytes], str]]:
    """The command as a user runs it, and the address of its page, which answers."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    command = [sys.executable, "-m", "brushgrip", "live", *map(str, arguments), "--no-browser"]
    process = subprocess.Popen([*command, "--port", str(port)], stdout=stdout)
    try:
        wait_for(lambda: _answers(port))
        yield process, f"http://127.0.0.1:{port}/"
    finally:
        process.kill()
        process.wait()


@contextmanager
def chromium() -> Iterator[Any]:
    """Debian's chromium, driven by Playwright."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        started = driver.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        try:
            yield started
        finally:
            started.close()


def _answers(port: int) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0
