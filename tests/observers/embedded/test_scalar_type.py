import pytest

from observers.embedded.scalar_type import DOUBLE, SINGLE, count_names, in_type
from symbolic import InvalidInputError

CODE = """\
/* sqrt(2.) of a comment */ // 1.5 there too
static double f(double x1) {
  const char *text = "1.5 sqrt(";
  return sqrt(x1) + 2. * 1.5e-3 + .5 - 7 + 1e9 + x1*a0.w + 0x1F + 12u + casadi_fmax(x1, 3) + 1.5f;
}
"""


def test_literals_and_functions_are_of_the_type() -> None:
    assert in_type(CODE, SINGLE) == (
        CODE.replace("sqrt(x1)", "sqrtf(x1)")
        .replace(" 2. ", " 2.f ")
        .replace("1.5e-3 ", "1.5e-3f ")
        .replace(" .5 ", " .5f ")
        .replace(" 1e9 ", " 1e9f ")
    )


def test_double_stays_as_it_is() -> None:
    assert in_type(CODE, DOUBLE) == CODE


def test_typing_twice_changes_nothing() -> None:
    once = in_type(CODE, SINGLE)
    assert in_type(once, SINGLE) == once


def test_names_in_comments_and_strings_do_not_count() -> None:
    assert count_names(CODE)["sqrt"] == 1


def test_a_constant_beyond_the_type_is_refused() -> None:
    with pytest.raises(InvalidInputError, match="1e60"):
        in_type("x = 1e60;", SINGLE)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.1, "1.00000001e-01f"),
        (float("nan"), "(float)NAN"),
        (float("-inf"), "(float)-INFINITY"),
        (0.0, "0.00000000e+00f"),
    ],
)
def test_literals_of_a_type(value: float, text: str) -> None:
    assert SINGLE.literal(value) == text


def test_double_literals_round_trip() -> None:
    assert float(DOUBLE.literal(0.1)) == 0.1
