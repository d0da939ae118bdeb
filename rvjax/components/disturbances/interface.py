"""Interface of a disturbance: functions of a sample at an instant."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import Any, NamedTuple

from rvjax.campaign import Quantity
from rvjax.campaign.distributions import Fixed
from rvjax.physics.dynamics import Relative
from rvjax.physics.state import Numbers, Plant, State, Tick
from rvjax.physics.vectors import Channels, Scalar


class Disturbance(NamedTuple):
    """push(t, y, relative geometry, plant, memory, numbers) → disturbance wrench on the pursuer's centre of mass, in P [N, N·m].

    start(numbers) → memory before the first step. keep(tick, y, memory, numbers) → memory of the step that begins at the tick;
    y: the state at that instant. The memory is held during the step.
    """

    push: Callable[[Scalar, State, Relative, Plant, Any, Numbers], Channels]
    start: Callable[[Numbers], Any] = lambda numbers: ()
    keep: Callable[[Tick, State, Any, Numbers], Any] = lambda tick, y, memory, numbers: memory


def without_silent(
    quantities: Iterable[tuple[str, Quantity]], force: Quantity, torque: Quantity
) -> Iterator[tuple[str, Quantity]]:
    """The quantities of a member, without draws of rate, phase or time constant for channels whose size is fixed at 0."""
    active = [part != Fixed(0.0) for size in (force, torque) for part in size.parts or (None,) * 3]
    for name, quantity in quantities:
        if quantity.shape == "channels":
            parts = zip(quantity.parts, active, strict=True)
            quantity = replace(quantity, parts=tuple(part if on else Fixed(1.0) for part, on in parts))
        yield name, quantity
