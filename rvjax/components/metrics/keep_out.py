"""Smallest distance of the pursuer's centre of mass from a keep-out ball that is fixed in the target.

    c = min over the steps of |Rᵀρ + δ − p| − r

δ: docking point, p: centre of the ball, both in T; ρ: pursuer minus docking point, in P. c < 0: the pursuer was inside. The
distance is evaluated at the steps; between two of them the pursuer moves by its speed times the step. It is a metric of safety:
where the hulls collide it stays valid, over the whole flight as if nothing had happened.
"""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp

from rvjax.campaign import Model, Quantity, scalar, vector
from rvjax.components.forms.arrays import rotation_matrix
from rvjax.components.forms.metric import Instant, Metric
from rvjax.components.forms.signal import Signal
from rvjax.physics.state import Numbers


class Parameters(Model):
    """The ball."""

    centre_m: Quantity = vector("m", default=0.0, doc="centre p of the ball, in the target's frame")
    radius_m: Quantity = scalar("m", above=0.0, doc="radius r of the ball")


def start(numbers: Numbers) -> Any:
    """Far away."""
    del numbers
    return {"clearance_m": jnp.inf}


def update(acc: Any, instant: Instant, numbers: Numbers) -> Any:
    """The smaller distance."""
    away = rotation_matrix(instant.sigma).T @ instant.rho + instant.port - numbers.centre_m
    return {"clearance_m": jnp.minimum(acc["clearance_m"], jnp.sqrt(away @ away) - numbers.radius_m)}


COLUMNS = {"clearance_m": Signal("m", "smallest distance from the keep-out ball", "higher")}
METRIC = Metric(Parameters, COLUMNS, start, update, safety=True)
