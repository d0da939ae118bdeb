"""Discrete-time PD: it acts every period_s, on an angular rate that is smoothed from instant to instant."""

from rvjax.components import Command, DiscreteController, Parameters, scalar


class Gains(Parameters):
    """Gains of the controller."""

    mass_guess_kg: float = scalar("kg", default=100.0, above=0.0, doc="nominal mass")
    kp: float = scalar("1/s²", default=0.0025, above=0.0, doc="position gain")
    kd: float = scalar("1/s", default=0.1, above=0.0, doc="velocity gain")
    kq: float = scalar("N·m", default=6.0, above=0.0, doc="attitude gain")
    kw: float = scalar("N·m·s", default=15.0, above=0.0, doc="rate gain")


def start(measured, gains):
    """The filtered rate before the first instant."""
    return measured.omega


def update(measured, rate, gains):
    """The command until the next instant, and the new state."""
    rate = 0.5 * rate + 0.5 * measured.omega
    force = -gains.mass_guess_kg * (gains.kp * measured.rho + gains.kd * measured.nu)
    torque = -gains.kq * measured.quaternion[1:] - gains.kw * rate
    return Command(force, torque), rate


CONTROLLER = DiscreteController(Gains, start, update, period_s=0.5)
