"""Disturbance that breaks the arithmetic of a flight: of a share of the samples, from a drawn instant on.

    d_x(t) = 0                                        t < t_0, or lot ≥ share
    d_x(t) = NaN, ∞ or 1e308 N (kind 0, 1, 2)         else

1e308 N is a number, but squares of what it leads to are none any more.
"""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp

from rvjax.campaign import Model, Quantity, scalar
from rvjax.components.disturbances.interface import Disturbance
from rvjax.components.registry import Component
from rvjax.physics.vectors import Channels, Vector


class Parameters(Model):
    """Who breaks, when, and how."""

    onset_s: Quantity = scalar("s", doc="instant t_0")
    lot: Quantity = scalar("1", doc="a sample breaks where it is below the share")
    share: Quantity = scalar("1", doc="share of the samples that break")
    kind: Quantity = scalar("1", doc="0: NaN, 1: infinite, 2: overflow")


def push(t: Any, y: Any, known: Any, plant: Any, memory: Any, numbers: Any) -> Channels:
    """d(t)."""
    del y, known, memory
    broken = jnp.where(numbers.kind < 0.5, jnp.nan, jnp.where(numbers.kind < 1.5, jnp.inf, 1e308))
    blow = jnp.where((numbers.lot < numbers.share) & (t >= numbers.onset_s), broken, 0.0)
    zero = plant.mass * 0.0
    return Channels(Vector(blow, zero, zero), Vector(zero, zero, zero))


COMPONENT = Component(Parameters, lambda parameters: Disturbance(push))
