"""Interface of an actuator: functions of a sample at an instant. A memory is updated at the start of a step and then held."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from rvjax.physics.state import Numbers, Tick
from rvjax.physics.vectors import Channels, Scalar


class Limits(NamedTuple):
    """upper, lower: true magnitudes of the limits, per channel [N, N·m] or per thruster [N]; a thruster's lower limit is 0."""

    upper: Any
    lower: Any


class Actuator(NamedTuple):
    """act(t, u, memory, limits, numbers) → output; u: its input at the time t, six channels or thrusts.

    start(u, numbers) → memory before the first step; u = 0. keep(tick, u, memory, limits, numbers) → memory of the step that
    begins at the tick; u: input at that instant.
    """

    act: Callable[[Scalar, Channels, Any, Limits, Numbers], Channels]
    start: Callable[[Channels, Numbers], Any] = lambda u, numbers: ()
    keep: Callable[[Tick, Channels, Any, Limits, Numbers], Any] = lambda tick, u, memory, limits, numbers: memory


class Output(NamedTuple):
    """Output u_k at the beginning t_k [s] of the step."""

    t: Scalar
    u: Channels


def at_rest(u: Channels, numbers: Numbers) -> Output:
    """No output before the first step."""
    del numbers
    return Output(u.parts()[0], u)
