"""The declared patch in C by hand, small and quick: `templates/patch.c` and what it is filled with.

casadi moves whole vectors: every corner that the patch could have is sorted and weighed in every step,
and most of the time there are three. The moment of a corner and its derivative are still casadi's.
"""

import casadi as ca

from observers.base import ModelObserver
from observers.embedded.scalar_type import Real
from symbolic import full_slide_level
from symbolic.deformation import edge_distance, edge_moment, unit_moment

DEPTH = 16
"""Corners of the patch, 33 zones; where a path nests deeper, the one that is felt least is given up."""
TYPES = """\
/* The contact patch, see the code. */
typedef struct {{
    {real} xi[{depth}], r[{depth}], d[{depth}], angle, rest;
    int32_t corners, moved;
    int8_t clipped[{depth}];
}} {name}_patch_t;

"""


def is_declared(observer: ModelObserver) -> bool:
    """True for the declared model, whose patch this is."""
    return observer.model.exact and not observer.model.effects


def patch_numbers(observer: ModelObserver) -> dict[str, str]:
    """The rig and the tyre as C has them."""
    a, e = observer.rig.a, observer.rig.e
    return {
        "a": repr(float(a)),
        "k": repr(float(observer.values["k"])),
        "level": repr(float(full_slide_level(1.0, a))),
        "still_moment": repr(float(unit_moment(0.0, a, e))),
        "depth": str(DEPTH),
        "turns": str(int(observer.measurement_model.turns)),
    }


def patch_types(real: Real, name: str) -> str:
    """The type of the patch, C of a header."""
    return TYPES.format(real=real.c_type, depth=DEPTH, name=name)


def patch_bytes(real: Real) -> int:
    """Bytes of a patch."""
    return (3 * DEPTH + 2) * real.size + 8 + DEPTH


def build_corner(observer: ModelObserver) -> ca.Function:
    """(z) -> the moment of a unit change of slope at z, and its derivative by z."""
    a, e = observer.rig.a, observer.rig.e
    z, width = ca.SX.sym("z"), ca.SX.sym("width", 2)
    arms = (a - e, a + e)
    moment = sum(edge_moment(z, w, a, arm) for w, arm in zip(ca.vertsplit(width), arms, strict=True))
    made = ca.vertcat(moment, ca.jacobian(moment, z))
    widths = ca.vertcat(*(edge_distance(z, a, arm) for arm in arms))
    made = ca.substitute(made, width, widths)
    return ca.Function("corner", [z], [made], ["z"], ["made"], {"cse": True})
