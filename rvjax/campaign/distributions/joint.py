"""Laws of the three components of a vector together: on a sphere, in a ball, about a direction, of a rotation."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from rvjax.campaign.distributions.interface import Array, array, between, positive
from rvjax.elementary import cbrt, cos, expm1, length, log1p, sin


def _on_sphere(u: Array) -> Array:
    """z = 2u₁ − 1, azimuth 2πu₂ (Archimedes: the height of a uniform point on a sphere is uniform)."""
    z, azimuth = 2.0 * u[:, 0] - 1.0, 2.0 * math.pi * u[:, 1]
    across = 2.0 * np.sqrt(u[:, 0] * (1.0 - u[:, 0]))
    return np.stack((across * cos(azimuth), across * sin(azimuth), z), axis=1)


@dataclass(frozen=True)
class Direction:
    """Uniform on the sphere |X| = radius."""

    radius: float
    uniforms: ClassVar[int] = 2

    def __post_init__(self) -> None:
        positive("radius", self.radius)

    def ppf(self, u: ArrayLike) -> Array:
        return self.radius * _on_sphere(array(u))

    def scaled(self, factor: float) -> Direction:
        return Direction(self.radius * factor)


@dataclass(frozen=True)
class Ball:
    """Uniform in the ball |X| ≤ radius: |X| = radius · ∛u₃ along a uniform direction."""

    radius: float
    uniforms: ClassVar[int] = 3

    def __post_init__(self) -> None:
        positive("radius", self.radius)

    def ppf(self, u: ArrayLike) -> Array:
        share = array(u)
        return self.radius * cbrt(share[:, 2:3]) * _on_sphere(share[:, :2])

    def scaled(self, factor: float) -> Ball:
        return Ball(self.radius * factor)


@dataclass(frozen=True)
class VonMisesFisher:
    """Density ∝ exp(κ m·x/|x|) on the sphere |X| = radius: directions about m, the narrower the larger κ.

    With t = 1 − m·x/|x| ∈ [0, 2]:  t = −ln[1 − (1 − e^(−2κ)) u₁]/κ,  azimuth about m 2πu₂; exact in three dimensions
    (N. Fisher, T. Lewis, B. Embleton, "Statistical Analysis of Spherical Data", 1987, section 3.6). For large κ the angle to m
    is about 1/√κ rad in each of two directions.
    """

    mean: tuple[float, float, float]
    kappa: float
    radius: float
    uniforms: ClassVar[int] = 2

    @classmethod
    def of(cls, mean: tuple[float, float, float], kappa: float, radius: float) -> VonMisesFisher:
        """mean: of any length above 0."""
        norm = length(*mean)
        positive("length of the mean", norm)
        x, y, z = mean
        return cls((x / norm, y / norm, z / norm), kappa, radius)

    def __post_init__(self) -> None:
        between("kappa", self.kappa, 1e-6, 1e12)
        positive("radius", self.radius)

    def ppf(self, u: ArrayLike) -> Array:
        share = array(u)
        t = -log1p(expm1(-2.0 * self.kappa) * share[:, 0]) / self.kappa
        t = np.clip(t, 0.0, 2.0)
        azimuth, across = 2.0 * math.pi * share[:, 1], np.sqrt(t * (2.0 - t))
        first, second = self._beside()
        along = np.outer(1.0 - t, self.mean)
        return self.radius * (along + np.outer(across * cos(azimuth), first) + np.outer(across * sin(azimuth), second))

    def _beside(self) -> tuple[Array, Array]:
        """Two directions perpendicular to m and to each other (T. Duff et al., J. Computer Graphics Techniques 6:1, 2017)."""
        x, y, z = self.mean
        sign = math.copysign(1.0, z)
        a = -1.0 / (sign + z)
        b = x * y * a
        return array((1.0 + sign * x * x * a, sign * b, -sign * x)), array((b, sign + y * y * a, -y))

    def scaled(self, factor: float) -> VonMisesFisher:
        return VonMisesFisher(self.mean, self.kappa, self.radius * factor)


@dataclass(frozen=True)
class Attitude:
    """σ = q_v/(1 + |q_0|), q uniform on the unit sphere in four dimensions: MRP of a rotation that is uniform over SO(3).

    q = (√u₁ cos 2πu₃, √u₁ sin 2πu₃, √(1−u₁) sin 2πu₂, √(1−u₁) cos 2πu₂) (K. Shoemake, "Uniform random rotations", Graphics Gems
    III, 1992). With |q_0| in place of q_0 the rotation is uniform too, and |σ| ≤ 1. A campaign calls it `rotation: uniform`.
    """

    radius: float = 1.0
    uniforms: ClassVar[int] = 3

    def __post_init__(self) -> None:
        positive("radius", self.radius)

    def ppf(self, u: ArrayLike) -> Array:
        share = array(u)
        first_root, other = np.sqrt(share[:, 0]), np.sqrt(1.0 - share[:, 0])
        first, second = 2.0 * math.pi * share[:, 1], 2.0 * math.pi * share[:, 2]
        scalar = np.abs(first_root * cos(second))
        vector = np.stack((first_root * sin(second), other * sin(first), other * cos(first)), axis=1)
        return self.radius * vector / (1.0 + scalar)[:, None]

    def scaled(self, factor: float) -> Attitude:
        return Attitude(self.radius * factor)
