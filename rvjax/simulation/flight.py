"""A flight: RK4 over the closed loop with the accumulators of the metrics, for a single sample.

    y_{k+1} = switch(rk4(y_k)),   acc_{k+1} = update(acc_k, step(t_k, y_k), weight_k),   t_k = k h

A flight is begun, advanced step by step, and finished. Where it is interrupted changes no bit.
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
"""The closed loop: (numbers, t, y, held, tick) → (ẏ, step, held)."""


class Carry(NamedTuple):
    """What passes from step to step.

    held: values held during the step before. lost_s: first instant at which the state was not finite, +∞ if never.
    """

    y: State
    held: Held
    accumulators: tuple[Any, ...]
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
    accumulators = tuple(metric.start(drawn.context) for metric in metrics)
    carry = Carry(y, held, accumulators, jnp.where(finite(y), jnp.inf, 0.0))
    return jax.tree.map(lambda x: jnp.asarray(x, drawn.context.step_s.dtype), carry)


def advance(evaluate: Evaluate, metrics: tuple[Metric, ...], drawn: Drawn, carry: Carry, first: Scalar, last: Scalar) -> Carry:
    """The carry at step `last` from the carry at step `first` (whole numbers)."""
    return jax.lax.fori_loop(first, last, lambda k, carry: step(evaluate, metrics, drawn, carry, k), carry)


def step(evaluate: Evaluate, metrics: tuple[Metric, ...], drawn: Drawn, carry: Carry, k: Scalar) -> Carry:
    """The carry at step k + 1 from the carry at step k."""
    h = drawn.context.step_s
    t = k * h
    rate, now, held = step_start(evaluate, drawn, carry, k)
    weight = h * jnp.where(k == 0, 0.5, 1.0)
    accumulators = accumulate(metrics, carry.accumulators, now, weight, drawn, k)
    y = rk4.step(lambda s, x: evaluate(drawn, s, x, held, None)[0], t, carry.y, h, rate)
    y = closed_loop.between_steps(y)
    lost = jnp.minimum(carry.lost_s, jnp.where(finite(y), jnp.inf, t + h))
    return Carry(y, held, accumulators, lost)


def step_start(evaluate: Evaluate, drawn: Drawn, carry: Carry, k: Scalar) -> tuple[State, Step, Held]:
    """(ẏ, step, held values) at the start of step k. Without held values there is nothing to update."""
    h = drawn.context.step_s
    tick = Tick(k, k * h, h) if jax.tree.leaves(carry.held) else None
    return evaluate(drawn, k * h, carry.y, carry.held, tick)


def observe(evaluate: Evaluate, drawn: Drawn, carry: Carry, k: Scalar) -> Step:
    """The Step k: all values at its instant."""
    return step_start(evaluate, drawn, carry, k)[1]


def envelope_point(evaluate: Evaluate, drawn: Drawn, carry: Carry, k: Scalar) -> EnvelopePoint:
    """The point of the envelopes at step k."""
    now = observe(evaluate, drawn, carry, k)
    motion = now.motion
    return EnvelopePoint(norm(motion.rho), norm(motion.nu), norm(motion.sigma), norm(motion.omega), now.commanded)


def finish(
    evaluate: Evaluate, metrics: tuple[Metric, ...], drawn: Drawn, carry: Carry, k: Scalar
) -> tuple[Mapping[str, Scalar], Scalar]:
    """The values of the metrics after the last step k, and the time at which the flight was lost (+∞: never)."""
    weight = 0.5 * drawn.context.step_s
    accumulators = accumulate(metrics, carry.accumulators, observe(evaluate, drawn, carry, k), weight, drawn, k)
    values: dict[str, Scalar] = {}
    for metric, acc in zip(metrics, accumulators, strict=True):
        values |= metric.finish(acc, drawn.context)
    return values, carry.lost_s


def accumulate(
    metrics: tuple[Metric, ...], accumulators: tuple[Any, ...], now: Step, weight: Scalar, drawn: Drawn, k: Scalar
) -> tuple[Any, ...]:
    """The accumulator of each metric after the instant of step k; unchanged where the metric is not due."""

    def after(metric: Metric, acc: Any) -> Any:
        if metric.every == 1:
            return metric.update(acc, now, weight, drawn.context)

        def updated(acc: Any) -> Any:
            new = metric.update(acc, now, weight, drawn.context)
            return jax.tree.map(lambda after, before: jnp.asarray(after, jnp.result_type(before)), new, acc)

        return jax.lax.cond(k % metric.every == 0, updated, lambda acc: acc, acc)

    return tuple(after(metric, acc) for metric, acc in zip(metrics, accumulators, strict=True))


def finite(y: State) -> Scalar:
    """Whether every number of the state is finite. x − x is 0 for a finite x, NaN otherwise."""
    return sum(x - x if jnp.ndim(x) == 0 else jnp.sum(x - x) for x in jax.tree.leaves(y)) == 0
