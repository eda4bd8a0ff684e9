"""What differs between recordings of one ground and load."""

from dataclasses import replace

import numpy as np
import pytest

from identification.reading.recordings import Recording
from identification.residuals.full_slide_repeatability import full_slide_friction, repeatability
from reference_rig import make_recording
from symbolic import Rig
from tests.identification.factories import recording

K = 2.5e6


def recorded(
    name: str, mu: float, load: float = 400.0, ground: str = "floor", a: float = 0.045
) -> Recording:
    made = make_recording(7, mu=mu, k=K, a=a, e=0.009, load=load, duration=12.0, bristles=200)
    rig = Rig(a=a, e=0.009)
    read = recording(name, ground, made.psi, period=made.t[1] - made.t[0], rig=rig, k=K)
    return replace(read, M_z=made.M_z, F_N=made.F_N)


def test_the_level_of_full_slide_is_friction() -> None:
    for mu in (0.1, 0.7):
        assert full_slide_friction(recorded("one", mu), K) == pytest.approx(mu, rel=0.06)
    still = recorded("still", 0.7)
    assert np.isnan(full_slide_friction(replace(still, psi=0.01 * still.psi), K))


def test_replicates_tell_how_well_recordings_repeat() -> None:
    pair = [recorded("one", 0.70), recorded("two", 0.77, load=410.0)]
    others = [recorded("heavy", 0.9, load=600.0), recorded("wet", 0.3, ground="wet")]
    found = repeatability([*others, *pair], K)

    assert found is not None
    assert found.replicates == (("one", "two"),)
    assert found.spread == pytest.approx(np.log(1.1) / np.sqrt(2), rel=0.05)
    assert found.spreads == pytest.approx((found.spread,))
    both = repeatability([*pair, recorded("dry", 0.3, ground="wet"), others[1]], K)
    assert both is not None
    assert both.spreads == pytest.approx((found.spread, 0.0)), "each group has its own"
    shares = [np.sqrt(np.mean(r.M_z**2)) / np.ptp(r.M_z) for r in pair]
    assert found.nrmse == pytest.approx(found.spread / np.sqrt(2) * np.mean(shares))
    assert repeatability([*others, pair[0], recorded("long", 0.7, a=0.055)], K) is None
