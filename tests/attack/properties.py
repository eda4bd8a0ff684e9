"""Property tests as classes of attack: hypothesis draws examples of them for as long as told."""

from collections.abc import Callable
from random import Random
from typing import Any

from tests.attack import test_properties as properties
from tests.attack.attack_class import Attack, Effort, Outcome
from tests.symbolic import test_zones as zones

BUFFER = 8192
"""Random bytes that an example is drawn from."""
_MOST_FAILURES = 20


def attack_properties(*tests: Callable[..., Any]) -> Attack:
    """An attack that draws examples of each test in turn; none of them may take a fixture."""

    def attack(effort: Effort) -> Outcome:
        goes_on, done, drawn, failures = effort.rounds(), 0, 0, list[str]()
        while goes_on(done) and len(failures) < _MOST_FAILURES:
            test = tests[drawn % len(tests)]
            try:
                done += _one(test, Random(effort.seed * 10**9 + drawn).randbytes(BUFFER))
            except Exception as error:
                done += 1
                failures.append(f"{test.__name__}, example {drawn}: {type(error).__name__}: {error}")
            drawn += 1
        return Outcome(inputs=done, failures=tuple(failures))

    return attack


def _one(test: Any, buffer: bytes) -> bool:
    """Whether an example could be drawn from the bytes; a test that fails raises."""
    return test.hypothesis.fuzz_one_input(buffer) is not None


CLASSES = {
    "masing": attack_properties(
        zones.test_masing_and_madelung_hold_to_rounding_under_constant_load,
    ),
    "load_histories": attack_properties(zones.test_any_history_of_angle_and_load_follows_the_grid),
    "gaps": attack_properties(
        properties.test_estimates_stay_finite_whatever_is_missing,
        properties.test_nothing_before_a_sample_depends_on_it,
    ),
    "serialisation": attack_properties(
        properties.test_a_loop_goes_on_where_it_was_pickled,
        properties.test_what_is_written_as_csv_is_read_as_it_was,
        properties.test_a_model_file_is_read_as_it_was_written,
        properties.test_a_map_in_a_rig_file_is_read_as_it_was_written,
    ),
}
