"""Vectors, rotations, actuator channels and thrusters of a single sample at a single instant.

Only this module knows how three numbers are laid out; all other modules use its operators and functions. A `Vector` is three
scalars, not an array of length 3: under `vmap` each component becomes a contiguous array over the samples, which suits vector
processors.

Symbols (J. Diebel, "Representing attitude", 2006; H. Schaub, J. Junkins, "Analytical mechanics of space systems", ch. 3):

    a × b        cross(a, b)          aᵀb          dot(a, b)          |a|        norm(a)
    R(σ)         rotation(σ)          R a          rotate(R, a)       Rᵀ a       rotate_back(R, a)
    J a          apply(J, a)          J⁻¹          inverse(J)         ∂(zᵀJa)/∂J symmetric_gradient(z, a)
    G(σ) ω       mrp_rate(σ, ω)       −σ/|σ|²      shadow(σ)             R(a) R(b)   compose(a, b)
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce
from typing import Any, Self, TypeVar, cast

import jax
import jax.numpy as jnp

Scalar = Any
"""A real number: a Python float, or an array of shape () inside the flight."""


class _Elementwise:
    """Arithmetic component by component. A number acts on every component."""

    def parts(self) -> tuple[Scalar, ...]:
        """The components as scalars, in the order of their names."""
        raise TypeError(type(self).__name__)

    def like(self, parts: tuple[Scalar, ...]) -> Self:
        """A value of this kind from its components."""
        return type(self)(*parts)

    def __add__(self, other: Self | Scalar) -> Self:
        return each(operator.add, self, other)

    def __sub__(self, other: Self | Scalar) -> Self:
        return each(operator.sub, self, other)

    def __mul__(self, other: Self | Scalar) -> Self:
        return each(operator.mul, self, other)

    __radd__ = __add__
    __rmul__ = __mul__

    def __truediv__(self, other: Self | Scalar) -> Self:
        return each(operator.truediv, self, other)

    def __neg__(self) -> Self:
        return each(operator.neg, self)


E = TypeVar("E", bound=_Elementwise)


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Vector(_Elementwise):
    """Three components in a frame."""

    x: Scalar
    y: Scalar
    z: Scalar

    def parts(self) -> tuple[Scalar, ...]:
        return (self.x, self.y, self.z)


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Symmetric(_Elementwise):
    """A symmetric 3×3 matrix by its entries; off-diagonal entries with their sign in the matrix."""

    xx: Scalar
    yy: Scalar
    zz: Scalar
    yz: Scalar
    xz: Scalar
    xy: Scalar

    def parts(self) -> tuple[Scalar, ...]:
        return (self.xx, self.yy, self.zz, self.yz, self.xz, self.xy)

    @classmethod
    def of(cls, diagonal: Scalar, off: Scalar) -> Self:
        """A number on the diagonal, another off the diagonal."""
        return cls(diagonal, diagonal, diagonal, off, off, off)


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Channels(_Elementwise):
    """A number for each of the six actuator channels fx, fy, fz, tx, ty, tz."""

    force: Vector
    torque: Vector

    def parts(self) -> tuple[Scalar, ...]:
        return self.force.parts() + self.torque.parts()

    def like(self, parts: tuple[Scalar, ...]) -> Self:
        return self.of(parts)

    @classmethod
    def of(cls, parts: tuple[Scalar, ...]) -> Self:
        """From the six numbers in the order of `CHANNELS`."""
        return cls(Vector(*parts[:3]), Vector(*parts[3:]))

    @classmethod
    def pair(cls, force: Scalar, torque: Scalar) -> Self:
        """A number for the three force channels, another for the three torque channels."""
        return cls(Vector(force, force, force), Vector(torque, torque, torque))


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Thrusts(_Elementwise):
    """A number for each thruster t1, t2, …"""

    values: tuple[Scalar, ...]

    def parts(self) -> tuple[Scalar, ...]:
        return self.values

    def like(self, parts: tuple[Scalar, ...]) -> Self:
        return type(self)(parts)


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Rotation:
    """A direction cosine matrix by its rows."""

    a: Vector
    b: Vector
    c: Vector


def each(f: Callable[..., Scalar], *args: E | Scalar) -> E:
    """f(aᵢ, bᵢ, …) for every component i; plain numbers are used for every component."""
    first, rows = _rows(args)
    return cast(E, first.like(tuple(f(*row) for row in rows)))


def split(f: Callable[..., tuple[Scalar, ...]], *args: E | Scalar) -> tuple[E, ...]:
    """(pᵢ, qᵢ, …) = f(aᵢ, bᵢ, …) for every component i, returned as (p, q, …)."""
    first, rows = _rows(args)
    return tuple(cast(E, first.like(parts)) for parts in zip(*(f(*row) for row in rows), strict=True))


def _rows(args: tuple[Any, ...]) -> tuple[_Elementwise, list[tuple[Scalar, ...]]]:
    first = next(a for a in args if isinstance(a, _Elementwise))
    count = len(first.parts())
    columns = [a.parts() if isinstance(a, _Elementwise) else (a,) * count for a in args]
    return first, list(zip(*columns, strict=True))


def total(a: _Elementwise) -> Scalar:
    """Σ aᵢ over the components."""
    return reduce(operator.add, a.parts())


def largest(a: _Elementwise) -> Scalar:
    """max aᵢ over the components."""
    return reduce(jnp.maximum, a.parts())


def dot(a: Vector, b: Vector) -> Scalar:
    """aᵀb."""
    return a.x * b.x + a.y * b.y + a.z * b.z


def cross(a: Vector, b: Vector) -> Vector:
    """a × b = a^× b, with a^× = [0, −a₃, a₂; a₃, 0, −a₁; −a₂, a₁, 0]."""
    return Vector(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)


def norm(a: Vector) -> Scalar:
    """|a|."""
    return jnp.sqrt(dot(a, a))


def apply(j: Symmetric, a: Vector) -> Vector:
    """J a."""
    return Vector(
        j.xx * a.x + j.xy * a.y + j.xz * a.z,
        j.xy * a.x + j.yy * a.y + j.yz * a.z,
        j.xz * a.x + j.yz * a.y + j.zz * a.z,
    )


def inverse(j: Symmetric) -> Symmetric:
    """J⁻¹ = adj(J) / det(J), for J positive definite."""
    adj = Symmetric(
        j.yy * j.zz - j.yz * j.yz,
        j.xx * j.zz - j.xz * j.xz,
        j.xx * j.yy - j.xy * j.xy,
        j.xy * j.xz - j.xx * j.yz,
        j.xy * j.yz - j.yy * j.xz,
        j.xz * j.yz - j.zz * j.xy,
    )
    return adj / (j.xx * adj.xx + j.xy * adj.xy + j.xz * adj.xz)


def symmetric_gradient(z: Vector, a: Vector) -> Symmetric:
    """∂(zᵀJa)/∂J for the six independent entries of J: zᵢaᵢ on the diagonal, zᵢaⱼ + zⱼaᵢ off it."""
    return Symmetric(
        z.x * a.x,
        z.y * a.y,
        z.z * a.z,
        z.y * a.z + z.z * a.y,
        z.x * a.z + z.z * a.x,
        z.x * a.y + z.y * a.x,
    )


def rotation(sigma: Vector) -> Rotation:
    """R(σ) = I − 4(1−σᵀσ)/(1+σᵀσ)² σ^× + 8/(1+σᵀσ)² (σ^×)², from the target frame T to the pursuer frame P.

    σ: modified Rodrigues parameters of P with respect to T. (σ^×)² = σσᵀ − σᵀσ I.
    """
    s2 = dot(sigma, sigma)
    scale = 1.0 / ((1.0 + s2) * (1.0 + s2))
    c = -4.0 * (1.0 - s2) * scale
    d = 8.0 * scale
    x, y, z = sigma.x, sigma.y, sigma.z
    diagonal = 1.0 - d * s2
    return Rotation(
        Vector(diagonal + d * x * x, d * x * y - c * z, d * x * z + c * y),
        Vector(d * x * y + c * z, diagonal + d * y * y, d * y * z - c * x),
        Vector(d * x * z - c * y, d * y * z + c * x, diagonal + d * z * z),
    )


def rotate(r: Rotation, v: Vector) -> Vector:
    """R v."""
    return Vector(dot(r.a, v), dot(r.b, v), dot(r.c, v))


def rotate_back(r: Rotation, v: Vector) -> Vector:
    """Rᵀ v."""
    return r.a * v.x + r.b * v.y + r.c * v.z


def mrp_rate(sigma: Vector, omega: Vector) -> Vector:
    """σ̇ = G(σ) ω,  G = ¼[(1−σᵀσ) I + 2σ^× + 2σσᵀ];  ω [rad/s] of P relative to T, in P."""
    s2 = dot(sigma, sigma)
    return (omega * (1.0 - s2) + cross(sigma, omega) * 2.0 + sigma * (2.0 * dot(sigma, omega))) * 0.25


def shadow(sigma: Vector) -> Vector:
    """The same attitude as MRP of norm ≤ 1: σ, or −σ/|σ|² if |σ| > 1."""
    s2 = dot(sigma, sigma)
    return sigma * jnp.where(s2 > 1.0, -1.0 / s2, 1.0)


def compose(a: Vector, b: Vector) -> Vector:
    """σ with R(σ) = R(a) R(b): first b, then a about the rotated axes.

    σ = [(1 − bᵀb) a + (1 − aᵀa) b − 2 a×b]/(1 + aᵀa bᵀb − 2 aᵀb); not finite if both together are a full turn.
    """
    a2, b2 = dot(a, a), dot(b, b)
    return (a * (1.0 - b2) + b * (1.0 - a2) - cross(a, b) * 2.0) / (1.0 + a2 * b2 - 2.0 * dot(a, b))
