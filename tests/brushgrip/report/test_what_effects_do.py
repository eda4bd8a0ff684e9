"""What an effect does is told with its size, in units that somebody at the rig knows."""

from dataclasses import replace
from math import inf

import pytest

from brushgrip.report.what_effects_do import OVER_SPEED, effect_size_text, effect_summary
from identification import ParameterEstimate
from symbolic import EFFECTS
from symbolic.vehicle.candidate_effects import CAR_EFFECTS
from tests.brushgrip.factories import make_diagnosis

ELSEWHERE = ("asymmetric_friction",)
"""Effects whose size `effect_summary` tells by itself."""


@pytest.mark.parametrize(
    ("name", "parameters", "told"),
    [
        ("backlash", {"gap": 0.0636}, "3.6° or 0.064 rad from end to end"),
        ("carcass_torsion", {"k_t": 391.2}, "by 0.15° for each N m"),
        ("torque_offset", {"M_0 [a]": -0.123, "M_0 [b]": 0.3}, "−0.12 to 0.3 N m"),
        ("zero_drift", {"rate [a]": 0.01}, "0.6 N m in a minute"),
        ("sensor_delay", {"delay": 0.0231}, "by 23 ms"),
        ("steering_return", {"stiffness": 2.0}, "0.035 N m for each degree"),
        ("jacking", {"stiffness": 12000.0}, "209 N m for each degree"),
        ("patch_width", {"half_width": 0.015}, "30 mm"),
        ("contact_length", {"n": 0.3, "F_0": 400.0, "m": 3.0}, "10 % more load makes it 2.9 % longer"),
        ("load_dependent_friction", {"n": 0.1}, "10 % more load changes it by −0.95 %"),
        (
            "friction_drift",
            {"gain [ice]": -0.1, "gain [snow]": 0.2, "scale": 0.5},
            "by −10 to 20 % in the end, most of it within 29° of turning",
        ),
        ("carcass_torsion", {"other": 1.0}, ""),
        ("torque_offset", {"M_0": inf}, ""),
        ("of_your_own", {"c": 1.0}, ""),
    ],
)
def test_the_size_of_an_effect_is_told(name: str, parameters: dict[str, float], told: str) -> None:
    values = {
        label: ParameterEstimate(value=value, std=None, unit="1") for label, value in parameters.items()
    }
    effect = replace(make_diagnosis().effects[0], name=name, parameters=values)
    assert effect_size_text(effect) == told


@pytest.mark.parametrize("name", sorted({**EFFECTS, **CAR_EFFECTS}))
def test_no_effect_of_the_library_is_named_without_its_size(name: str) -> None:
    known = {**EFFECTS, **CAR_EFFECTS}[name]
    values = {p.name: ParameterEstimate(value=0.1, std=0.01, unit=p.unit) for p in known.parameters}
    diagnosis = make_diagnosis()
    effect = replace(
        diagnosis.effects[0], name=name, summary=known.summary, family=known.family, parameters=values
    )
    if known.family == OVER_SPEED or name in ELSEWHERE:
        assert effect_size_text(effect) == ""
    else:
        assert effect_summary(diagnosis, effect).endswith(f": {effect_size_text(effect)}")
        assert effect_size_text(effect)


def test_play_is_told_in_plain_words() -> None:
    gap = ParameterEstimate(value=0.0636, std=1e-4, unit="rad")
    effect = replace(
        make_diagnosis().effects[0],
        name="backlash",
        family="sensor and steering",
        parameters={"gap": gap},
    )
    assert effect_summary(make_diagnosis(), effect) == (
        "the linkage between angle sensor and tyre has play: 3.6° or 0.064 rad from end to end"
    )
