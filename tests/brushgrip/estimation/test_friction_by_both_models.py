"""Friction of the offline fit, and friction told at one load."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from brushgrip.estimation.friction_at_common_load import at_load, common_load
from brushgrip.estimation.friction_by_both_models import offline_mu_eff_at_end
from identification import FoundModel
from symbolic import Model, Rig, effects_named
from tests.brushgrip.factories import make_estimates

AT_REST = {"t": np.arange(3.0), "psi": np.zeros(3), "psi_dot": np.zeros(3)}


def test_the_offline_fit_counts_the_length_that_was_fitted() -> None:
    # Full slide of the declared patch is proportional to mu, load and, with e = 0, half-length; the
    # mean of both directions is (1 + ratio) / 2 of the greater.
    model = Model(effects=effects_named(["asymmetric_friction"]))
    tyre = {"k": 3e6, "asymmetric_friction.ratio": 0.8}
    own = {"one": {"mu": 1.2}, "other": {"mu": 1.2}}
    found = FoundModel(model=model, tyre=tyre, own=own, rig={"one": {"a": 0.044, "load": 1.05}})
    recording = SimpleNamespace(
        name="one", rig=Rig(a=0.04, e=0.0), F_N=np.full(3, 400.0), ground=None, **AT_REST
    )

    plain = SimpleNamespace(**{**vars(recording), "name": "other"})
    ratio = offline_mu_eff_at_end(found, recording) / offline_mu_eff_at_end(found, plain)  # type: ignore[arg-type]
    assert ratio == pytest.approx(1.1 * 1.05, rel=1e-9)
    tyre["asymmetric_friction.ratio"] = 1.0
    assert offline_mu_eff_at_end(found, plain) == pytest.approx(1.2, rel=1e-6)  # type: ignore[arg-type]


def test_friction_that_depends_on_the_load_is_told_at_one_load() -> None:
    """mu_eff goes with F_N^-n, so that from 400 N to 800 N it falls by 2^-n."""
    model = Model(effects=effects_named(["load_dependent_friction"]))
    found = FoundModel(model=model, tyre={"k": 3e6, "load_dependent_friction.n": 0.2}, own={})
    loads = np.array([400.0, 800.0, 500.0])
    recording = SimpleNamespace(
        name="one", rig=Rig(a=0.04, e=0.0), F_N=loads, ground=None, standstills=None, **AT_REST
    )
    seen = make_estimates([0, 0, 0], mu_eff=loads**-0.2, mu_eff_std=0.1 * loads**-0.2)
    told = at_load(seen, found, recording, 500.0)  # type: ignore[arg-type]

    np.testing.assert_allclose(told.mu_eff, 500.0**-0.2)
    np.testing.assert_allclose(told.mu_eff_std, 0.1 * 500.0**-0.2)
    lighter = SimpleNamespace(**{**vars(recording), "F_N": np.full(3, 300.0)})
    assert common_load(found, [recording, lighter]) == 300.0, "one recorded"  # type: ignore[list-item]
    assert common_load(replace(found, model=Model(), tyre={"k": 3e6}), [recording]) is None  # type: ignore[list-item]
    fitted = replace(found, own={"one": {"mu": 1.2}})
    at_two = [offline_mu_eff_at_end(fitted, recording, load) for load in (400.0, 800.0)]  # type: ignore[arg-type]
    assert at_two[1] / at_two[0] == pytest.approx(2**-0.2, rel=1e-9)


def test_the_offline_fit_tells_friction_at_the_end_where_it_drifts() -> None:
    model = Model(effects=effects_named(["friction_drift"]))
    drift = {"friction_drift.gain": 0.3, "friction_drift.scale": 0.5}
    found = FoundModel(model=model, tyre={"k": 3e6, **drift}, own={"one": {"mu": 1.2}})
    psi = np.array([0.0, 0.4, -0.2])
    recording = SimpleNamespace(
        name="one", rig=Rig(a=0.04, e=0.0), F_N=np.full(3, 400.0), ground=None, t=np.arange(3.0),
        psi=psi, psi_dot=np.gradient(psi),
    )  # fmt: skip

    grown = 1.2 * (1 + 0.3 * (1 - np.exp(-1.0 / 0.5)))
    assert offline_mu_eff_at_end(found, recording) == pytest.approx(grown, rel=1e-6)  # type: ignore[arg-type]
