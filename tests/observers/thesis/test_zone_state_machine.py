"""The source's zones: the state machine against its files, the torque against the printed q(x)."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad

from observers.thesis.zone_state_machine import (
    ZoneState,
    advance_zones,
    turns_from_rest_and_reversal,
    zone_torque_curve,
)
from symbolic import Rig
from tests.observers.published import ASPHALT, DIRECTION, FIVE_ZONES, PSI_MAX, STEEL, published
from tests.symbolic.oracles import Tyre

TYRE = Tyre(mu=1.3)
LOAD = 400.0
REACH = 4 * TYRE.slope(LOAD) * TYRE.a
"""A turn after which nearly all of the patch slides [rad]."""


def machine(angles: Sequence[float], least_turn: float = 1e-9) -> list[ZoneState]:
    states = [ZoneState()]
    for psi in angles:
        states.append(advance_zones(states[-1], psi, least_turn))
    return states[1:]


@pytest.mark.parametrize("side", [1, -1])
def test_reversal_makes_five_zones_and_exceeding_it_makes_three(side: int) -> None:
    angles = [0.0, 0.1, 0.2, 0.15, -0.1, -0.2, -0.21, -0.3, -0.25, 0.29, 0.31]
    seen = machine([side * psi for psi in angles])

    assert [state.zones for state in seen] == [3, 3, 3, 5, 5, 5, 3, 3, 5, 5, 3]
    assert [side * state.direction for state in seen] == [0, 1, 1, -1, -1, -1, -1, -1, 1, 1, 1]
    assert [side * state.psi_max for state in seen] == [0, 0, 0, *[0.2] * 5, *[-0.3] * 3]


def test_reversal_inside_five_zones_and_swing_between_two_samples_are_passed_over() -> None:
    seen = machine([0.0, 0.3, 0.1, -0.1, -0.05, 0.2, -0.2, 0.31, 0.3])

    assert [state.zones for state in seen] == [3, 3, 5, 5, 5, 5, 5, 3, 5]
    assert [state.psi_max for state in seen] == [0, 0, *[0.3] * 6, 0.31]
    assert {state.direction for state in seen[2:7]} == {-1}
    assert machine([0.0, 0.1, -0.2])[-1] == ZoneState(extreme=-0.2, psi_max=0.1, zones=3)


def test_only_a_turn_back_beyond_the_least_turn_is_a_reversal() -> None:
    wobble = [0.0, 0.1, 0.0985, 0.1005, 0.0990]
    still, back = machine([*wobble, 0.0986], 2e-3)[-1], machine([*wobble, 0.0984], 2e-3)[-1]

    assert (still.zones, still.direction, still.extreme) == (3, 1, 0.1005)
    assert (back.zones, back.direction, back.psi_max) == (5, -1, 0.1005)


@pytest.mark.measured
@pytest.mark.parametrize(("name", "shift"), STEEL + ASPHALT)
def test_zones_are_the_published_ones(measured_dir: Path, name: str, shift: int) -> None:
    recording, columns, same_samples = published(measured_dir, name, shift)
    psi, psi_max, direction, five = (
        recording.psi, columns[PSI_MAX], columns[DIRECTION], columns[FIVE_ZONES] == 1
    )  # fmt: skip

    states = machine(psi - psi[0], least_turn=0.0)[same_samples]
    ours = np.array([state.zones == 5 for state in states])

    # The patch is at rest at the first angle here, at angle zero there: that shifts an end by a sample.
    assert np.sum(ours != five) <= 3
    same = (ours == five) & five
    found = np.array([state.psi_max for state in states]) + psi[0]
    # Theirs is the mean of the two samples about the reversal.
    np.testing.assert_allclose(found[same], psi_max[same], atol=1e-4)
    turning = np.array([state.direction > 0 for state in states])
    assert (turning[same] == direction[same]).all()


class Printed:
    """q of [Györök 2022] at one time, (3.4) to (3.6), with the boundaries of its appendix."""

    def __init__(self, psi: float, psi_max: float | None, tyre: Tyre) -> None:
        """Work out the zones; `psi_max` None for three."""
        self.tyre, self.psi, self.five = tyre, psi, psi_max is not None
        turn = psi if psi_max is None else psi_max
        self.side, self.c = np.sign(turn), tyre.slope(LOAD)
        a, e, k, mu = tyre.a, tyre.e, tyre.k, tyre.mu
        square, cross = 9 * (LOAD * mu) ** 2 + 4 * a**4 * (k * turn) ** 2, 12 * LOAD * a * e * k * mu
        back = 2 * a * a * k * abs(turn)
        sigma_3, sigma_6 = (np.sqrt(square + sign * cross * abs(turn)) - back for sign in (-1, 1))
        self.inner = -a * sigma_3 / (3 * LOAD * mu), a * sigma_6 / (3 * LOAD * mu)
        self.outer = self.inner
        if self.five:
            self.m = [self._slope(x, end) for x, end in zip(self.inner, (1, -1), strict=True)]
            self.outer = tuple(
                self._boundary(x, m, end) for x, m, end in zip(self.inner, self.m, (1, -1), strict=True)
            )

    def parabola(self, x: float) -> float:
        """3 F_N mu / (4 a^3 k) (a^2 - x^2); the appendix leaves its 4 a^3 k out."""
        return self.c * (self.tyre.a**2 - x * x)

    def _slope(self, x: float, end: int) -> float:
        # num(m) / denum(m): the rotated parabola meets the middle zone at x_R*, x_L*.
        return -self.psi - end * self.side * self.parabola(x) / (x - self.tyre.e)

    def _boundary(self, inner: float, m: float, end: int) -> float:
        # x_R, x_L: 2 c (a^2 - x^2) = -m (x - e) on either end. sigma_5 with its mirror image sigma_6.
        rise = 2 * end * self.side * self.c
        roots = np.roots([-rise, m, rise * self.tyre.a**2 - m * self.tyre.e])
        inside = [x for x in roots if abs(x) <= self.tyre.a and end * (inner - x) >= 0]
        assert len(inside) == 1
        return float(inside[0])

    def __call__(self, x: float) -> float:
        (x_R, x_L), (in_R, in_L), e = self.outer, self.inner, self.tyre.e
        ends = -self.side if self.five else self.side
        if x < x_R or x >= x_L:
            return ends * self.parabola(x) * (1 if x < x_R else -1)
        if x < in_R:
            return self.side * self.parabola(x) + self.m[0] * (x - e)
        if x < in_L:
            return -self.psi * (x - e)
        return -self.side * self.parabola(x) + self.m[1] * (x - e)

    def torque(self) -> float:
        """The integral (2.3) by quadrature, zone by zone."""
        tyre = self.tyre
        cuts = sorted({-tyre.a, *self.outer, *self.inner, tyre.a})
        pieces = [quad(lambda x: self(x) * (x - tyre.e), *piece)[0] for piece in pairwise(cuts)]
        return tyre.k * sum(pieces)


@pytest.mark.parametrize("e", [0.009, 0.0, -0.02])
@pytest.mark.parametrize("turn", [0.1, -0.5, 1.0, -2.5])
@pytest.mark.parametrize("back", [None, 0.9, 0.3, -0.2, -0.95])
def test_torque_is_the_integral_of_deformation(e: float, turn: float, back: float | None) -> None:
    tyre = replace(TYRE, e=e)
    psi_max = turn * REACH
    state = ZoneState(extreme=psi_max, psi_max=psi_max, zones=3 if back is None else 5)
    psi = psi_max if back is None else back * psi_max

    made, _ = zone_torque_curve(
        turns_from_rest_and_reversal(state, psi), LOAD, tyre.k, Rig(a=tyre.a, e=e)
    )(tyre.mu)

    expected = Printed(psi, None if back is None else psi_max, tyre).torque()
    assert made == pytest.approx(expected, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("turns", [(0.0, 0.0), (1e-9, 0.0), (0.3, 0.0), (0.3, -0.25), (-0.1, 0.15)])
def test_slope_of_the_torque_is_its_difference(turns: tuple[float, float]) -> None:
    torque = zone_torque_curve(turns, LOAD, TYRE.k, Rig(a=TYRE.a, e=TYRE.e))
    difference = (torque(1.3 + 1e-5)[0] - torque(1.3 - 1e-5)[0]) / 2e-5

    assert torque(1.3)[1] == pytest.approx(difference, rel=1e-6, abs=1e-9)
