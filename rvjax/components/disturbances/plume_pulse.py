"""Plume of a thruster on the pursuer: pulses of force and torque, fixed in P.

    d(t) = a (f, τ) [S(x) − S(x − w/e)],   x = ((t − t₁) mod T)/e for t ≥ t₁
    S(x) = x³(10 − 15x + 6x²) for 0 ≤ x ≤ 1,   0 before, 1 after

A pulse rises from t₁ within the edge time e, falls from t₁ + w within e, and has the impulse a w (f, τ) for any e. The next pulse
begins a period T later. S has two continuous derivatives, so RK4 keeps its order of 4. If the edge is much shorter than a step h,
only some stages sample it, and the impulse of a pulse is wrong by up to ⅔ h a (f, τ). A force along a drawn direction:
`force_N: {direction: 0.5}`, with its size drawn by `strength`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Self

import jax.numpy as jnp
from pydantic import model_validator

from rvjax.campaign import Model, Quantity, scalar, vector
from rvjax.campaign.plain_values import exact
from rvjax.campaign.problems import Problem, refuse
from rvjax.components.disturbances.interface import Disturbance
from rvjax.components.effect import zero
from rvjax.components.registry import Component
from rvjax.components.wrench_over_time import pulse_problem, pulse_warnings
from rvjax.physics.dynamics import Relative
from rvjax.physics.state import Numbers, Plant, State
from rvjax.physics.vectors import Channels, Scalar


class Parameters(Model):
    """Size, direction, length and period of the pulses."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = (
        {"force_N": [0.1, 0, 0], "first_s": 30, "width_s": 2},
        {"force_N": [0.1, 0, 0], "first_s": 30, "width_s": 2, "period_s": 20},
    )

    force_N: Quantity = vector("N", default=0.0, doc="peak force f of a pulse")
    torque_Nm: Quantity = vector("N·m", default=0.0, doc="peak torque τ of a pulse")
    strength: Quantity = scalar("1", default=1.0, doc="factor a on force and torque")
    first_s: Quantity = scalar("s", at_least=0.0, doc="time t₁ at which the first pulse begins")
    width_s: Quantity = scalar("s", above=0.0, doc="length w of a pulse at half height")
    edge_s: Quantity = scalar("s", default=0.25, above=0.0, doc="rise and fall time e of a pulse; use several steps")
    period_s: Quantity | None = scalar("s", default=None, above=0.0, doc="period T of the pulses; null: a single pulse")

    @model_validator(mode="after")
    def _apart(self) -> Self:
        if self.period_s is not None:
            longest, (least, _) = self.width_s.supports[0][1] + self.edge_s.supports[0][1], self.period_s.supports[0]
            if longest > least:
                words = f"a period of {exact(least)} s is shorter than a pulse of up to {exact(longest)} s, edge included"
                refuse(Problem(words, f"accepted: at least {exact(longest)} s in every draw", ("period_s",)))
        return self


def push(t: Scalar, y: State, known: Relative, plant: Plant, memory: tuple[()], numbers: Numbers) -> Channels:
    """a (f, τ) [S(x) − S(x − w/e)]."""
    del y, known, plant, memory
    since = t - numbers.first_s
    if "period_s" in numbers:
        turns = jnp.maximum(jnp.floor(since / numbers.period_s), 0.0)
        since = since - turns * numbers.period_s
    height = rising(since / numbers.edge_s) - rising((since - numbers.width_s) / numbers.edge_s)
    return Channels(numbers.force_N, numbers.torque_Nm) * (numbers.strength * height)


def rising(x: Scalar) -> Scalar:
    """S(x)."""
    inside = jnp.clip(x, 0.0, 1.0)
    return inside * inside * inside * (10.0 + inside * (6.0 * inside - 15.0))


COMPONENT = Component(
    Parameters,
    lambda parameters: Disturbance(push),
    neutral=(zero("force_N", "torque_Nm"), zero("strength")),
    silent=pulse_problem,
    coarse=pulse_warnings,
)
