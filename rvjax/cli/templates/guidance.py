"""Straight to the docking point: the speed is a share κ of the distance, slower while the pursuer is behind.

u = −κ p,  of size v at most, times 1/(1 + |Rᵀρ − p|/1 m)
"""

import jax.numpy as jnp

from rvjax.components import Course, Guidance, GuidanceParameters, rotation_matrix, scalar


class Straight(GuidanceParameters):
    """Speeds."""

    speed_m_s: float = scalar("m/s", default=0.3, above=0.0, doc="largest speed v")
    slope: float = scalar("1/s", default=0.05, above=0.0, doc="speed per distance κ")


def course(approach, numbers):
    """The wanted velocity of the reference point, in the target's frame."""
    pursuer = rotation_matrix(approach.sigma).T @ approach.rho
    wanted = -numbers.slope * approach.point
    size = jnp.sqrt(wanted @ wanted + 1e-12)
    behind = jnp.linalg.norm(pursuer - approach.point)
    return Course(velocity=wanted * jnp.minimum(1.0, numbers.speed_m_s / size) / (1.0 + behind))


GUIDANCE = Guidance(Straight, course)
