"""Update rate of the measurement: new at its instants, the last measurement in between.

    new at t₀ + j T,   j = 0, 1, …        T: period, t₀: phase

The instants are those of the nearest steps. Before the first instant the measurement is that at t = 0. In between it is held, or
propagated without forces (`between`): ρ̇ = ν − Ω×ρ, ν̇ = −Ω×ν, σ̇ = G(σ) ω with the last ν and ω, or with those that are still
measured. `of` says which quantities it concerns: a camera gives position, velocity and attitude once a second, the gyros go on.
Errors listed before it act on the measurement at its instants and are held with it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, Self

import jax.numpy as jnp
from pydantic import model_validator

from rvjax.campaign import Quantity, Spec, number, scalar
from rvjax.campaign.horizon import not_whole
from rvjax.campaign.plain_values import exact
from rvjax.campaign.problems import Problem, refuse
from rvjax.components.navigation.interface import NavigationError
from rvjax.components.navigation.last_measurement import Interrupted, Last, LastMeasurement, age
from rvjax.components.registry import Component
from rvjax.physics.state import Motion, Numbers, Tick
from rvjax.physics.vectors import Scalar


class Parameters(Interrupted):
    """Period and phase."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = (
        {"period_s": 1, "of": ["position", "velocity", "attitude"], "between": "propagate"},
    )

    period_s: float = number("s", above=0.0, doc="period T, a whole number of steps")
    phase_s: Quantity = scalar("s", default=0.0, at_least=0.0, doc="time t₀ of the first instant, below the period")

    @model_validator(mode="after")
    def _within_a_period(self) -> Self:
        if (latest := self.phase_s.supports[0][1]) > self.period_s or self.phase_s.supports[0][0] == self.period_s:
            found = f"a phase of up to {exact(latest)} s is longer than the period of {exact(self.period_s)} s"
            refuse(Problem(found, f"accepted: below {exact(self.period_s)} s", ("phase_s",)))
        return self


def build(parameters: Parameters) -> NavigationError:
    """The measurement with its period."""
    last, period = LastMeasurement.of(parameters), parameters.period_s

    def start(motion: Motion, numbers: Numbers) -> Last:
        return last.first(motion, numbers)

    def keep(tick: Tick, motion: Motion, memory: Last, numbers: Numbers) -> Last:
        steps, since = jnp.round(period / tick.h), tick.k - numbers.phase_s / tick.h
        new = jnp.floor((since + 0.5) / steps) > jnp.floor((since - 0.5) / steps)
        return last.renewed(new, tick, motion, memory, numbers)

    def see(t: Scalar, motion: Motion, memory: Last, numbers: Numbers) -> Motion:
        del numbers
        return last.seen(t, motion, memory)

    return NavigationError(see, start, keep, informed=last.propagated, age=age)


def unfit(parameters: Parameters, spec: Spec) -> Iterator[Problem]:
    """A period that is not a whole number of steps."""
    if wrong := not_whole(parameters.period_s, spec.horizon.step_s):
        yield wrong.below(("period_s",))


def coarse(parameters: Parameters, spec: Spec) -> Iterator[Problem]:
    """A period of one step, and a first instant after the end."""
    if round(parameters.period_s / spec.horizon.step_s) == 1:
        found = f"a period of {exact(parameters.period_s)} s is one step: the measurement is new in every step"
        yield Problem(found, "accepted: a longer period, or a shorter horizon.step_s", ("period_s",))
    if parameters.period_s >= spec.horizon.duration_s:
        found = f"a period of {exact(parameters.period_s)} s is not shorter than the flight: it has one measurement"
        yield Problem(found, f"accepted: below {exact(spec.horizon.duration_s)} s", ("period_s",))


COMPONENT = Component(Parameters, build, unfit=unfit, coarse=coarse)
