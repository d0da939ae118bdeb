"""Distance between two rigid hulls, and a bound on it between two instants.

A hull is a ball, or a box along the axes of its frame: { c + x : |x| ≤ r }  or  { c + x : |xᵢ| ≤ hᵢ }.

    s(n) = nᵀd − Σ hᵢ|nᵢ| − Σ h'ᵢ|(Rn)ᵢ| − r − r'           separation along a vector n that is fixed in T, |n| ≤ 1

d: from the target's centre to the pursuer's, in T; R: T → P; primes: the pursuer. For every n the distance is at least s(n), so
an n with s(n) > 0 separates the hulls. Of two boxes, a face normal or a cross product of two edges does, unless they touch.

Between two instants, a time h apart, every point of the pursuer stays within A h²/8 of the straight line between its two places,
if its acceleration in T is A at most. While the points move on these lines the separation along n is at least the smaller of its
values at both ends:

    distance ≥ max over n of min(s₀(n), s₁(n)) − A h²/8

The n that are tried: face normals, cross products of edges, the direction between the centres where they are nearest on the line,
and the direction between the two points that alternating projections onto the hulls find.

C. Ericson, "Real-time collision detection", 2005, §4.4 (separating axes); W. Cheney, A. Goldstein, "Proximity maps for convex
sets", 1959 (alternating projections).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import jax.numpy as jnp

from rvjax.physics.vectors import Rotation, Scalar, Vector, cross, dot, each, rotate, rotate_back, total

ROUNDS = 4
"""Alternating projections between two boxes. They tend to the nearest points; any direction gives a lower bound."""

TINY = 1e-30
"""Added to squared lengths, so that their roots have a finite derivative at 0."""

AXES = (Vector(1.0, 0.0, 0.0), Vector(0.0, 1.0, 0.0), Vector(0.0, 0.0, 1.0))


class Hull(NamedTuple):
    """centre: in its frame, of the pursuer from its centre of mass [m]. radius [m], 0 for a box. half: half the edges of a box
    [m], empty for a ball."""

    centre: Vector
    radius: Scalar
    half: Vector | tuple[()] = ()

    @property
    def reach(self) -> Scalar:
        """Largest distance of a point of the hull from the origin of its frame, at most [m]."""
        return length(self.centre) + self.radius + (length(self.half) if isinstance(self.half, Vector) else 0.0)

    def nearest(self, point: Vector) -> Vector:
        """The point of the box that is nearest to a point, both from its centre; of a ball its centre."""
        return each(lambda x, h: jnp.clip(x, -h, h), point, self.half) if isinstance(self.half, Vector) else point * 0.0


class Pose(NamedTuple):
    """The pursuer relative to the target. place: centre of its hull from that of the target's, in T [m]; r: T → P."""

    place: Vector
    r: Rotation


def pose(target: Hull, pursuer: Hull, mass_centre: Vector, r: Rotation) -> Pose:
    """mass_centre: of the pursuer, from that of the target, in T [m]."""
    return Pose(mass_centre + rotate_back(r, pursuer.centre) - target.centre, r)


def least_distance(target: Hull, pursuer: Hull, before: Pose, now: Pose) -> Scalar:
    """max over n of min(s₀(n), s₁(n)): a lower bound of the distance on the straight way between two poses [m].

    Exact for two balls, and at rest for a ball outside of a box. Not positive: the bound does not exclude a contact.
    """
    best, balls = None, not (isinstance(target.half, Vector) or isinstance(pursuer.half, Vector))
    for normal in _normals(target, pursuer, before, now):
        kept = jnp.minimum(_separation(normal, target, pursuer, before), _separation(normal, target, pursuer, now))
        kept = kept if balls else jnp.where(dot(normal, normal) > 0.5, kept, -jnp.inf)  # with n = 0 a depth would be 0
        best = kept if best is None else jnp.maximum(best, kept)
    return best


def _separation(normal: Vector, target: Hull, pursuer: Hull, at: Pose) -> Scalar:
    """s(n)."""
    size = target.radius + pursuer.radius
    for hull, seen in ((target, lambda: normal), (pursuer, lambda: rotate(at.r, normal))):
        if isinstance(hull.half, Vector):
            size = size + total(each(lambda n, h: jnp.abs(n) * h, seen(), hull.half))
    return dot(normal, at.place) - size


def _normals(target: Hull, pursuer: Hull, before: Pose, now: Pose) -> Iterator[Vector]:
    """Vectors in T along which the hulls may be separated, each toward the pursuer."""
    yield _unit(_nearest_on_line(before.place, now.place))
    turned = (now.r.a, now.r.b, now.r.c)
    faces = [(hull.half, axes) for hull, axes in ((target, AXES), (pursuer, turned)) if isinstance(hull.half, Vector)]
    if faces:
        yield _unit(_gap(target, pursuer, now, ROUNDS if len(faces) == 2 else 1))
    for _, axes in faces:
        yield from (_toward(axis, now.place) for axis in axes)
    if len(faces) == 2:
        yield from (_toward(_unit(cross(a, b)), now.place) for a in AXES for b in turned)


def _gap(target: Hull, pursuer: Hull, at: Pose, rounds: int) -> Vector:
    """From a point of the target's box to a point of the pursuer's, each the nearest of its box to the other. In T [m]."""
    theirs = at.place
    for _ in range(rounds):
        ours = target.nearest(theirs)
        theirs = at.place + rotate_back(at.r, pursuer.nearest(rotate(at.r, ours - at.place)))
    return theirs - ours  # pyright: ignore[reportPossiblyUnboundVariable]


def _nearest_on_line(a: Vector, b: Vector) -> Vector:
    """The point of the straight line from a to b that is nearest to the origin."""
    way = b - a
    square = dot(way, way)
    share = jnp.clip(-dot(a, way) / jnp.where(square > 0.0, square, 1.0), 0.0, 1.0)
    return a + way * share


def length(a: Vector) -> Scalar:
    """√(|a|² + tiny)."""
    return jnp.sqrt(dot(a, a) + TINY)


def _unit(a: Vector) -> Vector:
    """a/√(|a|² + tiny), which is never longer than 1."""
    return a * (1.0 / length(a))


def _toward(a: Vector, place: Vector) -> Vector:
    """a or −a, whichever points toward the place."""
    return a * jnp.where(dot(a, place) >= 0.0, 1.0, -1.0)
