"""The path of a wheel as branches between turning points, and the torque of each.

The memory of the patch is its turning points: from one to the next the torque changes by that of a
branch, by Masing's rules, `symbolic.masing` and [Györök 2022], section 2.2. A loop that closes is
forgotten. At most `POINTS` turning points are kept: friction is acquired within a few turns.

What the patch was before the first sample is not known. Two paths stand for its extremes: free of
torque, and turned so far that it slid, to the side that the torque at rest tells. Both paths end in the
same loop as soon as the patch has slid as a whole.

A branch gives information by the logarithm of its travel, `FRACTION` of it one independent sample of a
model's error: the shape of a loop scales with friction, so that ice, on which all is over within 0.02
rad, tells as much as asphalt.
"""

from functools import cache

import casadi as ca

from observers.layout import Expression, Parts, named, symbols, vector_of
from observers.measurement.torque_error import forgetting_factor
from symbolic.exact_zone_patch import FAR
from symbolic.masing import virgin_torque
from symbolic.named_and_buffered_functions import named_function
from symbolic.patch_moment_by_zones import (
    corner_moment_and_derivative,
    full_slide_level,
    unit_corner_moment,
)

POINTS = 4
"""Turning points that are remembered, the place of rest included."""
PATHS = 2
"""Paths to the first sample: of a patch free of torque, and of one that slid."""
SLID = 1.0
"""Turn after which the patch slides as a whole [rad]."""
RISEN = 3.0
"""Torque over that of the old ground's full slide from which on friction has risen [1]: with less, the
torque's zero may do it, and what the old ground left in the patch is no small part."""
FRACTION = 0.25
"""Growth of a branch's travel, in its logarithm, that is worth one independent sample of the model's
error [1]."""
START = 2.0
"""Deviations of the angle's noise by which a wheel at rest may seem to turn [1]."""
MIN_TRAVEL_DIVISOR = 1e-9
"""Least divisor that is a travel [rad]."""
MIN_SAMPLE_WEIGHT = 1e-3
"""Weight of a sample without travel, in independent samples [1]."""
MIN_SENSITIVITY = 1e-3
"""Lower limit of d ln M_z / d ln mu [1]."""
FORGETTING_SAMPLES = 40.0
"""Independent samples after which older ones are forgotten."""
ERRORS = 2.0
"""Squares of the model's error, over its variance, that an independent sample may have [1]."""
TRACK = (
    *("count", "direction", "extreme", "origin", "progress", "reach", "explained", "widest"),
    *("count_slid", "rest"),
)
"""Turning points in use; direction of travel, 0 at rest; farthest angle on the branch, and where it
began [rad]; travel of the branch that has been counted [rad]; greatest torque so far [N m]; squares
that errors and noise explain [1]; widest turn of a branch so far, that of a virgin one [rad]; turning
points in use if the patch slid before the first sample; sum of the torques at rest [N m]."""


@cache
def build_present_branch_update() -> ca.Function:
    """The present branch alone after a sample: (track, psi, slack, least, counts) -> (track, share).

    slack is the turn back that is no noise, least the travel at which a branch begins to tell something
    [rad]; counts is 0 where the sample's torque is not used. share is that of an independent sample.
    """
    inputs = symbols(ca.SX, track=len(TRACK), psi=1, slack=1, least=1, counts=1)
    after, back, _ = _branch_after_sample(named(TRACK, inputs["track"]), inputs["psi"], inputs["slack"])
    after, share = _update_progress(after, inputs["counts"], inputs["least"])
    after = {**after, "count": ca.if_else(back, ca.fmax(2, after["count"]), after["count"])}
    outputs = {"track_next": vector_of(TRACK, after), "share": share}
    return named_function("turn", inputs, outputs, cse=True)


def _branch_after_sample(
    was: Parts, psi: Expression, slack: Expression
) -> tuple[Parts, Expression, Expression]:
    """The branch after a sample, whether the wheel has turned back, and the farthest angle before."""
    direction, extreme = was["direction"], was["extreme"]
    starts = ca.logic_and(direction == 0, ca.fabs(psi - was["origin"]) > START * slack)
    onward = (psi - extreme) * direction >= 0
    back = (extreme - psi) * direction > slack
    heading = ca.if_else(psi > was["origin"], 1, -1)
    moves = ca.logic_and(direction != 0, ca.logic_or(onward, back))
    after = {
        **was,
        "direction": ca.if_else(starts, heading, ca.if_else(back, -direction, direction)),
        "extreme": ca.if_else(ca.logic_or(moves, starts), psi, extreme),
        "origin": ca.if_else(back, extreme, was["origin"]),
        "progress": ca.if_else(ca.logic_or(starts, back), 0, was["progress"]),
    }
    return after, back, extreme


