"""Closest approach to a keep-out ball around the target's centre of mass, and the time inside it."""

import jax.numpy as jnp

from rvjax.components import Metric, Parameters, Signal, rotation_matrix, scalar


class Ball(Parameters):
    """The keep-out ball."""

    radius_m: float = scalar("m", default=2.0, above=0.0, doc="radius of the ball")


def start(numbers):
    """Far away, no time inside."""
    return {"ball_clearance_m": jnp.inf, "ball_time_s": 0.0}


def update(acc, instant, numbers):
    """Rᵀρ + δ is the place of the pursuer in the target's frame."""
    place = rotation_matrix(instant.sigma).T @ instant.rho + instant.port
    clearance = jnp.linalg.norm(place) - numbers.radius_m
    return {
        "ball_clearance_m": jnp.minimum(acc["ball_clearance_m"], clearance),
        "ball_time_s": acc["ball_time_s"] + jnp.where(clearance < 0.0, instant.weight, 0.0),
    }


COLUMNS = {
    "ball_clearance_m": Signal("m", "smallest distance from the keep-out ball", "higher"),
    "ball_time_s": Signal("s", "time inside the keep-out ball", "lower"),
}
METRIC = Metric(Ball, COLUMNS, start, update)
