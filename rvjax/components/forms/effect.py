"""The user's effect: what moves in or on the pursuer and acts on it, on plain arrays."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

from rvjax.campaign import Model
from rvjax.components.effects import interface
from rvjax.components.forms import arrays
from rvjax.components.forms.called import Wrench, begun, following, wrench
from rvjax.components.forms.form import check_form
from rvjax.components.forms.signal import Signal, columns
from rvjax.components.registry import Component
from rvjax.components.user_mistakes import given_by
from rvjax.physics.state import Numbers
from rvjax.physics.vectors import Channels, Vector


class Body(NamedTuple):
    """The pursuer at an instant, as arrays, in P.

    t: time [s]. rate: inertial angular velocity Ω [rad/s]. mass [kg]; inertia: (3, 3), about the centre of mass [kg·m²].
    free_accel, free_alpha: acceleration of the centre of mass [m/s²] and angular acceleration [rad/s²] under the applied wrench
    and the disturbances, without gravity. accel, alpha: under all wrenches, those of the effects too; only `rate` gets them,
    `wrench` gets zeros.
    """

    t: Any
    rate: Any
    mass: Any
    inertia: Any
    free_accel: Any
    free_alpha: Any
    accel: Any
    alpha: Any


@dataclass(frozen=True)
class Effect:
    """An effect with a continuous state. pursuer.mass_kg and its inertia do not contain what it moves.

    parameters: the model of its numbers. start(numbers) → state at t = 0, any tree of numbers and arrays.
    wrench(body, state, numbers) → `Wrench` on the pursuer's centre of mass. rate(body, state, numbers) → rate of the state.
    signals: unit and meaning of values for the trace; record(body, state, numbers) gives them.
    """

    parameters: type[Model]
    start: Callable[..., Any] | None = None
    wrench: Callable[..., Wrench] | None = None
    rate: Callable[..., Any] | None = None
    record: Callable[..., Mapping[str, Any]] | None = None
    signals: Mapping[str, Signal] | None = None

    family = "effects"

    def __post_init__(self) -> None:
        check_form(self, functions=("start", "wrench", "rate"), maybe=("record",), model=self.parameters)

    @cached_property
    def component(self) -> Component[Any]:
        """The component of the registry."""
        return Component(self.parameters, self._build)

    def _build(self, parameters: Model) -> interface.Effect:
        del parameters
        return interface.Effect(self._start, self._wrench, self._rate, self._record, columns(self.signals))

    def _start(self, numbers: Numbers) -> Any:
        return begun(self.start, "the state", arrays.arrays(numbers))

    def _wrench(self, body: interface.Body, x: Any, numbers: Numbers) -> Channels:
        still = body.free_accel * 0.0
        return wrench(self.wrench, _body(body, still, still), x, arrays.arrays(numbers))

    def _rate(self, body: interface.Body, accel: Vector, alpha: Vector, x: Any, numbers: Numbers) -> Any:
        return following(self.rate, x, "the result", _body(body, accel, alpha), x, arrays.arrays(numbers))

    def _record(self, body: interface.Body, x: Any, numbers: Numbers) -> Mapping[str, Any]:
        if self.record is None:
            return {}
        still = body.free_accel * 0.0
        with given_by(self.record):
            given = self.record(_body(body, still, still), x, arrays.arrays(numbers))
            return arrays.signals(given, self.signals, f"the signals of {self.record.__name__}")


def _body(body: interface.Body, accel: Vector, alpha: Vector) -> Body:
    values = (body.rate, body.mass, body.inertia, body.free_accel, body.free_alpha, accel, alpha)
    seen: list[Any] = [body.t, *map(arrays.array, values)]
    return Body(*seen)