def _update_progress(after: Parts, counts: Expression, least: Expression) -> tuple[Parts, Expression]:
    """The track with its progress, and the share of an independent sample; least [rad] as above."""
    travel = ca.fabs(after["extreme"] - after["origin"])
    counted = ca.fmax(after["progress"], ca.fmax(least, MIN_TRAVEL_DIVISOR))
    share = ca.fmin(1, ca.log(ca.fmax(travel / counted, 1)) / FRACTION)
    progress = ca.if_else(counts, travel, after["progress"])
    return {**after, "progress": progress}, ca.fmax(MIN_SAMPLE_WEIGHT, share)


@cache
def build_all_branches_update() -> ca.Function:
    """All branches after a sample: their turns add up.

    points and turns (POINTS, PATHS) have a column for each path; turns [rad] are those of the branches,
    oldest first, whose torques add up; the first one is virgin. torque is the measured one and size its
    size less its noise [N m]; share and the rest are as for `build_present_branch_update`.
    """
    inputs = symbols(
        ca.SX, track=len(TRACK), points=(POINTS, PATHS), psi=1, torque=1, size=1, slack=1, counts=1
    )
    track, points, psi, torque, size, slack, counts = inputs.values()
    was = named(TRACK, track)
    turned, back, farthest = _branch_after_sample(was, psi, slack)
    after = dict(turned)
    rested, starts = was["direction"] == 0, was["direction"] != after["direction"]
    after["rest"] += ca.if_else(ca.logic_and(rested, counts), torque, 0)
    # The torque of the ground points against the turn.
    side = ca.if_else(after["rest"] > 0, -1, 1)
    free, slid = ca.horzsplit(points)
    slid = ca.vertcat(ca.if_else(rested, was["origin"] - side * SLID, slid[0]), slid[1:])
    returns = ca.logic_or(back, ca.logic_and(rested, starts * after["direction"] * side < 0))
    free, after["count"] = _update_turning_points(
        free, was["count"], psi, after["direction"], back, farthest
    )
    again = (after["direction"], returns, farthest)
    slid, after["count_slid"] = _update_turning_points(slid, was["count_slid"], psi, *again)
    counted, share = _update_progress(
        {**after, "origin": _at(free, after["count"] - 1)}, counts, START * slack
    )
    after, older = dict(counted), forgetting_factor(share, FORGETTING_SAMPLES)
    travel = ca.fabs(after["extreme"] - after["origin"])
    after |= {
        "reach": ca.fmax(ca.if_else(counts, older, 1) * was["reach"], size),
        # The widest turn of a branch, that of a virgin one.
        "widest": ca.fmax(after["widest"], travel / ca.if_else(after["count"] == 1, 1, 2)),
        "explained": ca.if_else(counts, older * was["explained"] + ERRORS * share, was["explained"]),
    }
    outputs = {
        "track_next": vector_of(TRACK, after),
        "points_next": ca.horzcat(free, slid),
        "turns": ca.horzcat(
            _branch_turns(free, after["count"], psi), _branch_turns(slid, after["count_slid"], psi)
        ),
        "share": share,
    }
    return named_function("track", inputs, outputs, cse=True)


@cache
def build_new_ground_branches() -> ca.Function:
    """The branches on a ground that has changed: (track, M_z, slide, tyre) -> (track, points).

    M_z is the torque [N m], 0 where it is not known; slide that of full slide on the old ground [N m];
    tyre is k, a and e. Friction that has fallen acts as if it had been so since the last turn back:
    there the patch was anything between free of torque and sliding to the other side, as the wheel may
    have turned too little, or the ground was another. Where the torque is `RISEN` times the old slide,
    friction has risen, and holds what slid: the patch begins anew where the torque left that of the old
    ground, anything between free of torque and sliding to this side.
    """
    inputs = symbols(ca.SX, track=len(TRACK), M_z=1, slide=1, tyre=3)
    track, M_z, slide, tyre = inputs.values()
    was, (k, a, e) = named(TRACK, track), ca.vertsplit(tyre)
    direction, travel = was["direction"], was["extreme"] - was["origin"]
    # The torque of the ground points against the turn.
    rises = -direction * M_z > RISEN * slide
    since = (-direction * M_z - slide) / (k * unit_corner_moment(0, a, e))
    origin = was["extreme"] - direction * ca.fmin(since, ca.fabs(travel))
    origin = ca.if_else(rises, origin, was["origin"])
    slid = origin + ca.if_else(rises, -1, 1) * direction * SLID
    count = ca.if_else(ca.logic_or(rises, direction == 0), 1, 2)
    progress = ca.if_else(rises, 0, was["progress"])
    after = was | {"origin": origin, "progress": progress, "count": 1, "count_slid": count}
    after |= {"explained": 0, "widest": 0}
    slid = ca.vertcat(slid, ca.repmat(origin, POINTS - 1))
    points = ca.horzcat(ca.repmat(origin, POINTS), slid)
    outputs = {"track_next": vector_of(TRACK, after), "points_next": points}
    return named_function("new_ground", inputs, outputs, cse=True)


