"""Random loss of the measurement; meanwhile the last measurement is held, or propagated without forces (`between`).

    lost in a step with the probability p, independently                         probability
    outages of length d; from the end of one to the next an exponential          mean_interval_s, duration_s
    time with the mean T: in every step one begins with 1 − e^{−h/T}

Both may act together. The flight begins without an outage. An outage is the nearest whole number of steps long, at least one.
With `update-rate` after it in the list, an update that is lost stays lost until the next one; with `update-rate` before it, it is
made up for at the end of the outage. `between` and `of`: as in `update-rate`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, NamedTuple, Self

import jax.numpy as jnp
from pydantic import model_validator

from rvjax.campaign import Quantity, Spec, scalar
from rvjax.campaign.plain_values import exact
from rvjax.campaign.problems import Problem, refuse
from rvjax.components.effect import zero
from rvjax.components.navigation.interface import NavigationError
from rvjax.components.navigation.last_measurement import Interrupted, Last, LastMeasurement, age
from rvjax.components.registry import Component
from rvjax.physics.elementary import expm1
from rvjax.physics.noise import uniforms
from rvjax.physics.state import Motion, Numbers, Tick
from rvjax.physics.vectors import Scalar


class Parameters(Interrupted):
    """How often a measurement is lost, and for how long."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = (
        {"probability": 0.2},
        {"mean_interval_s": 60, "duration_s": {"uniform": [1, 5]}, "between": "propagate"},
    )

    probability: Quantity = scalar(
        "1", default=0.0, at_least=0.0, at_most=1.0, doc="probability p that the measurement of a step is lost"
    )
    mean_interval_s: Quantity | None = scalar(
        "s", default=None, above=0.0, doc="mean time T from the end of an outage to the next one; null: no outages"
    )
    duration_s: Quantity | None = scalar("s", default=None, above=0.0, doc="duration d of each outage")

    @model_validator(mode="after")
    def _outages(self) -> Self:
        missing = [key for key in ("mean_interval_s", "duration_s") if getattr(self, key) is None]
        if len(missing) == 1:
            refuse(Problem("missing", "accepted: mean_interval_s and duration_s, both or neither", (missing[0],), at_key=True))
        return self


class Memory(NamedTuple):
    """left: steps that an outage still lasts, this one included; last: the last measurement."""

    left: Scalar
    last: Last


def begins(tick: Tick, numbers: Numbers) -> Scalar:
    """The probability 1 − e^{−h/T} that an outage begins in a step; 0 for T = 0."""
    mean = numbers.mean_interval_s
    return jnp.where(mean > 0.0, -expm1(-tick.h / jnp.where(mean > 0.0, mean, 1.0)), 0.0)


def build(parameters: Parameters) -> NavigationError:
    """The measurement with its losses."""
    last = LastMeasurement.of(parameters)

    def start(motion: Motion, numbers: Numbers) -> Memory:
        return Memory(motion.rho.x * 0.0, last.first(motion, numbers))

    def keep(tick: Tick, motion: Motion, memory: Memory, numbers: Numbers) -> Memory:
        single, outage = uniforms(numbers.noise, tick.k)
        left = memory.left
        if "mean_interval_s" in numbers:
            left = jnp.maximum(left - 1.0, 0.0)
            steps = jnp.maximum(jnp.round(numbers.duration_s / tick.h), 1.0)
            left = jnp.where((left < 0.5) & (outage < begins(tick, numbers)), steps, left)
        lost = (left > 0.5) | (single < numbers.probability)
        return Memory(left, last.renewed(~lost, tick, motion, memory.last, numbers))

    def see(t: Scalar, motion: Motion, memory: Memory, numbers: Numbers) -> Motion:
        del numbers
        return last.seen(t, motion, memory.last)

    return NavigationError(see, start, keep, informed=last.propagated, age=lambda t, memory: age(t, memory.last))


def coarse(parameters: Parameters, spec: Spec) -> Iterator[Problem]:
    """Outages, or times between them, that are shorter than a step."""
    step = spec.horizon.step_s
    for key, quantity in (("duration_s", parameters.duration_s), ("mean_interval_s", parameters.mean_interval_s)):
        if quantity is not None and (most := quantity.supports[0][1]) < step * (1.0 - 1e-9):
            found = f"{exact(most)} s is shorter than the step of {exact(step)} s"
            yield Problem(found, f"accepted: {exact(step)} s or more, or a shorter horizon.step_s", (key,))


COMPONENT = Component(Parameters, build, noisy=True, neutral=(zero("probability", "mean_interval_s"),), coarse=coarse)
