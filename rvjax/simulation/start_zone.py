"""Whether a start can lie in the keep-out zone and outside of the approach cone, for every possible draw.

    inside the zone:   Σ (xᵢ/aᵢ)² < 1            x = x₀ + X v: from the target's centre of mass
    inside the cone:   aᵀq ≥ |q| cos(half angle)  q = ρ + apex a, ρ = ρ₀ + P v: from the docking point

v is any point of a box: the drawn components, each scaled to [−½, ½]. The box is divided until each part lies outside of the
zone (by the triangle inequality), inside the cone (which is convex, so that the corners decide) or is tiny, or until the middle
of a part is such a start. All in T [m].
"""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.float64]

PARTS = 100_000
"""Most parts of the box at a time; where more are needed, such a start counts as possible."""

TINY = 1e-6
"""Half of the width of a part that is divided no further."""

ROUNDING = 1e-9
"""A start this near to the surface of the zone or of the cone, relatively, is on its good side."""


class Starts(NamedTuple):
    """The affine map from the drawn components to places. place, rho: (3,) x₀ and ρ₀; by_place, by_rho: (3, k) X and P."""

    place: Values
    rho: Values
    by_place: Values
    by_rho: Values


class Zone(NamedTuple):
    """radii: aᵢ. axis: a. cosine: of the half angle; 2 where there is no certain cone. apex: how far it lies behind the docking
    point. tube: radius about the docking point in which nothing counts."""

    radii: Values
    axis: Values
    cosine: float
    apex: float
    tube: float


def forbidden(starts: Starts, zone: Zone) -> Values | None:
    """The place of a start in the zone and outside of the cone, or None if there is none."""
    count = starts.by_place.shape[1]
    middles, halves = np.zeros((1, count)), np.full((1, count), 0.5)
    while len(middles):
        places = starts.place + middles @ starts.by_place.T
        rho = starts.rho + middles @ starts.by_rho.T
        depth = 1.0 - np.linalg.norm(places / zone.radii, axis=1)
        bad = (depth > ROUNDING) & ~_in_cone(rho, zone) & (np.linalg.norm(rho, axis=1) > zone.tube)
        if bad.any() or len(middles) > PARTS:
            return places[np.argmax(np.where(bad, depth, -np.inf)) if bad.any() else 0]
        reach = halves @ np.linalg.norm(starts.by_place / zone.radii[:, None], axis=0)
        corners = (rho + (halves * corner) @ starts.by_rho.T for corner in product((-1.0, 1.0), repeat=count))
        good = np.all([_in_cone(corner, zone) for corner in corners], axis=0) | (depth + reach <= ROUNDING)
        left = ~good & (halves.max(axis=1, initial=0.0) > TINY)
        middles, halves = _divided(middles[left], halves[left], np.linalg.norm(starts.by_place, axis=0))
    return None


def _in_cone(rho: Values, zone: Zone) -> NDArray[np.bool_]:
    """(n,) whether these places from the docking point lie inside the cone."""
    q = rho + zone.axis * zone.apex
    size = np.linalg.norm(q, axis=1)
    return q @ zone.axis >= size * (zone.cosine - ROUNDING)


def _divided(middles: Values, halves: Values, sizes: Values) -> tuple[Values, Values]:
    """Both halves of each part, along the component that moves the start most."""
    if not len(middles):
        return middles, halves
    rows, widest = np.arange(len(middles)), np.argmax(halves * sizes, axis=1)
    halves = halves.copy()
    halves[rows, widest] *= 0.5
    step = np.zeros_like(middles)
    step[rows, widest] = halves[rows, widest]
    return np.concatenate([middles - step, middles + step]), np.concatenate([halves, halves])
