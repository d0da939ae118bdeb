"""PD law on the position and the velocity in the Hill frame, for a pursuer of 100 kg."""

import jax.numpy as jnp

from rvjax.components import Command, Controller, Parameters, scalar


class Gains(Parameters):
    """Gains per unit of mass."""

    kp: float = scalar("1/s²", default=0.0009, above=0.0, doc="position stiffness")
    kd: float = scalar("1/s", default=0.05, above=0.0, doc="velocity damping")


def respond(measured, state, gains):
    velocity = measured.nu - jnp.cross(measured.target_w, measured.rho)
    return Command(-100.0 * (gains.kp * measured.rho + gains.kd * velocity), jnp.zeros(3))


CONTROLLER = Controller(Gains, respond=respond)
