"""A flight: RK4 over the closed loop with metric folds, for one sample.

    y_{k+1} = switch(rk4(y_k)),   acc_{k+1} = update(acc_k, step(t_k, y_k), weight_k),   t_k = k h

A flight is begun, advanced from step to step as far as wanted, and finished; where it is interrupted changes nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from rvjax.components.metrics.interface import Metric
from rvjax.physics.state import State, Step, Tick
from rvjax.physics.vectors import Channels, Scalar, norm
from rvjax.simulation import closed_loop, rk4
from rvjax.simulation.closed_loop import Drawn, Held

Evaluate = Callable[[Drawn, Scalar, State, Held, Tick | None], tuple[State, Step, Held]]
"""(numbers, t, y, held, tick) → (ẏ, everything at this instant, held): the closed loop."""


class Carry(NamedTuple):
    """State, what was held during the step before, accumulators of the metrics, and the first instant at which the state was not
    finite (+∞: never)."""

    y: State
    held: Held
    folds: tuple[Any, ...]
    lost_s: Scalar


class EnvelopePoint(NamedTuple):
    """|ρ| [m], |ν| [m/s], |σ|, |ω| [rad/s], and the commanded wrench [N, N·m]."""

    rho: Scalar
    nu: Scalar
    sigma: Scalar
    omega: Scalar
    commanded: Channels


def begin(loop: closed_loop.Loop, metrics: tuple[Metric, ...], drawn: Drawn) -> Carry:
    """The carry at t = 0."""
    y, held = closed_loop.start(loop, drawn)
    folds = tuple(metric.start(drawn.context) for metric in metrics)
    carry = Carry(y, held, folds, jnp.where(finite(y), jnp.inf, 0.0))
    return jax.tree.map(lambda x: jnp.asarray(x, drawn.context.step_s.dtype), carry)


def advance(evaluate: Evaluate, metrics: tuple[Metric, ...], drawn: Drawn, carry: Carry, first: Scalar, last: Scalar) -> Carry:
    """The carry at step `last` from the carry at step `first` (whole numbers)."""
    return jax.lax.fori_loop(first, last, lambda k, carry: step(evaluate, metrics, drawn, carry, k), carry)


def step(evaluate: Evaluate, metrics: tuple[Metric, ...], drawn: Drawn, carry: Carry, k: Scalar) -> Carry:
    """The carry at step k + 1 from the carry at step k."""
    h = drawn.context.step_s
    t = k * h
    rate, now, held = opened(evaluate, drawn, carry, k)
    weight = h * jnp.where(k == 0, 0.5, 1.0)
    folds = fold(metrics, carry.folds, now, weight, drawn)
    y = rk4.step(lambda s, x: evaluate(drawn, s, x, held, None)[0], t, carry.y, h, rate)
    y = closed_loop.between_steps(y)
    lost = jnp.minimum(carry.lost_s, jnp.where(finite(y), jnp.inf, t + h))
    return Carry(y, held, folds, lost)


def opened(evaluate: Evaluate, drawn: Drawn, carry: Carry, k: Scalar) -> tuple[State, Step, Held]:
    """(ẏ, everything, what is held) where step k begins. Where nothing is held there is nothing to renew."""
    h = drawn.context.step_s
    tick = Tick(k, k * h, h) if jax.tree.leaves(carry.held) else None
    return evaluate(drawn, k * h, carry.y, carry.held, tick)


def observe(evaluate: Evaluate, drawn: Drawn, carry: Carry, k: Scalar) -> Step:
    """Everything at step k."""
    return opened(evaluate, drawn, carry, k)[1]


def glance(evaluate: Evaluate, drawn: Drawn, carry: Carry, k: Scalar) -> EnvelopePoint:
    """What envelopes over time show of step k."""
    now = observe(evaluate, drawn, carry, k)
    motion = now.motion
    return EnvelopePoint(norm(motion.rho), norm(motion.nu), norm(motion.sigma), norm(motion.omega), now.commanded)


def finish(
    evaluate: Evaluate, metrics: tuple[Metric, ...], drawn: Drawn, carry: Carry, k: Scalar
) -> tuple[Mapping[str, Scalar], Scalar]:
    """The metrics' values after step k, the last, and the time at which the flight was lost (+∞: never)."""
    weight = 0.5 * drawn.context.step_s
    folds = fold(metrics, carry.folds, observe(evaluate, drawn, carry, k), weight, drawn)
    values: dict[str, Scalar] = {}
    for metric, acc in zip(metrics, folds, strict=True):
        values |= metric.finish(acc, drawn.context)
    return values, carry.lost_s


def fold(metrics: tuple[Metric, ...], folds: tuple[Any, ...], now: Step, weight: Scalar, drawn: Drawn) -> tuple[Any, ...]:
    """Every metric's accumulator after one more instant."""
    return tuple(m.update(acc, now, weight, drawn.context) for m, acc in zip(metrics, folds, strict=True))


def finite(y: State) -> Scalar:
    """Whether every number of the state is finite. x − x is 0 for a finite x, NaN otherwise."""
    return sum(x - x for x in jax.tree.leaves(y)) == 0
