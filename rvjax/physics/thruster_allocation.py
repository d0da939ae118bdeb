"""Allocation: the thrusts that give a wrench, for a single sample and instant. Thrusters only push.

    pseudo-inverse          f = clip(f₀ + B⁺(w − B f₀), 0, f_max),  f₀ = c f_max
    bounded-least-squares   f = arg min |W(B f − w)|² + ε Σ (fᵢ/f_max,ᵢ)²   over 0 ≤ f ≤ f_max

Both use the nominal B and f_max (`thruster_layout`), without spread and faults. Both are scaled to shares of the largest thrust
and weighted by W. W = diag(2/(u⁺ + u⁻)), with the nominal limits of the channels.

The pseudo-inverse is linear only while nothing is clipped; all thrusters then burn around their centre f₀. The bounded problem
uses the whole attainable set: inside it the relative error of the wrench is about ε, outside it the weighted error is least.
ε > 0 makes the thrusts unique.

It is solved in shares x = f/f_max, A = W B diag(f_max), b = W w, by a fixed number of iterations:

  1.  STEPS steps of the primal-dual interior-point method (predictor and corrector of S. Mehrotra, SIAM J. Optimization, 1992).
      The normal equations are 6×6 by Woodbury's identity, I + A D⁻¹ Aᵀ with D = ε + z/x + v/(1−x).
  2.  POLISH steps of Newton's method on the piecewise linear equation of the residual, y = b − A clip(Aᵀy/ε, 0, 1). The first
      steps find the thrusters at a bound; once these are right, a step is exact to rounding.

Within a step of the integration the solution at its start is updated to first order, f = clip(f_k + (∂f/∂w)(w − w_k)):
thrusters between their bounds move, the others stay. This is exact while the same thrusters are at a bound, and its error never
exceeds that of a held command. It takes a fifteenth of the time.

Compared with SciPy's bounded least squares in `tests/physics/test_thrusters.py`: to rounding in double precision. In single
precision rounding is amplified by 1/ε: shares are right to 1e-3, the wrench to 2e-4 of its limits.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from rvjax.campaign.thruster_layout import Layout, limits
from rvjax.elementary import pseudo_inverse as rational
from rvjax.physics.vectors import Channels, Scalar, Thrusts, each, largest, total

EPSILON = 1e-4
"""Weight ε of the shares of the largest thrust, relative to the wrench in parts of its limits."""

STEPS = 14
POLISH = 3
SHORTEN = 0.995
"""Longest interior-point step, as a share of the way to the nearest bound."""

BEGIN = 0.3
"""Multipliers at the start; x starts at ½."""


class Allocation(NamedTuple):
    """solve(w) → solved, the solution for this wrench, () without memory. follow(w, solved) → shares of the largest thrusts,
    0 to 1, for this wrench or another near it. idle(w) → solved before the first step.

    w: commanded wrench [N, N·m].
    """

    solve: Callable[[Channels], Any]
    follow: Callable[[Channels, Any], Thrusts]
    idle: Callable[[Channels], Any]

    def at(self, w: Channels) -> Thrusts:
        """The shares for a wrench."""
        return self.follow(w, self.solve(w))


class ThrusterSystem(NamedTuple):
    """Structure of thrusters. wrench(f) → B f [N, N·m]."""

    allocation: Allocation
    wrench: Callable[[Thrusts], Channels]


Triangle = list[list[Scalar]]
"""The rows of a lower triangular matrix, or of the lower half of a symmetric matrix."""


class Matrix(NamedTuple):
    """6×N, column by column without its zeros: (row, entry)."""

    columns: tuple[tuple[tuple[int, float], ...], ...]

    @classmethod
    def of(cls, dense: np.ndarray) -> Matrix:
        return cls(tuple(tuple((row, float(a)) for row, a in enumerate(column) if a) for column in dense.T))

    def times(self, x: Thrusts) -> Channels:
        """A x."""
        rows: list[Scalar] = [0.0] * 6
        for column, share in zip(self.columns, x.parts(), strict=True):
            for row, a in column:
                rows[row] = rows[row] + a * share
        return Channels.of(tuple(rows))

    def across(self, y: Channels) -> Thrusts:
        """Aᵀ y."""
        rows = y.parts()
        return Thrusts(tuple(sum(a * rows[row] for row, a in column) for column in self.columns))

    def gram(self, weight: Thrusts) -> Triangle:
        """I + A diag(weight) Aᵀ."""
        entries: Triangle = [[float(i == k) for k in range(i + 1)] for i in range(6)]
        for column, w in zip(self.columns, weight.parts(), strict=True):
            for i, a in column:
                for k, b in column:
                    if k <= i:
                        entries[i][k] = entries[i][k] + (a * b) * w
        return entries


def wrench(layout: Layout) -> Callable[[Thrusts], Channels]:
    """f → B f [N, N·m]."""
    return Matrix.of(layout.matrix).times


def pseudo_inverse(layout: Layout, centre: float = 0.5) -> Allocation:
    """f = clip(f₀ + B⁺(w − B f₀), 0, f_max),  f₀ = c f_max, as shares of f_max; centre: c."""
    weight, most = _weight(layout), np.array(layout.most)
    scaled = weight[:, None] * layout.matrix * most
    inverse = rational.pseudo_inverse(scaled) * weight
    full = [math.fsum(row) for row in layout.matrix * most]
    offset = [centre - math.fsum(row) * centre for row in inverse * full]
    rows = Matrix.of(inverse.T)

    def follow(w: Channels, solved: tuple[()]) -> Thrusts:
        del solved
        shares = rows.across(w)
        return Thrusts(tuple(jnp.clip(o + x, 0.0, 1.0) for o, x in zip(offset, shares.parts(), strict=True)))

    return Allocation(lambda w: (), follow, lambda w: ())


class Solved(NamedTuple):
    """Shares x of the largest thrusts that solve the problem of the wrench w [N, N·m]."""

    x: Thrusts
    w: Channels


def bounded_least_squares(layout: Layout, steps: int = STEPS, polish: int = POLISH) -> Allocation:
    """f = arg min |W(B f − w)|² + ε Σ (fᵢ/f_max,ᵢ)² over 0 ≤ f ≤ f_max, as shares of f_max."""
    weight = _weight(layout)
    a = Matrix.of(weight[:, None] * layout.matrix * np.array(layout.most))
    scale = Channels.of(tuple(map(float, weight)))

    def solve(w: Channels) -> Solved:
        b = scale * w
        ones = a.across(b) * 0.0 + 1.0
        inside = jax.lax.fori_loop(0, steps, lambda _, p: interior(a, b, p), Point(ones * 0.5, ones * BEGIN, ones * BEGIN))
        y = jax.lax.fori_loop(0, polish, lambda _, y: newton(a, b, y), b - a.times(inside.x))
        return Solved(each(lambda s: jnp.clip(s, 0.0, 1.0), a.across(y) / EPSILON), w)

    def follow(w: Channels, solved: Solved) -> Thrusts:
        free = movable(solved.x, rounding(*solved.x.parts()) / EPSILON)
        moved = a.across(back(cholesky(a.gram(free)), scale * (w - solved.w)))
        return each(lambda x, dx: jnp.clip(x + dx, 0.0, 1.0), solved.x, free * moved)

    return Allocation(solve, follow, lambda w: Solved(a.across(w) * 0.0, w))


class Point(NamedTuple):
    """Shares x of the largest thrusts; multipliers z of x ≥ 0 and v of x ≤ 1."""

    x: Thrusts
    z: Thrusts
    v: Thrusts


def interior(a: Matrix, b: Channels, p: Point) -> Point:
    """A step towards  Aᵀ(A x − b) + ε x − z + v = 0,  x z = 0,  (1 − x) v = 0,  from inside the bounds."""
    x, z, v = p
    s = each(lambda share: 1.0 - share, x)
    below, above = each(lambda share: 1.0 / share, x), each(lambda rest: 1.0 / rest, s)
    steep, flat = z * below, v * above
    soft = each(lambda p, q: 1.0 / (EPSILON + p + q), steep, flat)
    factor = cholesky(a.gram(soft))
    gap = total(x * z + s * v)
    force = -(a.across(a.times(x) - b) + x * EPSILON)

    def towards(lift: Thrusts, drop: Thrusts) -> tuple[Point, Scalar]:
        """The direction to x z = lift x, (1 − x) v = drop (1 − x), and the inverse of the longest step inside the bounds."""
        q = (force + lift - drop) * soft
        dx = q - a.across(back(factor, a.times(q))) * soft
        dz, dv = lift - z - steep * dx, drop - v + flat * dx

        def nearest(dx: Scalar, dz: Scalar, dv: Scalar, low: Scalar, up: Scalar, z: Scalar, v: Scalar) -> Scalar:
            return jnp.maximum(jnp.maximum(-dx * low, dx * up), jnp.maximum(-dz / z, -dv / v))

        return Point(dx, dz, dv), largest(each(nearest, dx, dz, dv, below, above, z, v))

    zero = x * 0.0
    d, inverse = towards(zero, zero)
    t = jnp.minimum(1.0, 1.0 / inverse)
    left = total((x + d.x * t) * (z + d.z * t) + (s - d.x * t) * (v + d.v * t))
    share = left / gap
    target = share * share * left / (2 * len(x.parts()))
    d, inverse = towards((target + -(d.x * d.z)) * below, (target + d.x * d.v) * above)
    t = jnp.minimum(1.0, SHORTEN / inverse)

    least = rounding(t)
    shares = each(lambda x, dx: jnp.clip(x + t * dx, least, 1.0 - least), x, d.x)
    z, v = (each(lambda z, dz: jnp.maximum(z + t * dz, least), now, way) for now, way in ((z, d.z), (v, d.v)))
    return Point(shares, z, v)


def newton(a: Matrix, b: Channels, y: Channels) -> Channels:
    """A Newton step towards  y = b − A clip(Aᵀy/ε, 0, 1)."""
    shares = a.across(y) / EPSILON
    wrong = y - b + a.times(each(lambda s: jnp.clip(s, 0.0, 1.0), shares))
    return y - back(cholesky(a.gram(movable(shares))), wrong)


def rounding(*x: Scalar) -> float:
    """8 eps of the type of x: what rounding may move a number near 1 by."""
    return 8.0 * float(jnp.finfo(jnp.result_type(*x)).eps)


def movable(shares: Thrusts, margin: float = 0.0) -> Thrusts:
    """1/ε if a thruster is farther than the margin from both bounds, else 0.

    A solution is known to rounding/ε. Nearer to a bound a thruster counts as at the bound, so that rounding does not decide which
    thrusters move where none is pressed against its bound, as for a wrench of zero.
    """
    return each(lambda s: jnp.where((s > margin) & (s < 1.0 - margin), 1.0 / EPSILON, 0.0), shares)


def cholesky(m: Triangle) -> Triangle:
    """L with L Lᵀ = M positive definite; on its diagonal 1/Lᵢᵢ."""
    rows: Triangle = [[0.0] * (i + 1) for i in range(len(m))]
    for k in range(len(m)):
        rows[k][k] = 1.0 / jnp.sqrt(m[k][k] - sum(rows[k][j] * rows[k][j] for j in range(k)))
        for i in range(k + 1, len(m)):
            rows[i][k] = (m[i][k] - sum(rows[i][j] * rows[k][j] for j in range(k))) * rows[k][k]
    return rows


def back(factor: Triangle, r: Channels) -> Channels:
    """M⁻¹ r, from the factor of `cholesky`."""
    y, count = list(r.parts()), len(factor)
    for i in range(count):
        y[i] = (y[i] - sum(factor[i][j] * y[j] for j in range(i))) * factor[i][i]
    for i in reversed(range(count)):
        y[i] = (y[i] - sum(factor[j][i] * y[j] for j in range(i + 1, count))) * factor[i][i]
    return Channels.of(tuple(y))


def _weight(layout: Layout) -> np.ndarray:
    """(6,) 2/(u⁺ + u⁻)."""
    upper, lower = limits(layout)
    return 2.0 / (np.array(upper) + np.array(lower))
