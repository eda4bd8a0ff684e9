"""What of mu_eff is friction, where the contact of a found model follows the load."""

from types import SimpleNamespace
from typing import Any

import pytest

from brushgrip.estimation.friction_at_common_load import friction_load_text, friction_to_mu_eff_ratio
from symbolic import Model, Rig, effects_named

LAW = {"contact_length.n": 0.5, "contact_length.F_0": 300.0, "contact_length.m": 2.0}


def found(effect: str, **values: float) -> Any:
    model = Model(effects=effects_named([effect]))
    return SimpleNamespace(model=model, values_for_estimation=lambda _: {"k": 2e6, **values})


def test_friction_without_the_growth_of_the_contact() -> None:
    recording: Any = SimpleNamespace(rig=Rig(a=0.045, e=0.0), ground="floor", F_N=[300.0, 432.0])
    longer = found("contact_length", **LAW)

    # The arm of full slide is 3/8 of a half-length that is 1.2 times the declared one, or less.
    assert friction_to_mu_eff_ratio(longer, recording, 432.0) == pytest.approx(1 / 1.2)
    assert friction_to_mu_eff_ratio(longer, recording, 75.0) == pytest.approx(2)
    assert friction_to_mu_eff_ratio(longer, recording, 1e4) == pytest.approx(1 / 1.25)
    assert "at 432 N, over the declared half-length; of the" in friction_load_text(longer, recording, 1)
    assert "there friction is 0.83 times mu_eff" in friction_load_text(longer, recording, 1)
    steeper = found("load_dependent_friction", **{"load_dependent_friction.n": 0.4})
    assert friction_load_text(steeper, recording, 1).endswith("mu_eff is that at 432 N")
