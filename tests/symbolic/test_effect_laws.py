"""Laws of single effects in closed form, where the reference rig's grid would hide a small error."""

from math import e, exp

import numpy as np
import pytest

from symbolic import EFFECTS, BristleTraits

LENGTHS = np.array([0.03, 0.04, 0.05])


def test_skew_moves_the_pressure_centre_by_a_fifth() -> None:
    """The centre of (1 - u^2) (1 + skew u) is skew / 5, and its load that of the parabola."""
    u, weight = np.polynomial.legendre.leggauss(8)
    (factor,) = EFFECTS["pressure_skew"].traits(BristleTraits(), {"skew": 0.6}).shape
    pressure = 0.75 * (1 - u**2) * factor(u)

    assert weight @ pressure == pytest.approx(1.0, rel=1e-12)
    assert weight @ (u * pressure) == pytest.approx(0.6 / 5, rel=1e-12)


def test_stribeck_has_fallen_to_one_over_e_at_its_speed() -> None:
    (factor,) = EFFECTS["stribeck"].traits(BristleTraits(), {"ratio": 1.4, "v_s": 3e-3}).limits

    assert float(factor(0.0)) == pytest.approx(1.4, rel=1e-12)
    assert float(factor(3e-3)) == pytest.approx(1 + 0.4 / e, rel=1e-12)
    assert float(factor(9e-3)) == pytest.approx(1 + 0.4 * exp(-3), rel=1e-12)


def test_contact_length_multiplies_what_another_effect_makes_the_patch_grow() -> None:
    values = {"n": 0.5, "F_0": 400.0, "m": 2.0}

    grown = EFFECTS["contact_length"].traits(BristleTraits(growth=lambda *_: 1.1), values).growth

    assert grown is not None
    assert float(grown(900.0, 0.045)) == pytest.approx(1.1 * 1.5, rel=1e-12)


@pytest.mark.parametrize(("power", "expected"), [(0.4, 1.0), (1.7, 1.7), (4.2, 4.2), (7.0, 5.0)])
def test_contact_length_reads_the_power_off_the_recordings(power: float, expected: float) -> None:
    loads = 400.0 * (LENGTHS / 0.045) ** power

    fixed = EFFECTS["contact_length"].fixed_values(list(LENGTHS), list(loads))

    assert fixed["m"] == pytest.approx(expected, rel=1e-12)
    if power == expected:
        assert fixed["F_0"] == pytest.approx(400.0, rel=1e-12)
