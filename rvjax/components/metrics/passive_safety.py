"""Passive safety: if all thrust ends at some instant of the flight, does the pursuer stay out of the target's keep-out ball?

    c = min |Δ(t + s)| − r   over 0 ≤ s ≤ H and over the instants t = 0, T, 2T, … with |Δ(t)| > r
    Δ̈ = g(r_t + Δ) − g(r_t),   r̈_t = g(r_t)                                   from Δ(t), Δ̇(t)

Δ: pursuer's centre of mass from the target's; r: `radius_m`; H: `coast_s`; T: `every_s`. The free drift is that of two bodies
about the Earth, without thrust and disturbances, integrated by RK4 in steps of `drift_step_s`. Between two of them |Δ|² is the
cubic through its values and slopes at both (Hermite). Instants at which the pursuer is inside the ball do not count: a docking
flight must end there. c < 0: at some instant free drift leads into the ball. The unsafe time is the time of the flight that such
instants stand for, each for the time until the next.

It is a metric of safety: where the hulls collide it stays valid. The flight goes on there as if nothing had happened, and what
follows can only lower the clearance and add to the unsafe time.

`from: fault` counts only instants from the onset of the last fault on; without a fault the clearance is ∞ and the unsafe time 0.
Steps of 60 s err by 5e-6 of the largest distance after an orbit of 95 minutes and by 3e-4 after a day, steps of 30 s by 3e-7 and
1e-5; the smallest distance errs by some millimetres at 0.1 m/s. W. Fehse, "Automated rendezvous and docking of spacecraft",
2003, ch. 4, on trajectories that are safe without thrust.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, Literal, NamedTuple

import jax
import jax.numpy as jnp
from pydantic import model_validator

from rvjax.campaign import Model, Quantity, Spec, number, option, scalar
from rvjax.campaign.plain_values import exact
from rvjax.campaign.problems import Problem, refuse
from rvjax.columns import Column
from rvjax.components.metrics.interface import Metric, MetricContext
from rvjax.components.registry import Component
from rvjax.physics.free_motion import FreeMotion, free_motion, free_rate, rk4
from rvjax.physics.state import Step
from rvjax.physics.vectors import Scalar, dot, norm

MOST_STEPS = 10_000
"""Most steps of a drift."""


class Parameters(Model):
    """The ball, how far the drift is followed, and at which instants it begins."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = (
        {"radius_m": 200, "coast_s": 5400, "every_s": 30},
        {"radius_m": 10, "from": "fault"},
    )

    radius_m: Quantity = scalar("m", above=0.0, doc="radius r of the keep-out ball around the target's centre of mass")
    coast_s: float = number("s", default=5400.0, above=0.0, doc="time H of free drift")
    every_s: float = number("s", default=10.0, above=0.0, doc="time T between two instants, a whole number of steps")
    drift_step_s: float = number("s", default=60.0, above=0.0, doc="longest step of the integration of the drift")
    since: Literal["start", "fault"] = option(
        key="from", default="start", doc="start: all instants; fault: those from the last fault on"
    )

    @property
    def steps(self) -> int:
        """Of a drift."""
        return max(math.ceil(self.coast_s / self.drift_step_s - 1e-9), 1)

    @model_validator(mode="after")
    def _not_too_many(self) -> Parameters:
        if self.coast_s / self.drift_step_s > MOST_STEPS:
            accepted = f"accepted: at least {exact(self.coast_s / MOST_STEPS)} s, for {MOST_STEPS} steps at most"
            refuse(Problem(f"{exact(self.drift_step_s)} s is too short", accepted, ("drift_step_s",)))
        return self


class Safety(NamedTuple):
    """Smallest clearance [m], time from which free drift is unsafe [s], so far."""

    clearance: Scalar
    unsafe: Scalar


def build(parameters: Parameters) -> Metric:
    """The metric with its numbers of steps."""
    steps, length = parameters.steps, parameters.coast_s / parameters.steps

    def start(context: MetricContext) -> Safety:
        zero = context.duration_s * 0.0
        return Safety(zero + jnp.inf, zero)

    def update(acc: Safety, step: Step, weight: Scalar, context: MetricContext) -> Safety:
        del weight
        begin = free_motion(step.motion, step.target, step.plant.port)
        counts = norm(begin.delta) > context.numbers.radius_m
        if parameters.since == "fault":
            counts = counts & (step.t >= context.last_onset_s) & (context.last_onset_s > -jnp.inf)
        clearance = nearest(begin, steps, length) - context.numbers.radius_m
        stands_for = jnp.clip(context.duration_s - step.t, 0.0, parameters.every_s)
        return Safety(
            jnp.where(counts, jnp.minimum(acc.clearance, clearance), acc.clearance),
            acc.unsafe + jnp.where(counts & (clearance < 0.0), stands_for, 0.0),
        )

    def finish(acc: Safety, context: MetricContext) -> Mapping[str, Scalar]:
        return dict(zip(_COLUMNS, (acc.clearance, jnp.minimum(acc.unsafe, context.duration_s)), strict=True))

    return Metric(_COLUMNS, start, update, finish, safety=True, every_s=parameters.every_s)


def nearest(begin: FreeMotion, steps: int, h: float) -> Scalar:
    """min |Δ| [m] over a free drift of that many steps of h [s]."""

    def stepped(_: Any, now: tuple[FreeMotion, Scalar]) -> tuple[FreeMotion, Scalar]:
        before, least = now
        after = rk4(free_rate, before, h)
        return after, jnp.minimum(least, _lowest(before, after, h))

    return jnp.sqrt(jax.lax.fori_loop(0, steps, stepped, (begin, dot(begin.delta, begin.delta)))[1])


def _lowest(before: FreeMotion, after: FreeMotion, h: float) -> Scalar:
    """Smallest |Δ|² of a step, at its end or where the cubic f(u), 0 ≤ u ≤ 1, stops falling: f' = a u² + b u + c = 0."""
    first, last = dot(before.delta, before.delta), dot(after.delta, after.delta)
    c, end = 2.0 * h * dot(before.delta, before.speed), 2.0 * h * dot(after.delta, after.speed)
    a = 3.0 * (c + end) - 6.0 * (last - first)
    b = end - c - a
    turns = (c < 0.0) & (end > 0.0)
    root = jnp.sqrt(jnp.where(turns, jnp.maximum(b * b - 4.0 * a * c, 0.0), 1.0))
    u = jnp.where(turns, -2.0 * c / jnp.where(turns, b + root, 1.0), 1.0)
    lowest = jnp.maximum(first + u * (c + u * (0.5 * b + u * (a / 3.0))), 0.0)
    return jnp.minimum(last, jnp.where(turns, lowest, last))


def silent(parameters: Parameters, campaign: Spec) -> Iterator[Problem]:
    """A problem if no instant can count."""
    if parameters.since == "fault" and not campaign.faults:
        yield Problem("the campaign has no fault", "accepted: from: start")


_COLUMNS = {
    column.name: column
    for column in (
        Column("free_drift_clearance_m", "m", "smallest distance of any free drift from the keep-out ball; inf: none", "higher"),
        Column("free_drift_unsafe_s", "s", "time of the flight from which free drift enters the keep-out ball", "lower"),
    )
}
COMPONENT = Component(Parameters, build, silent=silent)
