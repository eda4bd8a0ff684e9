"""Seconds until the command line shows its help, each in a new process, and what that imports.

    python benchmarks/help.py

The smallest of five runs, and of those the processor's time, which a busy machine does not lengthen.
The time of an empty Python is part of each.
"""

import resource
import subprocess
import sys
import time

COMMANDS = (
    "",
    "demo",
    "fetch",
    "simulate",
    "identify",
    "diagnose",
    "estimate",
    "compare",
    "codegen",
)
RUNS = 5
MOST = 0.5
"""What help may take [s]."""


def main() -> None:
    """Print the table, and the modules that help spends most on."""
    print(_row("python -c pass", seconds(["-c", "pass"])))
    slow = []
    for command in COMMANDS:
        arguments = [*filter(None, [command]), "--help"]
        taken = seconds(["-m", "brushgrip", *arguments])
        slow += [command or "--help"] * (taken[0] > MOST)
        print(_row(" ".join(["brushgrip", *arguments]), taken))
    for own, module in imports()[:8]:
        print(f"{own / 1000:8.1f} ms in {module}")
    print(f"longer than {MOST} s: {', '.join(slow) or 'none'}")


def _row(what: str, taken: tuple[float, float]) -> str:
    return f"{what:26} {taken[0]:.2f} s, processor {taken[1]:.2f} s"


def seconds(arguments: list[str]) -> tuple[float, float]:
    """The smallest times of a new interpreter with these arguments [s]: clock, processor."""
    taken = []
    for _ in range(RUNS):
        start, busy = time.perf_counter(), _processor()
        subprocess.run([sys.executable, *arguments], check=True, stdout=subprocess.DEVNULL)
        taken.append((time.perf_counter() - start, _processor() - busy))
    return min(clock for clock, _ in taken), min(busy for _, busy in taken)


def _processor() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def imports() -> list[tuple[int, str]]:
    """Microseconds that each imported module takes by itself, and its name; the longest first."""
    arguments = ["-X", "importtime", "-m", "brushgrip", "--help"]
    listed = subprocess.run([sys.executable, *arguments], check=True, capture_output=True, text=True)
    rows = [line.removeprefix("import time:").split("|") for line in listed.stderr.splitlines()[1:]]
    return sorted(((int(own), name.strip()) for own, _, name in rows), reverse=True)


if __name__ == "__main__":
    main()
