"""Live estimation at 1 kHz over UDP on the loopback: samples lost, memory, delay.

``python benchmarks/live.py [--seconds N] [--observer ekf|mhe]`` prints samples sent, estimated and lost,
memory before and after with its slope, and the delay from sending to the estimate, and to the data of a
page that is updated at 20 Hz. The sender is a process of its own; its times are the clock that both
share. What is measured is kept in arrays of the size that they will have.
"""

import argparse
import json
import multiprocessing
import socket
import threading
import time
from pathlib import Path

import numpy as np

from brushgrip.estimation.observe_recording import observer_factory
from brushgrip.inputs.command_inputs import gather_inputs
from brushgrip.inputs.option_choices import ObserverName
from brushgrip.live.page import PERIOD, LiveView
from brushgrip.live.session import Session
from brushgrip.live.session_setup import source_and_estimator

RIG = Path(__file__).parent.parent / "examples" / "recordings" / "rig.toml"
RATE = 1000
SETTLING = 5.0
"""Before memory is taken [s]."""


def send(port: int, count: int, origin: float) -> None:
    """Send a wheel that is turned to and fro, a sample a datagram."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.connect(("127.0.0.1", port))
        begin = time.monotonic()
        for at in range(count):
            due = begin + at / RATE
            if (wait := due - time.monotonic()) > 0:
                time.sleep(wait)
            psi = 0.25 * np.sin(0.8 * at / RATE)
            sample = {
                "psi": psi,
                "M_z": -8 * np.tanh(15 * psi),
                "F_N": 400.0,
                "t": time.monotonic() - origin,
            }
            sender.send(json.dumps(sample).encode())


def memory() -> float:
    """Of this process [MB]."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096 / 1e6


def report_memory(t: np.ndarray, size: np.ndarray) -> None:
    """Print memory [MB] at the begin and the end, and its slope; t is the time [s]."""
    half = slice(t.size // 2, None)
    slope = 60 * np.polyfit(t[half], size[half], 1)[0]
    print(
        f"memory {size[0]:.1f} MB after {SETTLING:g} s, {size[-1]:.1f} MB at the end;"
        f" {slope:.3f} MB a minute in the second half"
    )


def main() -> None:
    """Print what was lost, what it cost and how long it took."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--seconds", type=int, default=30)
    parser.add_argument("--observer", default="ekf")
    given = parser.parse_args()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    factory = observer_factory(ObserverName(given.observer))
    session = Session(*source_and_estimator(f"udp:{port}", gather_inputs(rig=RIG), factory))
    session.start()
    origin = time.monotonic()
    view, stop, count = LiveView(session), threading.Event(), given.seconds * RATE
    # Ones, so that the memory is taken at once.
    delays, shown, used = np.ones(count), np.ones(count), np.ones((2, count))
    looks = updates = 0

    def update() -> None:
        nonlocal updates
        while not stop.wait(PERIOD / 1000):
            before = view.newest
            view.update()
            view.sent.text = view.sent.name  # As a browser says that shows it at once.
            if view.newest != before:
                shown[updates] = time.monotonic() - origin - view.newest
                updates += 1

    page = threading.Thread(target=update)
    page.start()
    sender = multiprocessing.get_context("spawn").Process(target=send, args=(port, count, origin))
    sender.start()
    at = 0
    while sender.is_alive():
        sender.join(0.5)
        points = session.ring.since(at)
        delays[at : points.end] = points.of("done") - origin - points.t
        at = points.end
        if at > SETTLING * RATE:
            used[:, looks], looks = (time.monotonic() - origin, memory()), looks + 1
    time.sleep(1.0)
    stop.set()
    page.join()
    session.stop()
    lost = count - session.ring.end
    print(f"{count} samples sent, {count - lost} estimated, {lost} lost; {session.state().counts}")
    report_memory(*used[:, :looks])
    for name, values in (("estimate", delays[:at]), ("data of the page", shown[:updates])):
        middle, high = 1e3 * np.quantile(values, [0.5, 0.99])
        print(f"from sending to the {name}: median {middle:.1f} ms, 99 % {high:.1f} ms")


if __name__ == "__main__":
    main()
