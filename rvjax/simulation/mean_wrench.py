"""The mean total wrench on the pursuer over whole steps: with it another simulator repeats a flight.

    ū = (u₁ + 2u₂ + 2u₃ + u₄)/6,   u_i: total wrench at stage i of the Runge–Kutta step
    u = (f, τ − c×f) + d + Σ wrenches of the effects                            about the centre of mass, in P [N, N·m]

f, τ: applied wrench, c: centre of mass from the reference point of the torques, d: disturbances. Over n steps: the mean of the n
means. So n h ū is the impulse that the integration itself gives to the pursuer, its components taken in P, which turns.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from rvjax.physics.state import State, Step, Tick
from rvjax.physics.vectors import Channels, Scalar
from rvjax.simulation import flight
from rvjax.simulation.closed_loop import Drawn, Held
from rvjax.simulation.flight import Carry, Evaluate


class Summed(NamedTuple):
    """carry: of the flight. means: Σ ū over the steps so far [N, N·m]."""

    carry: Carry
    means: Channels


class _Control(NamedTuple):
    """state: of the controller. means: integral of the total wrench over time in steps."""

    state: Any
    means: Channels


def mean_wrench(evaluate: Evaluate, drawn: Drawn, carry: Carry, first: Scalar, last: Scalar) -> Channels:
    """The mean from step `first`, at which the carry is, to step `last`."""
    summed = Summed(carry, jax.tree.map(jnp.zeros_like, drawn.upper))
    summed = jax.lax.fori_loop(first, last, lambda k, summed: step(evaluate, drawn, summed, k), summed)
    return summed.means * (1.0 / (last - first))


def step(evaluate: Evaluate, drawn: Drawn, summed: Summed, k: Scalar) -> Summed:
    """After step k: the same step of the flight (`flight.step`), in which the total wrench is integrated too. Metrics stay."""
    carry = summed.carry
    y = carry.y._replace(control=_Control(carry.y.control, summed.means))

    def both(drawn: Drawn, t: Scalar, y: State, held: Held, tick: Tick | None) -> tuple[State, Step, Held]:
        rate, now, held = evaluate(drawn, t, y._replace(control=y.control.state), held, tick)
        assert isinstance(now.total, Channels)
        return rate._replace(control=_Control(rate.control, now.total * (1.0 / drawn.context.step_s))), now, held

    after = flight.step(both, (), drawn, carry._replace(y=y, accumulators=()), k)
    control, means = after.y.control
    return Summed(after._replace(y=after.y._replace(control=control), accumulators=carry.accumulators), means)
