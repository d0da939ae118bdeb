"""The user's fault: what the actuators give while it acts, on plain arrays.

    u = failed(u_in, since, numbers)     from its onset to its end;     u = u_in otherwise, bit for bit

u_in: what the fault gets, the six channels or the thrusts; since: time since the onset.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import jax.numpy as jnp

from rvjax.components.faults import interface
from rvjax.components.faults.interface import FaultParameters, acts, since
from rvjax.components.forms import arrays
from rvjax.components.forms.called import begun, following
from rvjax.components.forms.form import check_form, check_memory
from rvjax.components.registry import Component
from rvjax.components.user_mistakes import given_by
from rvjax.physics.state import Numbers, Tick
from rvjax.physics.vectors import Channels, Scalar, each


@dataclass(frozen=True)
class Fault:
    """A fault. Onset, duration, channels and samples are those of every fault, from `FaultParameters`.

    parameters: a class that inherits from `FaultParameters`; a number per channel is declared with `channels`.
    failed(wrench, since, numbers) → output while the fault acts. wrench: its input, the six channels [N, N·m] or the thrust of
    each thruster [N]; since: time since the onset, per channel [s]; numbers: of its parameters, and `limit`, the true upper
    limits. With a memory, failed(wrench, since, memory, numbers).
    start(wrench, numbers) → memory before the first step; keep(wrench, memory, numbers) → memory of a step, from the input at
    its start. Both or neither.
    """

    parameters: type[FaultParameters]
    failed: Callable[..., Any] | None = None
    start: Callable[..., Any] | None = None
    keep: Callable[..., Any] | None = None

    family = "faults"

    def __post_init__(self) -> None:
        check_form(self, functions=("failed",), maybe=("start", "keep"), model=self.parameters)
        if not issubclass(self.parameters, FaultParameters):
            raise TypeError(
                "Fault: its parameters need onset_s and channels; accepted: a class that inherits from FaultParameters"
            )
        check_memory(self)

    @cached_property
    def component(self) -> Component[Any]:
        """The component of the registry."""
        return Component(self.parameters, self._build)

    def _build(self, parameters: FaultParameters) -> interface.Fault:
        del parameters
        if self.keep is None:
            return interface.Fault(self._act)
        return interface.Fault(self._act, self._start, self._keep)

    def _act(self, t: Scalar, u: Channels, memory: Any, upper: Channels, numbers: Numbers) -> Channels:
        assert self.failed is not None
        own = arrays.arrays(Numbers({**numbers, "limit": upper}))
        given = (arrays.array(u), arrays.array(since(t, numbers)), *(() if self.keep is None else (memory,)), own)
        with given_by(self.failed):
            output = arrays.like(u, self.failed(*given), f"the output of {self.failed.__name__}")
        return each(jnp.where, acts(t, numbers), output, u)

    def _start(self, u: Channels, numbers: Numbers) -> Any:
        return begun(self.start, "the memory", arrays.array(u), arrays.arrays(numbers))

    def _keep(self, tick: Tick, u: Channels, memory: Any, numbers: Numbers) -> Any:
        del tick
        return following(self.keep, memory, "the memory", arrays.array(u), memory, arrays.arrays(numbers))
