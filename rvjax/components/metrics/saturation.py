"""Saturation per actuator channel: share of the flight, longest time, peak depth.

A channel is saturated if |h(v)| ≥ 0.99 of its limit on that side. Depth: |v|/u_m.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import jax.numpy as jnp

from rvjax.columns import CHANNELS, Column
from rvjax.components.metrics.interface import Metric, MetricContext
from rvjax.physics.state import Step
from rvjax.physics.vectors import Channels, Scalar, each, largest

THRESHOLD = 0.99


class Saturated(NamedTuple):
    """Saturated time, current and longest saturated stretch [s], peak depth; per channel."""

    time: Channels
    stretch: Channels
    longest: Channels
    depth: Channels


def start(context: MetricContext) -> Saturated:
    zero = context.duration_s * 0.0
    channels = Channels.of((zero,) * 6)
    return Saturated(channels, channels, channels, channels)


def update(acc: Saturated, step: Step, weight: Scalar, context: MetricContext) -> Saturated:
    """time += weight, stretch += weight where saturated; depth = max(depth, |v|/u_m)."""
    del context
    limit = each(lambda h, up, low: jnp.where(h >= 0, up, low), step.commanded, step.plant.upper, step.plant.lower)
    on = each(lambda h, u: jnp.abs(h) >= THRESHOLD * u, step.commanded, limit)
    stretch = each(lambda o, s: jnp.where(o, s + weight, 0.0), on, acc.stretch)
    return Saturated(
        time=each(lambda o, t: t + jnp.where(o, weight, 0.0), on, acc.time),
        stretch=stretch,
        longest=each(jnp.maximum, acc.longest, stretch),
        depth=each(lambda d, v, u: jnp.maximum(d, jnp.abs(v) / u), acc.depth, step.command, limit),
    )


def finish(acc: Saturated, context: MetricContext) -> Mapping[str, Scalar]:
    """Each per channel and, as `.any`, of the worst channel. Rounding errors of the sums do not lead beyond the flight."""
    values: dict[str, Scalar] = {}
    duration = context.duration_s
    for name, channels in (
        ("saturation_duty", each(lambda time: jnp.minimum(time, duration) / duration, acc.time)),
        ("longest_saturated_s", each(lambda time: jnp.minimum(time, duration), acc.longest)),
        ("saturation_depth", acc.depth),
    ):
        values |= {f"{name}.{channel}": part for channel, part in zip(CHANNELS, channels.parts(), strict=True)}
        values[f"{name}.any"] = largest(channels)
    return values


_WHAT = {
    "saturation_duty": ("1", "share of the flight with |h(v)| at 0.99 of its limit or more"),
    "longest_saturated_s": ("s", "longest time without leaving saturation"),
    "saturation_depth": ("1", "peak |v|/u_m, the command relative to the limit"),
}
_COLUMNS = tuple(
    Column(f"{name}.{channel}", unit, f"{text}, {'worst channel' if channel == 'any' else 'channel ' + channel}", "lower")
    for name, (unit, text) in _WHAT.items()
    for channel in (*CHANNELS, "any")
)
COMPONENT = Metric({column.name: column for column in _COLUMNS}, start, update, finish)
