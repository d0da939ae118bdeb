"""Pulses of one size: full thrust for a share of each period, nothing for the rest; no pulse shorter than shortest_s."""

import jax.numpy as jnp

from rvjax.components import Actuator, Parameters, scalar


class Pulses(Parameters):
    """Period and shortest pulse."""

    period_s: float = scalar("s", default=1.0, above=0.0, doc="period")
    shortest_s: float = scalar("s", default=0.04, at_least=0.0, doc="shortest pulse")


def start(command, numbers):
    """Time that is on, with the sign of the command, and the share of the first step."""
    return {"on": 0.0 * command, "share": 0.0 * command}


def keep(command, memory, clock, numbers):
    """At the beginning of a period the command sets the time that is on; then its share of each step is known."""
    since = (clock.t + 1e-6) % numbers.period_s
    limit = jnp.where(command >= 0.0, numbers.upper, numbers.lower)
    wanted = jnp.clip(command / jnp.where(limit > 0.0, limit, 1.0), -1.0, 1.0) * numbers.period_s
    wanted = jnp.where(jnp.abs(wanted) < numbers.shortest_s, 0.0, wanted)
    on = jnp.where(since < 0.5 * clock.step_s, wanted, memory["on"])
    return {"on": on, "share": jnp.sign(on) * jnp.clip((jnp.abs(on) - since) / clock.step_s, 0.0, 1.0)}


def drive(command, memory, numbers):
    """Full thrust, times the share of the step."""
    return memory["share"] * jnp.where(memory["share"] >= 0.0, numbers.upper, numbers.lower)


ACTUATOR = Actuator(Pulses, drive, start, keep)
