"""PID on the position, quaternion feedback on the attitude.

f = −m (k_p ρ + k_d ν + k_i ∫ρ dt),   τ = −k_q q_v − k_w ω
"""

import jax.numpy as jnp

from rvjax.components import Command, Controller, Parameters, Signal, scalar


class Gains(Parameters):
    """Gains of the controller: each may be drawn, swept and tuned like those of the shipped controllers."""

    mass_guess_kg: float = scalar("kg", default=100.0, above=0.0, doc="nominal mass m")
    kp: float = scalar("1/s²", default=0.0025, above=0.0, doc="position gain k_p")
    kd: float = scalar("1/s", default=0.1, above=0.0, doc="velocity gain k_d")
    ki: float = scalar("1/s³", default=1e-5, at_least=0.0, doc="integral gain k_i")
    kq: float = scalar("N·m", default=6.0, above=0.0, doc="attitude gain k_q")
    kw: float = scalar("N·m·s", default=15.0, above=0.0, doc="rate gain k_w")


def start(measured, gains):
    """The integral of ρ at t = 0."""
    return jnp.zeros(3)


def respond(measured, integral, gains):
    """Force and torque before the saturation, and the rate of the integral."""
    force = -gains.mass_guess_kg * (gains.kp * measured.rho + gains.kd * measured.nu + gains.ki * integral)
    torque = -gains.kq * measured.quaternion[1:] - gains.kw * measured.omega
    return Command(force, torque, rate=measured.rho, signals={"integral": integral})


CONTROLLER = Controller(Gains, start, respond, signals={"integral": Signal("m·s", "integral of the position error")})
