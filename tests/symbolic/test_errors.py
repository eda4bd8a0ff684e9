import pickle

import pytest

from symbolic import BrushgripError, InvalidInputError


@pytest.mark.parametrize(
    ("given", "shown"),
    [
        ("μ of “größe” is 1.2–1.3", "μ of “größe” is 1.2–1.3"),
        ("two\nlines\tand\r more", "two lines and  more"),
        ("\x1b[2Jgone\a", r"\x1b[2Jgone\x07"),
        ("not UTF-8: \udcff", r"not UTF-8: \udcff"),
        ("turned \u202e round", r"turned \u202e round"),
    ],
)
def test_a_message_is_one_line_that_a_screen_can_show(given: str, shown: str) -> None:
    assert str(InvalidInputError(given)) == shown


def test_of_a_long_message_both_ends_stay() -> None:
    message = str(BrushgripError("bad.csv: " + 5_000_000 * "\x1b" + "; allowed: less"))

    assert len(message) <= 1000
    assert message.startswith("bad.csv: ")
    assert message.endswith("; allowed: less")


def test_an_error_survives_the_way_between_processes() -> None:
    error = InvalidInputError("bad.csv: row 3")

    assert str(pickle.loads(pickle.dumps(error))) == str(error)
