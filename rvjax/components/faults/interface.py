"""Interface of a fault, and the parameters of every fault: channels, onset, duration, samples.

    u = failed(h, t − t_f)    while the fault acts
    u = h                     before its onset t_f and after its end: exactly, bit for bit

A fault acts from t_f to t_f + d, or permanently without a duration d. An intermittent fault acts during the first share `duty`
of every period.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Annotated, Any, ClassVar, NamedTuple, Self

import jax.numpy as jnp
from pydantic import BeforeValidator, WithJsonSchema, model_validator

from rvjax.campaign import Model, Quantity, channels, option, part
from rvjax.campaign.problems import Problem, refuse
from rvjax.campaign.schedule import LIST_OF_CHANNELS, Schedule, channel_names
from rvjax.physics.state import Numbers, Tick
from rvjax.physics.vectors import Channels, Scalar, each

Failed = Callable[[Channels, Channels, Any, Channels, Numbers], Channels]
"""(u, time since the onset [s], memory, true upper limits, numbers) → output u while the fault acts [N, N·m]."""


class Fault(NamedTuple):
    """act(t, u, memory, upper, numbers) → output u of the fault; upper: true upper limits of the actuators [N, N·m].

    start(u, numbers) → memory before the first step; u = 0. keep(tick, u, memory, numbers) → memory of the step that begins at
    the tick; u: input of the fault at that instant. The memory is held during the step.
    """

    act: Callable[[Scalar, Channels, Any, Channels, Numbers], Channels]
    start: Callable[[Channels, Numbers], Any] = lambda u, numbers: ()
    keep: Callable[[Tick, Channels, Any, Numbers], Any] = lambda tick, u, memory, numbers: memory


def since(t: Scalar, numbers: Numbers) -> Channels:
    """max(t − t_f, 0) per channel [s]; 0 where the fault never begins."""
    return each(lambda onset: jnp.maximum(t - onset, 0.0), numbers.onset_s)


def acts(t: Scalar, numbers: Numbers) -> Channels:
    """Whether the fault acts, per channel: t_f ≤ t < t_f + d, and (t − t_f) mod period < duty · period."""
    on = each(lambda onset: t >= onset, numbers.onset_s)
    if "duration_s" in numbers:
        on = each(lambda a, onset, d: a & (t < onset + d), on, numbers.onset_s, numbers.duration_s)
    if "period_s" in numbers:
        turns = each(lambda s, period: s / period, since(t, numbers), numbers.period_s)
        on = each(lambda a, x, duty: a & (x - jnp.floor(x) < duty), on, turns, numbers.duty)
    return on


def fault(failed: Failed) -> Fault:
    """A fault without memory."""

    def act(t: Scalar, u: Channels, memory: Any, upper: Channels, numbers: Numbers) -> Channels:
        return each(jnp.where, acts(t, numbers), failed(u, since(t, numbers), memory, upper, numbers), u)

    return Fault(act)


class FaultParameters(Model):
    """Time, channels and samples of a fault."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = (
        {"onset_s": {"uniform": [30, 90]}},
        {"onset_s": 60, "duration_s": 30},
        {"onset_s": 60, "period_s": 20, "duty": 0.5},
    )

    onset_s: Quantity = channels("s", at_least=0.0, doc="time t_f at which the fault begins")
    duration_s: Quantity | None = channels("s", default=None, above=0.0, doc="duration d; null: permanent")
    period_s: Quantity | None = channels("s", default=None, above=0.0, doc="period of an intermittent fault")
    duty: Quantity | None = channels(
        "1", default=None, above=0.0, at_most=1.0, doc="share of the period during which an intermittent fault acts"
    )
    channels: Annotated[
        tuple[str, ...], BeforeValidator(channel_names), WithJsonSchema({"anyOf": [{"const": "all"}, LIST_OF_CHANNELS]})
    ] = option(default="all", example=["fx", "ty"], doc="channels that may fail: all, or a list")
    schedule: Schedule | None = part(default=None, doc="which of these channels fail in a sample; null: all")

    @model_validator(mode="after")
    def _intermittent(self) -> Self:
        missing = [key for key in ("period_s", "duty") if getattr(self, key) is None]
        if len(missing) == 1:
            refuse(Problem("missing", "accepted: period_s and duty, both or neither", (missing[0],), at_key=True))
        return self
