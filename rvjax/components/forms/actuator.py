"""The user's actuator: what a channel or thruster gives for a command, on plain arrays."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

from rvjax.campaign import Model
from rvjax.components.actuators import interface
from rvjax.components.actuators.interface import Limits
from rvjax.components.forms import arrays
from rvjax.components.forms.called import begun, following
from rvjax.components.forms.form import check_form, check_memory
from rvjax.components.registry import Component
from rvjax.components.user_mistakes import given_by
from rvjax.physics.state import Numbers, Tick
from rvjax.physics.vectors import Channels, Scalar


class Clock(NamedTuple):
    """The beginning of a step. t: its time [s]; k: its number; step_s: its length [s]."""

    t: Any
    k: Any
    step_s: Any


@dataclass(frozen=True)
class Actuator:
    """An actuator, between the commanded wrench or thrusts and the faults.

    parameters: the model of its numbers. drive(command, numbers) → output; command: the six channels [N, N·m] or the thrust of
    each thruster [N]; numbers: of its parameters, and `upper`, `lower`, the true magnitudes of the limits.
    With a memory drive(command, memory, numbers), start(command, numbers) → memory before the first step, and
    keep(command, memory, clock, numbers) → memory of the step that begins; both or neither. The memory is held during a step.
    """

    parameters: type[Model]
    drive: Callable[..., Any] | None = None
    start: Callable[..., Any] | None = None
    keep: Callable[..., Any] | None = None

    family = "actuators"

    def __post_init__(self) -> None:
        check_form(self, functions=("drive",), maybe=("start", "keep"), model=self.parameters)
        check_memory(self)

    @cached_property
    def component(self) -> Component[Any]:
        """The component of the registry."""
        return Component(self.parameters, self._build)

    def _build(self, parameters: Model) -> interface.Actuator:
        del parameters
        return interface.Actuator(self._act) if self.keep is None else interface.Actuator(self._act, self._start, self._keep)

    def _act(self, t: Scalar, u: Channels, memory: Any, limits: Limits, numbers: Numbers) -> Channels:
        assert self.drive is not None
        del t
        with given_by(self.drive):
            output = self.drive(arrays.array(u), *(() if self.keep is None else (memory,)), _with(numbers, limits))
            return arrays.like(u, output, f"the output of {self.drive.__name__}")

    def _start(self, u: Channels, numbers: Numbers) -> Any:
        return begun(self.start, "the memory", arrays.array(u), arrays.arrays(numbers))

    def _keep(self, tick: Tick, u: Channels, memory: Any, limits: Limits, numbers: Numbers) -> Any:
        clock = Clock(tick.t, tick.k, tick.h)
        return following(self.keep, memory, "the memory", arrays.array(u), memory, clock, _with(numbers, limits))


def _with(numbers: Numbers, limits: Limits) -> Numbers:
    return arrays.arrays(Numbers({**numbers, **limits._asdict()}))
