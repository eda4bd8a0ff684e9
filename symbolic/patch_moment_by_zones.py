r"""The lateral deformation q(x) and its moment, zone by zone, as CasADi expressions.

Every bristle of the patch is an elastoplastic stop: turning by dpsi moves it by -(x - e) dpsi and
friction limits it to \|q\| <= c (a^2 - x^2), c = 3 F_N mu / (4 a^3 k), [Györök 2022], (2.1), (2.15),
(2.16).
Divide both by the pressure parabola p(x) = a^2 - x^2 and write

    r = q / p,        xi = (x - e) / p.

xi grows monotonically from -inf at the rear edge over 0 at the kingpin A to +inf at the leading edge,
since d xi / dx = ((x - e)^2 + a^2 - e^2) / p^2 > 0 for \|e\| < a. In these coordinates one step reads

    r(xi)  <-  clip(r(xi) - xi dpsi, -c, +c)

for every bristle alike: r is piecewise linear in xi whatever the history, and odd, r(-xi) = -r(xi). So
the whole patch is the polyline on xi >= 0. Its corners are the boundaries between zones: n corners make
2 n + 1 zones in x, and nothing limits n. Between corners q = r p = alpha (a^2 - x^2) - beta (x - e) is
the rotated parabola of [Györök 2022], (3.5).

The moment is linear in r. With r written by its changes of slope, r = sum_j s_j (xi - xi_j)_+, it is

    M_z = k sum_j s_j G(xi_j),     G(z) = int (|xi| - z)_+ p |x - e| dx,

and G is the one integral that `unit_corner_moment` takes, exactly, from the deformation itself.
"""

from functools import cache

import casadi as ca
import numpy as np

from symbolic.float_array_type import Array
from symbolic.patch_interface import Expression


@cache
def unit_gauss_legendre(order: int) -> tuple[Array, Array]:
    """Nodes and weights on [0, 1], shape (order,) each, exact up to degree 2 order - 1."""
    nodes, weights = np.polynomial.legendre.leggauss(order)
    return (nodes + 1.0) / 2.0, weights / 2.0


def edge_to_boundary_distance(z: Expression, a: Expression, arm: Expression) -> Expression:
    """Distance w from a patch edge at which |xi| = z >= 0 [1/m], without cancellation [m].

    Solves z w (2 a - w) = arm - w, the quadratic of the zone boundary ([Györök 2022], appendix), in the
    form whose denominator has no subtraction. arm is the distance of that edge from the kingpin
    [m], a - e in front and a + e behind.
    """
    b = 1 + 2 * a * z
    return 2 * arm / (b + ca.sqrt(b * b - 4 * z * arm))


def unit_corner_moment(z: Expression, a: Expression, e: Expression) -> Expression:
    """G(z) = int (|xi| - z)_+ (a^2 - x^2) |x - e| dx over both ends of the patch [m^3]; z >= 0 [1/m].

    M_z of the virgin patch turned by psi > 0 is -k psi (G(0) - G(c / psi)), [Györök 2022], (2.3)
    with (3.4); G(0) = 2 a (a^2 / 3 + e^2) is the stiffness of the sticking patch over k, (5.7). The
    integrand is a cubic in x, so two Gauss-Legendre nodes integrate it exactly.
    """
    return sum(
        edge_strip_moment(z, edge_to_boundary_distance(z, a, arm), a, arm) for arm in (a - e, a + e)
    )


def edge_strip_moment(z: Expression, width: Expression, a: Expression, arm: Expression) -> Expression:
    """Int (|xi| - z) (a^2 - x^2) |x - e| dx from a patch edge to a width [m] from it [m^3].

    The integrand vanishes at `edge_to_boundary_distance`, so there the derivative by z is that at a
    fixed width.
    """
    nodes, weights = unit_gauss_legendre(2)
    total: Expression = 0
    for node, weight in zip(nodes, weights, strict=True):
        from_edge = node * width
        lever = arm - from_edge
        pressure = from_edge * (2 * a - from_edge)
        total = total + weight * width * (lever - z * pressure) * lever
    return total


def corner_moment_and_derivative(z: ca.SX, a: ca.SX, e: ca.SX) -> ca.SX:
    """`unit_corner_moment` of scalars and its derivative by z, with the integrals multiplied out.

    With w the distance of the edge at which |xi| = z, the derivative is that at a fixed w,
    -int p |x - e| dx, and G = int (x - e)^2 dx + z dG/dz: a third of the operations of the quadrature.
    """
    moment, by_z = ca.SX(0), ca.SX(0)
    for arm in (a - e, a + e):
        w = edge_to_boundary_distance(z, a, arm)
        moment += w * (arm * (arm - w) + w * w * (1 / 3))
        by_z -= w * w * (a * arm + w * (w * 0.25 - (2 * a + arm) * (1 / 3)))
    return ca.vertcat(moment + z * by_z, by_z)


def full_slide_torque(F_N: Expression, a: Expression) -> Expression:
    """3/8 F_N a: size of M_z in full slide for mu = 1, e = 0 [N m]; [Györök 2022], (2.1) in (2.3)."""
    return 0.375 * F_N * a


def full_slide_arm(a: Expression, e: Expression) -> Expression:
    """M_z over F_N in full slide for mu = 1 [m], 3/8 a where e = 0; [Györök 2022], (2.1) in (2.3).

    The integral of `3 / (4 a^3) (a^2 - x^2) |x - e| dx`: friction changes sides at the kingpin, x = e.

    Args:
        a: half-length of the contact patch [m].
        e: caster length [m], `|e| < a`.
    """
    return sum(arm**3 * (4 * a - arm) for arm in (a - e, a + e)) / (16 * a**3)


def full_slide_level(F_N: Expression, a: Expression) -> Expression:
    """3 F_N / (4 a^3): the limit of r times k / mu [N/m^3], [Györök 2022], (2.1)."""
    return 3 * F_N / (4 * a**3)
