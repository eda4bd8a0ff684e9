"""Live estimation at 1 kHz until a browser has drawn it: samples lost, delay, memory.

``python benchmarks/live.py [--minutes N] [--observer ekf|mhe]`` runs the command on UDP on the loopback,
its page in headless Chromium, and a sender that is a process of its own. It prints samples sent,
estimated and lost, the delay from sending to what ``--send`` sends and to what the browser has drawn,
and the memory of the command. A sample's time is when it was sent, by the clock that all share.
"""

import argparse
import json
import multiprocessing
import os
import signal
import socket
import subprocess
import threading
import time
from pathlib import Path

import numpy as np

from tests.brushgrip.live.browsing import DRAWN, chromium, live_process

RIG = Path(__file__).parent.parent / "examples" / "recordings" / "rig.toml"
RATE = 1000
SETTLING = 10.0
"""Left out of delay and memory: the observer is compiled, the page is built [s]."""

AIM = 100
"""Of the delay [ms]."""


def send(port: int, count: int, origin: float) -> None:
    """Send a wheel that is turned to and fro, a sample a datagram, with times since `origin`."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.connect(("127.0.0.1", port))
        begin = time.monotonic()
        for at in range(count):
            if (wait := begin + at / RATE - time.monotonic()) > 0:
                time.sleep(wait)
            t = time.time() - origin
            psi = 0.25 * np.sin(0.8 * t)
            sample = {"t": t, "psi": psi, "M_z": -8 * np.tanh(15 * psi), "F_N": 400.0}
            sender.send(json.dumps(sample).encode())


def receive(receiver: socket.socket, came: list[tuple[float, float]]) -> None:
    """Keep time and arrival of each estimate that is sent, until an empty datagram."""
    while told := receiver.recv(4096):
        came.append((json.loads(told)["t"] or 0.0, time.time()))


def free_port() -> int:
    """A port for datagrams."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])


def memory(pid: int) -> float:
    """Resident memory of a process [MB]."""
    return 4096 * int(Path(f"/proc/{pid}/statm").read_text().split()[1]) / 1e6


def report_delay(what: str, came: list[tuple[float, float]], origin: float) -> None:
    """Print the delay of samples; `came` has times of samples [s] and when they came [s]."""
    t, at = np.array([(t, at) for t, at in came if np.isfinite(t)]).T
    first = np.unique(t, return_index=True)[1]
    delay = 1e3 * (at - origin - t)[first[t[first] > t[0] + SETTLING]]
    middle, high = np.quantile(delay, [0.5, 0.99])
    soon = 100 * np.mean(delay <= AIM)
    print(
        f"from sending to {what}, {delay.size} times:"
        f" median {middle:.1f} ms, 99 % {high:.1f} ms, {soon:.1f} % within {AIM} ms"
    )


def main() -> None:
    """Print what was lost, how long it took and what it cost."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--minutes", type=float, default=1.0)
    parser.add_argument("--observer", default="ekf")
    given = parser.parse_args()
    count, origin, port = round(60 * RATE * given.minutes), time.time(), free_port()
    drawn, sent, used = list[tuple[float, float]](), list[tuple[float, float]](), list[float]()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver, chromium() as browser:
        receiver.bind(("127.0.0.1", 0))
        here = receiver.getsockname()
        threading.Thread(target=receive, args=(receiver, sent), daemon=True).start()
        options = ("--rig", RIG, "--observer", given.observer, "--send", f"udp:{here[0]}:{here[1]}")
        with live_process(f"udp:{port}", *options, "--json", stdout=subprocess.PIPE) as (command, at):
            page = browser.new_page()
            page.add_init_script(DRAWN)
            page.goto(at)
            page.locator(".now").wait_for()
            spawn = multiprocessing.get_context("spawn")
            sender = spawn.Process(target=send, args=(port, count, origin))
            sender.start()
            while sender.is_alive():
                page.wait_for_timeout(1000)
                drawn += [(float(one["t"]), one["at"]) for one in page.evaluate("drawn.splice(0)")]
                used.append(memory(command.pid))
            command.send_signal(signal.SIGINT)
            counts = json.loads(command.communicate()[0])["counts"]
        receiver.sendto(b"", here)
    estimated = counts["samples"]
    print(f"{count} samples sent, {estimated} estimated, {count - estimated} lost; {counts}")
    print(f"load of {os.cpu_count()} processors in the last 15 minutes: {os.getloadavg()[2]:.1f}")
    report_delay("the estimate", sent, origin)
    report_delay("the page as drawn", drawn, origin)
    settled = np.array_split(used[int(SETTLING) :], 4)
    first, last = np.mean(settled[0]), np.mean(settled[-1])
    print(
        f"memory {first:.1f} MB in the first quarter, {last:.1f} MB in the last, at most {max(used):.1f}"
    )


if __name__ == "__main__":
    main()
