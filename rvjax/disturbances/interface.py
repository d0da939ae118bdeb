"""What a disturbance is: functions of one sample at one instant."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from rvjax.algebra import Channels, Scalar
from rvjax.dynamics import Relative
from rvjax.state import Numbers, Plant, State, Tick


class Disturbance(NamedTuple):
    """push(t, y, relative geometry, plant, memory, numbers) → disturbance wrench on the pursuer's centre of mass, in P [N, N·m].

    start(numbers) → memory before the first step. keep(tick, y, memory, numbers) → memory of the step that begins with the tick;
    y: the state at that instant. The memory of a step is held during it.
    """

    push: Callable[[Scalar, State, Relative, Plant, Any, Numbers], Channels]
    start: Callable[[Numbers], Any] = lambda numbers: ()
    keep: Callable[[Tick, State, Any, Numbers], Any] = lambda tick, y, memory, numbers: memory
