"""What a notebook shows of results: a line, not thousands of numbers."""

from dataclasses import fields, replace

import numpy as np

from observers import Estimates
from tests.identification.factories import read_campaign


def test_a_recording() -> None:
    recording = replace(read_campaign(None, 3, duration=8.0)[1][0], name="fem1", ground="ice")

    assert repr(recording) == f"<Recording fem1 on ice: {recording.t.size} samples, 8 s>"


def test_estimates() -> None:
    one = np.array([0.5, 0.7])
    estimates = Estimates(**{field.name: one for field in fields(Estimates)})
    none = Estimates(**{field.name: np.empty(0) for field in fields(Estimates)})

    assert repr(estimates) == "<Estimates of 2 samples to 0.7 s: mu 0.700 ± 0.700 at the end, informed>"
    assert repr(none) == "<Estimates of no sample>"
