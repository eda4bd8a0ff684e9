"""Hosts that deliver the published files badly: all files whole, or none and one line."""

import hashlib
import http.server
import io
import os
import random
import socket
import struct
import tempfile
import threading
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from time import monotonic
from unittest import mock

import numpy as np

from brushgrip.published import fetch as fetching
from brushgrip.published import friction_damper
from tests.attack.attack_class import one_by_one
from tests.attack.command_lines import outcome_of

CONTENT = {"one.mat": b"first" * 400, "two.mat": b"second" * 300, "three.csv": b"3,3\n" * 200}
LONGEST = 20.0
"""No fetch takes longer, with time limits of a second [s]."""
Host = http.server.BaseHTTPRequestHandler


def _usual(host: Host, content: bytes, *, length: int | None = None, status: int = 200) -> None:
    host.send_response(status)
    host.send_header("Content-Length", str(len(content) if length is None else length))
    host.end_headers()
    host.wfile.write(content)


def _encoded(host: Host, content: bytes) -> None:
    host.send_response(200)
    host.send_header("Content-Encoding", "gzip")
    host.end_headers()
    host.wfile.write(content)


def _redirected(host: Host, place: str) -> None:
    host.send_response(302)
    host.send_header("Location", place)
    host.end_headers()


def _reset(host: Host) -> None:
    host.connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    host.close_connection = True


def _endless(host: Host, begin: bytes = b"HTTP/1.0 200 OK\r\n\r\n") -> None:
    end = monotonic() + LONGEST + 5
    host.wfile.write(begin)
    while monotonic() < end:
        host.wfile.write(bytes(1 << 20))


def _bomb() -> bytes:
    packer = zlib.compressobj(9, zlib.DEFLATED, 31)
    return b"".join(packer.compress(bytes(1 << 20)) for _ in range(400)) + packer.flush()


BAD: dict[str, Callable[[Host, bytes], object]] = {
    "other bytes": lambda host, right: _usual(host, right[::-1]),
    "half": lambda host, right: _usual(host, right[: len(right) // 2]),
    "less than it says": lambda host, right: _usual(host, right[:50], length=len(right)),
    "more than it says": lambda host, right: _usual(host, right + b"x", length=len(right)),
    "nothing": lambda host, _: _usual(host, b""),
    "no length": lambda host, right: _usual(host, right, length=-5),
    "a page of errors": lambda host, right: _usual(host, right, status=404),
    "a fault of its own": lambda host, _: _usual(host, b"", status=503),
    "a status of none": lambda host, _: host.wfile.write(b"HTTP/1.1 abc\r\n\r\n"),
    "no HTTP": lambda host, _: host.wfile.write(os.urandom(500)),
    "a loop": lambda host, _: _redirected(host, host.path),
    "a file": lambda host, _: _redirected(host, "file:///etc/passwd"),
    "another scheme": lambda host, _: _redirected(host, "gopher://[::1"),
    "no gzip": lambda host, right: _encoded(host, right),
    "a bomb": lambda host, _: _encoded(host, _bomb()),
    "a reset": lambda host, _: _reset(host),
    "silence": lambda *_: threading.Event().wait(3),
    "no end": lambda host, _: _endless(host),
    "a head without end": lambda host, _: _endless(host, b"HTTP/1.0 200 OK\r\n"),
}  # fmt: skip


@contextmanager
def host(chance: random.Random) -> Iterator[tuple[str, str]]:
    """Address of a host, and what it does instead of delivering one of the files."""
    kind, file = chance.choice(sorted(BAD)), chance.choice(sorted(CONTENT))

    class Bad(Host):
        def do_GET(self) -> None:
            """Deliver."""
            right = CONTENT[self.path.rpartition("/")[2]]
            with suppress(OSError):  # The other end has enough.
                (BAD[kind] if self.path.endswith(file) else _usual)(self, right)

        def log_message(self, *_: object) -> None:
            """Say nothing."""

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Bad)
    server.daemon_threads, server.block_on_close = True, False
    threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.05}, daemon=True).start()
    try:
        yield f"http://127.0.0.1:{server.server_port}", kind
    finally:
        server.shutdown()
        server.server_close()


def attempt(number: int) -> str | None:
    """One fetch, perhaps into a folder that has some of the files; a line on what went wrong."""
    chance = random.Random(number)
    with tempfile.TemporaryDirectory() as top, host(chance) as (address, kind):
        out, registry = Path(top) / "out", Path(top) / "registry.txt"
        registry.write_text("".join(
            f"{name} sha256:{hashlib.sha256(content).hexdigest()} {address}/{name}\n"
            for name, content in CONTENT.items()
        ))  # fmt: skip
        there = chance.sample(sorted(CONTENT), chance.randrange(3))
        out.mkdir(parents=True)
        for name in there:
            (out / name).write_bytes(CONTENT[name] if chance.random() < 0.7 else b"other")
        before = {path.name: path.read_bytes() for path in out.iterdir()}
        begun = monotonic()
        with (
            mock.patch.object(fetching, "REGISTRY", registry),
            mock.patch.object(fetching, "RETRIES", 0),
            mock.patch.object(fetching, "TIMEOUT", 1.0),
            mock.patch.dict(os.environ, {"no_proxy": "127.0.0.1"}),
        ):
            status, err = outcome_of(["fetch", "--out", str(out)], {"BRUSHGRIP_DATA": ""})
        took, after = monotonic() - begun, {path.name: path.read_bytes() for path in out.iterdir()}
    fault = None
    if status not in (0, 1, 2) or (status and (err.count("\n") != 1 or len(err) > 2000)):
        fault = f"ended with {status!r}: {err[:300]!r}"
    elif after != (before if status else CONTENT):
        fault = f"ended with {status} and wrote {sorted(after)}"
    elif took > LONGEST:
        fault = f"took {took:.0f} s"
    return f"{number}: a host that delivers {kind}: {fault}" if fault else None


@cache
def _run() -> bytes:
    """The file of a run of the friction damper."""
    content = io.BytesIO()
    np.savez(content, **{name: np.arange(20.0) for name in friction_damper.CHANNELS})
    return content.getvalue()


def local_copy(number: int) -> str | None:
    """A run of the friction damper in a local copy is damaged."""
    chance = random.Random(number)
    content = bytearray(_run())
    for _ in range(chance.randint(1, 4)):
        at, size = chance.randrange(len(content)), chance.choice((0, 1, 2, 8, 64))
        content[at : at + size] = chance.randbytes(chance.choice((0, 1, size)))
        if chance.random() < 0.1:
            del content[at:]
    with tempfile.TemporaryDirectory() as top:
        (Path(top) / "harmonic_00.npz").write_bytes(content)
        out = Path(top) / "out"
        fetch = ["fetch", "friction-damper", "--out", str(out)]
        status, err = outcome_of(fetch, {"BRUSHGRIP_DATA": top})
        if status != 2 or err.count("\n") != 1 or len(err) > 2000 or out.exists():
            return f"{number}: ended with {status!r}: {err[-300:]!r}"
    return None


CLASSES = {"fetch": one_by_one(attempt), "fetch_local": one_by_one(local_copy)}
