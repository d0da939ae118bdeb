"""What a navigation error is: functions of one sample at one instant."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from rvjax.algebra import Scalar
from rvjax.state import Motion, Numbers, Tick


class Instrument(NamedTuple):
    """see(t, motion, memory, numbers) → the motion as it is measured.

    start(motion, numbers) → memory before the first step. keep(tick, motion, memory, numbers) → memory of the step that begins
    with the tick; motion: the true one at that instant. The memory of a step is held during it.
    """

    see: Callable[[Scalar, Motion, Any, Numbers], Motion]
    start: Callable[[Motion, Numbers], Any] = lambda motion, numbers: ()
    keep: Callable[[Tick, Motion, Any, Numbers], Any] = lambda tick, motion, memory, numbers: memory
