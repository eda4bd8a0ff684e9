"""Where the free vibration begins and ends, and what cannot be used."""

import numpy as np
import pytest

from identification.free_decay.vibration_detection import encoder_step, find_vibration
from reference_rig import make_impact
from symbolic import InvalidInputError
from tests.identification.factories import decay

T = np.arange(1500) / 1000
STEP = 2 * np.pi / 2**14
ANGLE = 0.0123 + 0.006 * np.exp(-4 * T) * np.cos(33 * T)
RNG = np.random.default_rng(5)


def swinging(reach: float = 0.006, damping: float = 4.0, omega: float = 33.0) -> np.ndarray:
    return np.round((0.1 + reach * np.exp(-damping * T) * np.cos(omega * T)) / STEP) * STEP


def test_finds_the_turning_point_after_the_impact() -> None:
    made = make_impact(6)
    found = find_vibration(decay(made.t, made.psi))
    true = int(np.argmax(np.abs(made.psi_true)))

    assert abs(found.first - true) <= 3
    assert abs(found.first_deflection - made.psi_true[true]) < 1.5 * STEP
    assert found.omega == pytest.approx(33, rel=0.05)
    assert found.damping == pytest.approx(3.4, rel=0.4)
    assert found.step == pytest.approx(STEP)
    # What is left after the end is below half a step.
    assert np.ptp(made.psi_true[found.last :]) < STEP


def test_guesses_and_the_end_with_the_recording() -> None:
    found = find_vibration(decay(T, swinging()))

    # The turning point is on the encoder's first plateau, which begins the recording.
    assert found.first < 10
    assert found.omega == pytest.approx(33, rel=0.02)
    assert found.damping == pytest.approx(4, rel=0.1)
    lasted = pytest.approx(found.t[-1] - found.t[0], rel=0.05)
    assert np.log(0.006 / STEP / 0.25) / found.damping == lasted
    found = find_vibration(decay(T, swinging(damping=0.2)))
    assert found.last == T.size


def test_wrong_readings_are_no_impact() -> None:
    psi = swinging()
    spoiled = psi.copy()
    spoiled[[300, 301, -1]] += 0.02

    assert find_vibration(decay(T, spoiled)).first == find_vibration(decay(T, psi)).first


@pytest.mark.parametrize(
    ("psi", "fault"),
    [
        (np.full(T.size, 0.1), "run: psi is constant; the wheel has to be struck"),
        (
            swinging(reach=2 * STEP),
            "run: the wheel swings by 0.77 mrad, 2 steps of the encoder; at least 3",
        ),
        (
            np.degrees(swinging()),
            "run: the wheel swings by 0.3[0-9]* rad; allowed: up to 0.2 rad, .* is psi in",
        ),
        (swinging(omega=4.0), "run: holds 1.49 s after its largest deflection, in which psi does not"),
        (swinging()[::-1], "run: holds 0.00[0-9]* s after its largest deflection"),
    ],
    ids=["still", "faint", "degrees", "slow", "nothing after it"],
)
def test_faults(psi: np.ndarray, fault: str) -> None:
    with pytest.raises(InvalidInputError, match=fault) as caught:
        find_vibration(decay(T, psi))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("digits", [6, 8, 12])
def test_step_survives_rounding_in_the_file(digits: int) -> None:
    psi = np.round(np.round(ANGLE / STEP) * STEP, digits)

    assert encoder_step(psi) == pytest.approx(STEP, rel=2 * 10.0**-digits / np.ptp(psi))


def test_step_despite_wrong_readings_and_where_there_is_none() -> None:
    psi = np.round(ANGLE / STEP) * STEP
    psi[RNG.choice(psi.size, 20, replace=False)] += RNG.normal(0, 0.01, 20)

    assert encoder_step(psi) == pytest.approx(STEP, rel=1e-9)
    assert encoder_step(np.array([0.0, 3 * STEP, 2 * STEP])) == pytest.approx(STEP)
    assert encoder_step(ANGLE) == pytest.approx(1e-6 * np.ptp(ANGLE))
    assert encoder_step(ANGLE + RNG.normal(0, 1e-4, T.size)) < 1e-5 * np.ptp(ANGLE)
