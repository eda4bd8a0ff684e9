"""Curves of mechanisms against their laws, and what they are drawn from."""

from dataclasses import replace

import numpy as np
import pytest

from identification import Recording
from identification.diagnosis.mechanisms_of_final_model import families_with_curves
from identification.diagnosis.result_parts import FoundEffect, FoundFamily
from identification.fits.covariance import standard_deviations
from identification.fits.fitting import Fit
from identification.selection.trial import RANKING, TrialTask, run_trial
from symbolic import EFFECTS
from tests.identification.factories import read_campaign

pytestmark = pytest.mark.usefixtures("interpreted")
NAMES = ("rate_friction", "carcass_torsion", "pretwist")


def effect(name: str, rivals: tuple[str, ...] = ()) -> FoundEffect:
    return FoundEffect(
        name=name, summary="", family=EFFECTS[name].family, parameters={}, holdout_nrmse_after=0.0,
        delta_bic=0.0, indistinguishable_from=rivals,
    )  # fmt: skip


@pytest.fixture(scope="module")
def recordings() -> list[Recording]:
    return read_campaign("carcass_torsion", 3, duration=4.0)[1]


@pytest.fixture(scope="module")
def fitted(recordings: list[Recording]) -> Fit:
    effects = tuple(EFFECTS[name] for name in NAMES)
    trial = run_trial(TrialTask(effects, recordings, precision=RANKING))
    return replace(trial.fitted, values=trial.fitted.values.having({(None, "rate_friction.c"): 0.05}))


@pytest.fixture(scope="module")
def families(fitted: Fit, recordings: list[Recording]) -> tuple[FoundFamily, ...]:
    found = [effect(NAMES[0], ("stribeck",)), effect(NAMES[1]), effect(NAMES[2])]
    return families_with_curves(found, fitted, recordings)


def test_a_family_has_its_effects_and_their_rivals(families: tuple[FoundFamily, ...]) -> None:
    assert [(f.name, f.effects, f.rivals) for f in families] == [
        ("friction over speed", ("rate_friction",), ("stribeck",)),
        ("compliance and contact shape", ("carcass_torsion",), ()),
        ("sensor and steering", ("pretwist",), ()),
    ]
    assert families[2].curve is None


def test_friction_over_speed_is_the_law(
    families: tuple[FoundFamily, ...], fitted: Fit, recordings: list[Recording]
) -> None:
    curve = families[0].curve
    assert curve is not None
    c, mu = fitted.values.tyre["rate_friction.c"], curve.declared[0]
    assert mu in [own["mu"] for own in fitted.values.own.values()]
    np.testing.assert_allclose(curve.y, mu * (1 + c * np.log(np.hypot(curve.x, 1e-4) / 1e-3)), rtol=1e-9)
    # At 1 mm/s the law is mu, whatever c is.
    (name,) = [name for name, own in fitted.values.own.items() if own["mu"] == mu]
    deviations = dict(zip(fitted.labels, standard_deviations(fitted, recordings), strict=True))
    at_reference = np.interp(np.log(1e-3), np.log(curve.x), curve.std)
    assert at_reference == pytest.approx(deviations[name, "mu"], rel=0.05)
    assert curve.std.max() > at_reference


def test_torque_over_angle_is_softer_than_declared_and_an_unknown_deviation_null_in_the_file(
    families: tuple[FoundFamily, ...],
) -> None:
    curve = families[1].curve
    assert curve is not None
    turn = slice(1, 20)
    assert (np.abs(curve.y[turn]) < np.abs(curve.declared[turn])).all()
    assert curve.x[0] == curve.y[0] == 0.0
    assert np.isfinite(curve.std).all()
    curve.std[-1] = np.inf
    content = families[1].to_dict()["curve"]
    assert content["std"][-1] is None
    assert content["x"] == curve.x.tolist()
