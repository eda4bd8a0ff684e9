"""Friction before and after: what belongs to training and held-out recordings, and the offline fit."""

from types import SimpleNamespace

import numpy as np
import pytest

from brushgrip.estimation.friction_outcome import FrictionOutcome, friction_figures, offline_friction
from identification import FoundModel
from observers import FrictionQuality
from symbolic import Model, Rig, effects_named


def quality(settling: float) -> FrictionQuality:
    return FrictionQuality(
        mu_eff=1.0, mu_eff_std=0.1, settling=settling, drift=0.1, coverage=1.0, relative_band=0.1,
        reference_coverage=settling / 10,
    )  # fmt: skip


def outcome(*holdout: str) -> FrictionOutcome:
    before = {name: quality(s) for name, s in (("a", 1.0), ("b", 2.0), ("c", 6.0), ("d", 8.0))}
    after = {name: quality(1.0) for name in before}
    return FrictionOutcome(before=before, after=after, grounds={"": tuple(before)}, holdout=holdout)


def test_training_and_held_out_recordings_are_reported_apart() -> None:
    before = outcome("c", "d").to_dict()["before"]

    assert before["mean"]["settling"] == 4.25
    assert before["training"]["mean"]["settling"] == 1.5
    assert before["holdout"]["mean"]["settling"] == 7.0
    assert before["holdout"]["mean"]["reference_coverage"] == pytest.approx(0.7)
    rows = dict(friction_figures(outcome("c", "d")))
    assert rows["training: settled within 10 %, mean [s]"] == ["1.5", "1.0"]
    assert rows["held out: settled within 10 %, mean [s]"] == ["7.0", "1.0"]


def test_without_held_out_recordings_all_are_training() -> None:
    assert "holdout" not in outcome().to_dict()["before"]
    assert not any(label.startswith("held out") for label, _ in friction_figures(outcome()))


def test_the_offline_fit_counts_the_length_that_was_fitted() -> None:
    # Full slide of the declared patch is proportional to mu, load and, with e = 0, half-length; the
    # mean of both directions is (1 + ratio) / 2 of the greater.
    model = Model(effects=effects_named(["asymmetric_friction"]))
    tyre = {"k": 3e6, "asymmetric_friction.ratio": 0.8}
    own = {"one": {"mu": 1.2}, "other": {"mu": 1.2}}
    found = FoundModel(model=model, tyre=tyre, own=own, rig={"one": {"a": 0.044, "load": 1.05}})
    recording = SimpleNamespace(name="one", rig=Rig(a=0.04, e=0.0), F_N=np.full(3, 400.0), ground=None)

    plain = SimpleNamespace(**{**vars(recording), "name": "other"})
    ratio = offline_friction(found, recording) / offline_friction(found, plain)  # type: ignore[arg-type]
    assert ratio == pytest.approx(1.1 * 1.05, rel=1e-9)
    tyre["asymmetric_friction.ratio"] = 1.0
    assert offline_friction(found, plain) == pytest.approx(1.2, rel=1e-6)  # type: ignore[arg-type]
