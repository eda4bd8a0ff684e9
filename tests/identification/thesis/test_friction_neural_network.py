"""A network learns what its inputs tell, and says what it was taught."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from identification import Recording
from identification.thesis.friction_neural_network import (
    Activation,
    LabelMean,
    NetworkDesign,
    label_mean,
    train_network,
)
from symbolic import Tyre
from tests.identification.factories import recording
from tests.refusal import refused

Array = NDArray[np.float64]


def made(mu: float | None, samples: int = 400, seed: int = 0) -> Recording:
    """A recording whose load and torque together tell its mu; k, which it also shows, does not."""
    rng = np.random.default_rng(seed)
    F_N = rng.uniform(100.0, 500.0, samples)
    plain = recording(f"mu {mu}", psi=rng.uniform(-1.0, 1.0, samples))
    return replace(plain, M_z=0 * F_N - (mu or 0.0), F_N=F_N, tyre=Tyre(k=2.4e6, mu=mu))


def telling(recording: Recording) -> Array:
    """The mu in hiding, beside what has nothing to do with it, in sizes far apart."""
    return np.column_stack([
        -1e-3 * recording.M_z, recording.psi, 1e3 * recording.F_N, np.full(recording.t.size, 2.4e6),
    ])  # fmt: skip


def blind(recording: Recording) -> Array:
    return recording.psi[:, None]


def biased(recording: Recording) -> Array:
    """An estimate of mu that is right up to a share of the angle."""
    return np.column_stack([recording.psi, -recording.M_z + 0.3 * recording.psi])


LABELS = (0.5, 0.9, 1.4, 1.8)


@pytest.fixture
def training() -> list[Recording]:
    pytest.importorskip("sklearn", reason="networks need scikit-learn: pip install -e '.[networks]'")
    return [made(mu, seed=number) for number, mu in enumerate(LABELS)]


@pytest.mark.long
@pytest.mark.parametrize("activation", list(Activation))
def test_what_the_inputs_tell_is_learned(training: list[Recording], activation: Activation) -> None:
    design = NetworkDesign(activation=activation, rate=1e-2)
    network = train_network(training, telling, design, name="it")
    error = np.abs(network.estimate_mu_eff(made(1.1, seed=9)) - 1.1).max()

    print(f"{activation.name}: within {error:.3f}")
    assert error < 0.1
    assert network.losses[-1] < 0.1 * network.losses[0]
    assert (network.name, network.works_beyond_five_zones, network.gives_deviation) == (
        "it", True, False,
    )  # fmt: skip


@pytest.mark.long
def test_what_they_do_not_tell_is_the_mean_of_the_labels(training: list[Recording]) -> None:
    guess = label_mean(training)
    said = train_network(training, blind).estimate_mu_eff(made(0.5, seed=9))

    assert guess.mu == pytest.approx(np.mean(LABELS))
    np.testing.assert_allclose(guess.estimate_mu_eff(training[0]), guess.mu)
    np.testing.assert_allclose(said, guess.mu, atol=0.2)


@pytest.mark.long
def test_a_single_label_is_all_that_is_said(training: list[Recording]) -> None:
    said = train_network([made(1.9), made(1.9, seed=1)], telling).estimate_mu_eff(training[0])

    # Labels without variance score every pass alike, so the first one is kept.
    np.testing.assert_allclose(said, 1.9, atol=0.1)


@pytest.mark.long
def test_on_top_of_an_estimate_it_learns_the_error(training: list[Recording]) -> None:
    test = made(1.1, seed=9)
    network = train_network(training, biased, NetworkDesign(rate=1e-2), base=1)
    error = network.estimate_mu_eff(test) - 1.1

    assert np.abs(error).max() < 0.05 < 0.2 < np.abs(biased(test)[:, 1] - 1.1).max()
    assert not network.works_beyond_five_zones


@pytest.mark.long
def test_the_same_seed_gives_the_same_network(training: list[Recording]) -> None:
    same = [
        train_network(training, telling, NetworkDesign(seed=seed)).estimate_mu_eff(training[0])
        for seed in (1, 1, 2)
    ]

    np.testing.assert_array_equal(same[0], same[1])
    assert (same[0] != same[2]).any()


def test_without_labels_or_samples_there_is_no_training(training: list[Recording]) -> None:
    assert "mu None: declares no mu" in refused(train_network, [*training, made(None)], telling)
    assert "declares no mu" in refused(label_mean, [made(None)])
    assert "at least 100 samples, got 50" in refused(train_network, [made(0.5, samples=50)], telling)


def test_without_the_library_one_line_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "sklearn.neural_network", None)

    assert "pip install 'brushgrip[networks]'" in refused(train_network, [made(0.5)], telling)
    assert label_mean([made(0.5)]) == LabelMean(mu=0.5)
