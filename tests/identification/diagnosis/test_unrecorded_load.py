"""A load that was not recorded may be what a steering return seems to be."""

from dataclasses import replace

import numpy as np
import pytest

from identification import diagnose
from identification.diagnosis.found_effects import UNRECORDED_LOAD
from tests.identification.factories import read_campaign

pytestmark = pytest.mark.usefixtures("interpreted")
NAME = "steering_return"


@pytest.mark.parametrize("sign", [1.0, pytest.param(-1.0, marks=pytest.mark.long)])
def test_a_return_torque_beside_a_constant_load_is_ambiguous(sign: float) -> None:
    _, recordings = read_campaign(None, 3, duration=8.0)
    turned = [replace(r, M_z=r.M_z - sign * 4.0 * r.psi) for r in recordings]
    (known,) = diagnose(turned, candidates=(NAME,), jobs=1).effects
    assert (known.grade, known.indistinguishable_from) == ("strong", ())

    constant = [replace(r, F_N=np.full(r.t.size, r.F_N.mean())) for r in turned]
    result = diagnose(constant, candidates=(NAME,), jobs=1)
    (effect,) = result.effects
    assert (effect.grade, effect.indistinguishable_from) == ("ambiguous", (UNRECORDED_LOAD,))
    assert f"{NAME}: it is this, or a load that changes with the angle: record it" in result.notes
    assert any("a negative stiffness, so no spring" in note for note in result.notes) is (sign < 0)
