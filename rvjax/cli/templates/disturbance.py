"""Solar pressure: a push along the line from the earth to the target, with a torque by its lever.

F = f R(σ) r_t/|r_t|,   τ = r × F
"""

import jax.numpy as jnp

from rvjax.components import Disturbance, Parameters, Wrench, rotation_matrix, scalar, vector


class Pressure(Parameters):
    """Force and lever."""

    push_N: float = scalar("N", default=0.001, at_least=0.0, doc="size f of the force")
    lever_m: float = vector("m", default=0.05, doc="centre of pressure r from the centre of mass, in the pursuer's frame")


def push(scene, numbers):
    """Force and torque on the pursuer, in its frame."""
    away = rotation_matrix(scene.sigma) @ scene.target_r
    force = numbers.push_N * away / jnp.linalg.norm(away)
    return Wrench(force, jnp.cross(numbers.lever_m, force))


DISTURBANCE = Disturbance(Pressure, push)
