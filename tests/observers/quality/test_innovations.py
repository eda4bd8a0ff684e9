"""Innovations of a run against scipy's normal density, and what they must be on average."""

from math import inf

import numpy as np
import pytest
from scipy.stats import norm

from observers import AligningTorque, Ekf, innovations, run
from reference_rig import RigRecording
from symbolic import InvalidInputError
from tests.observers.conftest import make
from tests.observers.factories import columns_of


def test_density_is_normal_and_the_variance_that_of_the_sensor(recording: RigRecording) -> None:
    columns = columns_of(recording)
    noise = 0.004 * np.ptp(recording.M_z_true)
    observer = make(
        Ekf,
        noise=noise / 6.75,
        error=inf,
        gate=inf,
        mu_walk=0.0,
        measurement_model=AligningTorque(zero=False),
    )
    made = innovations(run(observer, **columns), columns["M_z"])
    late = slice(800, None)

    assert np.median(made.variance[late]) == pytest.approx(noise**2, rel=0.05)
    assert np.std(made.innovation[late]) == pytest.approx(noise, rel=0.15)
    expected = norm.logpdf(made.innovation, scale=np.sqrt(made.variance))
    np.testing.assert_allclose(made.log_likelihood, expected, rtol=1e-9)


def test_missing_samples_have_none_and_shapes_are_checked(recording: RigRecording) -> None:
    columns = columns_of(recording, slice(0, 200))
    columns["M_z"] = np.where(np.arange(200) == 120, np.nan, columns["M_z"])
    estimates = run(make(Ekf), **columns)

    assert np.isnan(innovations(estimates, columns["M_z"]).log_likelihood[120])
    with pytest.raises(InvalidInputError, match="shape of the estimates"):
        innovations(estimates, columns["M_z"][1:])