def _update_turning_points(
    points: Expression, count: Expression, psi: Expression, direction: Expression, back: Expression,
    farthest: Expression,
) -> tuple[Expression, Expression]:  # fmt: skip
    """Turning points of a path and their number after a sample."""
    # Where all places are taken, the outermost loop is dropped.
    full = ca.logic_and(back, count == POINTS)
    shifted = ca.vertcat(points[0], points[3:], points[-2:])
    points, count = ca.if_else(full, shifted, points), ca.if_else(full, count - 2, count)
    points = ca.vertcat(
        *(ca.if_else(ca.logic_and(back, count == i), farthest, points[i]) for i in range(POINTS))
    )
    count = count + back
    for _ in range(POINTS // 2):
        closing = ca.if_else(count == 2, 2 * points[0] - points[1], _at(points, count - 2))
        closed = ca.logic_and(count >= 2, (psi - closing) * direction > 0)
        count = ca.if_else(closed, ca.fmax(count - 2, 1), count)
    return points, count


def _branch_turns(points: Expression, count: Expression, psi: Expression) -> Expression:
    """Turn of each branch [rad]."""
    turns = [
        ca.if_else(count > i + 1, points[min(i + 1, POINTS - 1)] - points[i], 0)
        + ca.if_else(count == i + 1, psi - points[i], 0)
        for i in range(POINTS)
    ]
    return ca.vertcat(*turns)


def _at(vector: Expression, index: Expression) -> Expression:
    """The element of a vector at an index that is an expression."""
    return sum(ca.if_else(index == i, vector[i], 0) for i in range(vector.shape[0]))


def loads_of_branches(track: Parts, loads: Expression) -> Expression:
    """Load that each branch of both paths carries (POINTS, PATHS) [N]; loads (2,) are now and at rest.

    Where the wheel turns back it is at rest: a branch that is over ended there, and the present one, if
    it is no virgin one, goes from the limit there to the opposite one of now.
    """
    now, rest = loads[0], loads[1]
    present = (now, *(POINTS - 1) * [(now + rest) / 2])
    paths = [
        ca.vertcat(*(ca.if_else(track[count] > i + 1, rest, load) for i, load in enumerate(present)))
        for count in ("count", "count_slid")
    ]
    return ca.horzcat(*paths)


@cache
def build_branch_torque() -> ca.Function:
    """Torque of one branch [N m]: (turn, order, ratio, F_N, tyre) -> M; order 0 is the virgin branch.

    ratio is mu at the declared k; tyre is k, a and e.
    """
    inputs = symbols(ca.SX, turn=1, order=1, ratio=1, F_N=1, tyre=3)
    turn, order, ratio, F_N, tyre = inputs.values()
    scale = ca.if_else(order == 0, 1, 2)
    M = scale * virgin_torque(turn / scale, F_N, ratio, *ca.vertsplit(tyre))
    return named_function("branch", inputs, {"M": M}, cse=True)


def relative_mu_sensitivity(
    turn: Expression, mu: Expression, F_N: Expression, tyre: Expression
) -> Expression:
    """Relative change of a virgin turn's torque by that of mu: 0 in full stick, 1 in full slide."""
    moment, by_mu = _virgin_torque_and_slope(turn, mu, F_N, tyre)
    return ca.fmin(ca.fmax(by_mu / moment, MIN_SENSITIVITY), 1)


def torque_slope_by_log_k(
    turn: Expression, mu: Expression, F_N: Expression, tyre: Expression
) -> Expression:
    """Derivative by ln k of a branch's torque [N m], whose turn is twice that of a virgin one [rad].

    As the torque is homogeneous in (mu, k), it is what mu leaves.
    """
    moment, by_mu = _virgin_torque_and_slope(turn, mu, F_N, tyre)
    return 2 * tyre[0] * turn * (moment - by_mu)


def _virgin_torque_and_slope(
    turn: Expression, mu: Expression, F_N: Expression, tyre: Expression
) -> tuple[Expression, Expression]:
    """Torque of a virgin turn over k and turn [m^3], and its derivative by ln mu."""
    k, a, e = named(("k", "a", "e"), tyre).values()
    slope = full_slide_level(F_N, a) * mu / k
    z = ca.fmin(slope / ca.fmax(turn, MIN_TRAVEL_DIVISOR), FAR)
    # As z is proportional to mu.
    beyond, by_z = ca.vertsplit(corner_moment_and_derivative(z, a, e))
    return unit_corner_moment(0, a, e) - beyond, -z * by_z


def sliding_onset_turn(mu: Expression, F_N: Expression, tyre: Expression) -> Expression:
    """Turn at which the patch begins to slide at its ends [rad], e = 0; tyre is k, a and e."""
    k, a, _ = named(("k", "a", "e"), tyre).values()
    return 3 * F_N * mu / (4 * a**2 * k)


@cache
def build_sliding_onset_turn() -> ca.Function:
    """`sliding_onset_turn`: (mu, F_N, tyre) -> turn."""
    inputs = symbols(ca.SX, mu=1, F_N=1, tyre=3)
    return named_function("sliding", inputs, {"turn": sliding_onset_turn(*inputs.values())})
