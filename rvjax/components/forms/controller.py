"""The user's continuous controller: functions of the measurement, on plain arrays.

    x_c(0) = start(measured, gains),   (force, torque, ẋ_c) = respond(measured, x_c, gains)

x_c: the state of the controller, which is integrated with the flight.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

from pydantic import create_model

from rvjax.campaign import Model, part
from rvjax.components.controllers import interface
from rvjax.components.forms import arrays
from rvjax.components.forms.called import begun
from rvjax.components.forms.form import check_form
from rvjax.components.forms.measured import Measured
from rvjax.components.forms.signal import Signal, columns
from rvjax.components.registry import Component
from rvjax.components.user_mistakes import UserMistake, given_by
from rvjax.physics.state import Measurement, Numbers, Report
from rvjax.physics.vectors import Channels


class Command(NamedTuple):
    """force [N] and torque [N·m] on the pursuer before the saturation, in P, each of shape (3,).

    rate: of the controller's state, of the same structure; () without a state. signals: further values for the trace, by name,
    of shape (), (3,), (6,) or (3, 3).
    """

    force: Any
    torque: Any
    rate: Any = ()
    signals: Mapping[str, Any] = {}


@dataclass(frozen=True)
class Controller:
    """A controller that acts continuously; with `horizon.control_period_s` it is sampled.

    gains: the model of its gains. start(measured, gains) → its state at t = 0, any tree of numbers and arrays; None without a
    state. respond(measured, state, gains) → `Command`. signals: unit and meaning of each signal; None: not said.
    vectors: the functions get and give `Vector`s of this package instead of arrays of shape (3,).
    """

    gains: type[Model]
    start: Callable[..., Any] | None = None
    respond: Callable[..., Command] | None = None
    signals: Mapping[str, Signal] | None = None
    vectors: bool = False

    family = "controllers"

    def __post_init__(self) -> None:
        check_form(self, functions=("respond",), maybe=("start",), model=self.gains)

    @cached_property
    def component(self) -> Component[Any]:
        """The component of the registry."""
        return Component(with_gains(self.gains), self._build)

    def _build(self, parameters: Model) -> interface.Controller:
        del parameters
        return interface.Controller(self._start, self._respond, columns(self.signals))

    def _start(self, measurement: Measurement, gains: Numbers) -> Any:
        return started(self.start, Measured.of(measurement, unlimited, not self.vectors), self._numbers(gains))

    def _respond(self, measurement: Measurement, state: Any, saturate: interface.Saturate, gains: Numbers) -> interface.Response:
        assert self.respond is not None
        with given_by(self.respond):
            command = self.respond(Measured.of(measurement, saturate, not self.vectors), state, self._numbers(gains))
            wrench, signals = checked(command, self.respond.__name__, self.signals)
            rate = arrays.tree_like(state, command.rate, f"the rate of {self.respond.__name__}")
        return interface.Response(wrench, rate, report(wrench, signals))

    def _numbers(self, gains: Numbers) -> Numbers:
        return gains if self.vectors else arrays.arrays(gains)


def with_gains(gains: type[Model], **more: Any) -> type[Model]:
    """The parameters of a controller: its gains below the key `gains`, and more keys."""
    fields: dict[str, Any] = {"gains": (gains, part(default={}, doc="gains")), **more}
    return create_model("Parameters", __base__=Model, __module__=gains.__module__, __doc__=gains.__doc__, **fields)


def started(start: Callable[..., Any] | None, seen: Measured, gains: Numbers) -> Any:
    """The state at t = 0; () without `start`."""
    return () if start is None else begun(start, "the state", seen, gains)


def checked(command: Any, name: str, signals: Mapping[str, Signal] | None) -> tuple[Channels, dict[str, Any]]:
    """(wrench, signals) of a command. name: of the function that gave it."""
    if not isinstance(command, Command):
        raise UserMistake(f"{name} returns {arrays.kind(command)}", "accepted: Command(force=…, torque=…)")
    force = arrays.vector(command.force, f"the force of {name}")
    torque = arrays.vector(command.torque, f"the torque of {name}")
    return Channels(force, torque), arrays.signals(command.signals, signals, f"the signals of {name}")


def report(wrench: Channels, signals: Mapping[str, Any]) -> Report:
    """The report of a controller without Nussbaum gains and estimates."""
    nothing = wrench * 0.0
    return Report(nothing, nothing.force.x, signals)


def unlimited(command: Channels) -> tuple[Channels, Channels]:
    """The saturation before the flight: none."""
    return command, command * 0.0 + 1.0
