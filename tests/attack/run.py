"""Attack every promise that files, values, processes and time could break; print a table.

    python -m tests.attack.run [--seconds S] [--inputs N] [--seed K] [CLASS ...]

Each class goes on for S seconds, or until it has tried N inputs. Exit status 1 if anything failed;
inputs that broke something are kept in attack_findings/.
"""

import argparse
import math
import sys
from collections.abc import Sequence
from time import monotonic

from tests.attack import (
    batches,
    command_lines,
    contents,
    disks,
    faults,
    fuzzing,
    generated_c,
    hosts,
    long_runs,
    names,
    tampered,
    temporary_folders,
    threads,
)
from tests.attack import test_properties as properties
from tests.attack.attack_class import Classes, Effort, examples, undertake
from tests.symbolic import test_exact_zone_patch as zones

PROPERTIES: Classes = {
    "masing": examples(zones.test_masing_and_madelung_hold_to_rounding_under_constant_load),
    "load_histories": examples(zones.test_any_history_of_angle_and_load_follows_the_grid),
    "gaps": examples(
        properties.test_estimates_stay_finite_whatever_is_missing,
        properties.test_nothing_before_a_sample_depends_on_it,
    ),
    "serialisation": examples(
        properties.test_a_loop_goes_on_where_it_is_pickled,
        properties.test_what_is_written_as_csv_is_read_as_it_was,
        properties.test_a_model_file_is_read_as_it_was_written,
        properties.test_a_map_in_a_rig_file_is_read_as_written,
    ),
}
"""Tests of hypothesis as classes."""
MODULES = (
    *(long_runs, generated_c, contents, threads, temporary_folders),
    *(command_lines, names, hosts, tampered, faults, disks, batches),
)
CLASSES: Classes = (
    fuzzing.CLASSES
    | PROPERTIES
    | {name: attack for module in MODULES for name, attack in module.CLASSES.items()}
)
"""All classes in the order of the table."""
SECONDS = 60.0
_LONGEST_LINE = 300


def main(arguments: Sequence[str] | None = None) -> int:
    """The command line; returns the exit status."""
    parser = argparse.ArgumentParser(prog="tests.attack.run", description=__doc__.splitlines()[0])
    parser.add_argument("classes", nargs="*", metavar="CLASS", help=", ".join(CLASSES))
    parser.add_argument("--seconds", type=float, help=f"of each class; {SECONDS:g} unless told")
    told = "of each class; without --seconds, however long it takes"
    parser.add_argument("--inputs", type=int, help=told)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args(arguments)
    if unknown := set(given.classes) - set(CLASSES):
        parser.error(f"no such class: {', '.join(sorted(unknown))}")
    seconds = given.seconds or (SECONDS if given.inputs is None else math.inf)
    effort = Effort(seconds=seconds, inputs=given.inputs or sys.maxsize, seed=given.seed)
    chosen = given.classes or CLASSES
    classes = {name: one for name, one in CLASSES.items() if name in chosen}
    return 1 if attack_all(classes, effort) else 0


def attack_all(classes: Classes, effort: Effort) -> int:
    """Run the classes in turn, print the table as it grows, then the failures; returns their number."""
    began, total, failures = monotonic(), 0, []
    print(_row("class", "inputs", "failures", "seconds"))
    for name, one in classes.items():
        start = monotonic()
        outcome = undertake(one, effort)
        seconds = f"{monotonic() - start:.0f}"
        print(_row(name, f"{outcome.inputs:,}", f"{len(outcome.failures)}", seconds), outcome.note)
        total += outcome.inputs
        failures += [f"{name}: {' '.join(failure.split())}" for failure in outcome.failures]
    print(_row("all", f"{total:,}", f"{len(failures)}", f"{monotonic() - began:.0f}"))
    for failure in failures:
        print(failure[:_LONGEST_LINE])
    return len(failures)


def _row(name: str, inputs: str, failures: str, seconds: str) -> str:
    return f"{name:24}{inputs:>14}{failures:>10}{seconds:>9}"


if __name__ == "__main__":
    sys.exit(main())
