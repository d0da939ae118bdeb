"""A mass on a spring inside the pursuer: propellant that moves along all three axes.

ÿ + c/m_s ẏ + k/m_s y = −a,   F = k y + c ẏ
"""

import jax.numpy as jnp

from rvjax.components import Effect, Parameters, Wrench, scalar


class Spring(Parameters):
    """The moving mass, which is not part of pursuer.mass_kg."""

    slosh_mass_kg: float = scalar("kg", default=5.0, above=0.0, doc="moving mass m_s")
    stiffness: float = scalar("N/m", default=2.0, above=0.0, doc="stiffness k")
    damping: float = scalar("N·s/m", default=0.3, at_least=0.0, doc="damping c")


def start(numbers):
    """Displacement y and speed ẏ at t = 0."""
    return {"y": jnp.zeros(3), "speed": jnp.zeros(3)}


def wrench(body, x, numbers):
    """What the spring does to the pursuer."""
    return Wrench(numbers.stiffness * x["y"] + numbers.damping * x["speed"], jnp.zeros(3))


def rate(body, x, numbers):
    """Newton's law for the mass, in the accelerated frame of the pursuer."""
    force = numbers.stiffness * x["y"] + numbers.damping * x["speed"]
    return {"y": x["speed"], "speed": -body.accel - force / numbers.slosh_mass_kg}


EFFECT = Effect(Spring, start, wrench, rate)
