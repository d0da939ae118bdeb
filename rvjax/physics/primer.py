"""Primer vector: a lower bound on the Δv of a transfer in the linearised relative motion about a Kepler orbit.

    Δ̈ = G(t)Δ + a,   G = μ/|r|³ (3 r̂r̂ᵀ − I),   from (Δ₀, Δ̇₀) at t = 0 to (Δ₁, Δ̇₁) at t = T
    p̈ = G(t) p   ⇒   ∫ pᵀa dt = [pᵀΔ̇ − ṗᵀΔ]₀ᵀ = cᵀb   ⇒   ∫ |a| dt ≥ cᵀb / max |p(t)|

p: any solution, p(t) = P(t) c with six numbers c. So every c gives a bound, whatever thrust the transfer has; the largest of them
is the smallest Δv itself (D. Lawden, "Optimal trajectories for space navigation", 1963; L. Neustadt, "Optimization, a moment
problem, and nonlinear programming", SIAM J. Control, 1964). c is improved by Newton steps for Σ |P(tᵢ) c|^q with cᵀb = 1, q = 2,
4, 4, 8, 8, …: for large q the largest |p| of the grid alone counts. The best bound on the way is the result.

Between two points of the grid |p| stays below M/(1 − μh²/(4 r_p³)), with M the largest |p| of the grid, h its spacing and r_p the
perigee: a curve leaves its chord by at most h²/8 sup |p̈|, and |p̈| ≤ 2μ/r³ |p|. The orbit and P are integrated by RK4 on the
grid, in units of the first distance and of T.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from rvjax.physics.constants import MU_EARTH
from rvjax.physics.free_motion import FreeMotion, rk4
from rvjax.physics.thruster_allocation import back, cholesky
from rvjax.physics.vectors import Channels, Scalar, Vector, cross, dot, norm

NODES = 128
"""Steps of the grid."""
DOUBLINGS = 8
"""q goes up to 2 · 2⁸ = 512."""
ROUNDS = 2
"""Newton steps for each q."""
MOST = 1.25
"""Largest |p|² in w, with which |p|^510 stays within the numbers of float32; the last largest |p| was scaled to 1."""


class Basis(NamedTuple):
    """Place and velocity (x, y) in the plane of the orbit, and the solutions P with their rates: rows x, y of four numbers, row z
    of two."""

    place: Any
    velocity: Any
    x: Any
    y: Any
    z: Any
    x_rate: Any
    y_rate: Any
    z_rate: Any


class Sums(NamedTuple):
    """Over the points of the grid: largest |p|²; gradient Σ w Pᵀp; in plane and out of it Σ w PᵀP; Σ (q−2) w/|p|² (Pᵀp)(Pᵀp)ᵀ."""

    largest: Scalar
    gradient: Any
    plane: Any
    normal: Any
    along: Any


def lower_bound(begin: FreeMotion, end: FreeMotion, time: Scalar) -> Scalar:
    """The bound [m/s]. begin, end: each in axes of its own; the target has moved freely from one to the other in the time [s]."""
    stiffness = MU_EARTH * time * time / (norm(begin.r) * dot(begin.r, begin.r))
    first = _first(begin, time)
    last = jax.lax.fori_loop(0, NODES, lambda _, basis: _moved(basis, stiffness), first)
    b = _moment(last, end, time) - _moment(first, begin, time)

    def stepped(k: Any, now: tuple[Any, Scalar]) -> tuple[Any, Scalar]:
        c, best = now
        sums = _summed(first, stiffness, c, (k + ROUNDS - 1) // ROUNDS)
        largest = jnp.sqrt(sums.largest)
        bound = jnp.dot(c, b) / largest
        return (c + _newton(b, sums)) / largest, jnp.where(bound > best, bound, best)

    c, best = jax.lax.fori_loop(0, 1 + ROUNDS * DOUBLINGS, stepped, (b / jnp.sqrt(jnp.dot(b, b)), jnp.zeros_like(time)))
    bound = jnp.dot(c, b) / jnp.sqrt(_summed(first, stiffness, c, 0).largest)
    return jnp.where(bound > best, bound, best) * _allowance(begin, time)


def _first(begin: FreeMotion, time: Scalar) -> Basis:
    """t = 0, with the target on the axis x: the components of p and of its rate are the numbers c."""
    distance = norm(begin.r)
    speed = jnp.stack([dot(begin.r, begin.v), norm(cross(begin.r, begin.v))]) * (time / (distance * distance))
    place = jnp.array([1.0, 0.0], speed.dtype)
    (x, y, x_rate, y_rate), (z, z_rate) = (jnp.eye(size, dtype=speed.dtype) for size in (4, 2))
    return Basis(place, speed, x, y, z, x_rate, y_rate, z_rate)


def _moved(basis: Basis, stiffness: Scalar) -> Basis:
    """The next point of the grid."""

    def rate(now: Basis) -> Basis:
        square = jnp.dot(now.place, now.place)
        pull = stiffness / (square * jnp.sqrt(square))
        across = (now.place[0] * now.x + now.place[1] * now.y) * (3.0 * pull / square)
        return Basis(
            now.velocity,
            -pull * now.place,
            now.x_rate,
            now.y_rate,
            now.z_rate,
            across * now.place[0] - pull * now.x,
            across * now.place[1] - pull * now.y,
            -pull * now.z,
        )

    return rk4(rate, basis, 1.0 / NODES)


def _moment(basis: Basis, motion: FreeMotion, time: Scalar) -> Any:
    """(6,) PᵀΔ̇ − ṖᵀΔ [m/s]."""
    delta, speed = (_in_plane(vector, motion, basis.place) for vector in (motion.delta, motion.speed))
    rows, rates = (basis.x, basis.y, basis.z), (basis.x_rate, basis.y_rate, basis.z_rate)
    x, y, z = (p * v - (rate / time) * d for p, rate, d, v in zip(rows, rates, delta, speed, strict=True))
    return jnp.concatenate([x + y, z])


def _in_plane(vector: Vector, motion: FreeMotion, place: Any) -> tuple[Scalar, Scalar, Scalar]:
    """A vector in the axes in which the target is at this place (x, y)."""
    up, normal = motion.r / norm(motion.r), cross(motion.r, motion.v)
    normal = normal / norm(normal)
    out, along = dot(up, vector), dot(cross(normal, up), vector)
    unit = place / jnp.sqrt(jnp.dot(place, place))
    return out * unit[0] - along * unit[1], out * unit[1] + along * unit[0], dot(normal, vector)


def _summed(first: Basis, stiffness: Scalar, c: Any, doublings: Any) -> Sums:
    """The sums for q = 2^(1 + doublings), w = |p|^(q−2)."""

    def added(_: Any, now: tuple[Basis, Sums]) -> tuple[Basis, Sums]:
        basis, sums = now
        return _moved(basis, stiffness), _with_point(sums, basis, c, doublings)

    empty = Sums(*(jnp.zeros(shape, c.dtype) for shape in ((), (6,), (4, 4), (2, 2), (6, 6))))
    last, sums = jax.lax.fori_loop(0, NODES, added, (first, empty))
    return _with_point(sums, last, c, doublings)


def _with_point(sums: Sums, basis: Basis, c: Any, doublings: Any) -> Sums:
    """The sums with another point of the grid."""
    x, y, z = jnp.dot(basis.x, c[:4]), jnp.dot(basis.y, c[:4]), jnp.dot(basis.z, c[4:])
    square = x * x + y * y + z * z
    limited = jnp.minimum(square, MOST)
    w = half = jnp.ones_like(square)
    for j in range(DOUBLINGS):
        w, half = jnp.where(j < doublings, w * w * limited, w), jnp.where(j < doublings, 2.0 * half, half)
    gradient = jnp.concatenate([basis.x * x + basis.y * y, basis.z * z])
    along = (2.0 * half - 2.0) * w / jnp.maximum(square, jnp.finfo(c.dtype).tiny)
    return Sums(
        jnp.maximum(sums.largest, square),
        sums.gradient + w * gradient,
        sums.plane + w * (jnp.outer(basis.x, basis.x) + jnp.outer(basis.y, basis.y)),
        sums.normal + w * jnp.outer(basis.z, basis.z),
        sums.along + along * jnp.outer(gradient, gradient),
    )


def _newton(b: Any, sums: Sums) -> Any:
    """(6,) the Newton step of Σ |p|^q that leaves cᵀb as it is: −H⁻¹(g − λb), bᵀ of it 0."""
    blocks = {(i, k): sums.plane[i, k] for i in range(4) for k in range(4)}
    blocks |= {(4 + i, 4 + k): sums.normal[i, k] for i in range(2) for k in range(2)}
    rows = [[sums.along[i, k] + blocks.get((i, k), 0.0) for k in range(i + 1)] for i in range(6)]
    ridge = sum(rows[i][i] for i in range(6)) * (4.0 * float(jnp.finfo(b.dtype).eps))
    for i in range(6):
        rows[i][i] = rows[i][i] + ridge
    factor = cholesky(rows)
    downhill, against = (jnp.stack(back(factor, Channels.of(tuple(v))).parts()) for v in (sums.gradient, b))
    return against * (jnp.dot(b, downhill) / jnp.dot(b, against)) - downhill


def _allowance(begin: FreeMotion, time: Scalar) -> Scalar:
    """1 − μh²/(4 r_p³), at least 0."""
    moment = cross(begin.r, begin.v)
    parameter = dot(moment, moment) / MU_EARTH
    energy = 2.0 / norm(begin.r) - dot(begin.v, begin.v) / MU_EARTH
    perigee = parameter / (1.0 + jnp.sqrt(jnp.maximum(1.0 - parameter * energy, 0.0)))
    spacing = time / NODES
    return jnp.maximum(1.0 - MU_EARTH * spacing * spacing / (4.0 * perigee * perigee * perigee), 0.0)
