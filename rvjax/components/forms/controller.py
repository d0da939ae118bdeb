"""The user's controller: functions of the measurement, on plain arrays.

x_c(0) = start(measured, gains),   (force, torque, ẋ_c) = respond(measured, x_c, gains)          continuous
(force, torque), x_c⁺ = update(measured, x_c, gains)       at t = 0, T, 2T, …, held in between    discrete-time
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import jax.numpy as jnp
from pydantic import create_model

from rvjax.campaign import Model, number, part
from rvjax.components.controllers import interface
from rvjax.components.forms import arrays
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
class Measured:
    """What a controller measures at an instant, as arrays. Frames: P fixed in the pursuer, T fixed in the target.

    t: time [s]. rho: pursuer minus docking point, in P [m]. nu: difference of the inertial velocities, in P [m/s]. sigma:
    modified Rodrigues parameters of P with respect to T. omega: angular velocity of P relative to T, in P [rad/s]. target_r,
    target_v, target_w: inertial position [m], velocity [m/s] and angular velocity [rad/s] of the target, in T. target_alpha: its
    angular acceleration, in T [rad/s²]. port: docking point, in T [m]. upper, lower: nominal limits of the channels [N, N·m].
    exact: the same values as `Measurement`, for the functions of `rvjax.physics`.
    """

    t: Any
    rho: Any
    nu: Any
    sigma: Any
    omega: Any
    target_r: Any
    target_v: Any
    target_w: Any
    target_alpha: Any
    port: Any
    upper: Any
    lower: Any
    exact: Measurement
    saturate: interface.Saturate

    NAMES = ("t", "rho", "nu", "sigma", "omega", "target_r", "target_v", "target_w", "target_alpha", "port", "upper", "lower",
             "quaternion", "saturated")  # fmt: skip

    @classmethod
    def of(cls, measurement: Measurement, saturate: interface.Saturate, plain: bool) -> Measured:
        """The measurement; plain: as arrays."""
        form = arrays.array if plain else lambda value: value
        motion, target = measurement.motion, measurement.target
        known = (*motion, *target, measurement.alpha_t, measurement.port, measurement.upper, measurement.lower)
        values: list[Any] = [measurement.t, *map(form, known), measurement, saturate]
        return cls(*values)

    @property
    def quaternion(self) -> Any:
        """(w, x, y, z) of P with respect to T, w ≥ 0 where |σ| ≤ 1: ((1 − σᵀσ), 2σ)/(1 + σᵀσ)."""
        sigma = arrays.array(self.exact.motion.sigma)
        square = sigma @ sigma
        return jnp.concatenate([(1.0 - square)[None], 2.0 * sigma]) / (1.0 + square)

    def saturated(self, force: Any, torque: Any) -> Any:
        """(6,) what the actuators are told of a command, h(v), as the drive electronics report it [N, N·m]."""
        h, _ = self.saturate(Channels(arrays.vector(force, "the force"), arrays.vector(torque, "the torque")))
        return arrays.array(h)


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
        seen = Measured.of(measurement, _nothing, not self.vectors)
        return begun(self.start, seen, self._numbers(gains))

    def _respond(self, measurement: Measurement, state: Any, saturate: interface.Saturate, gains: Numbers) -> interface.Response:
        assert self.respond is not None
        with given_by(self.respond):
            command = self.respond(Measured.of(measurement, saturate, not self.vectors), state, self._numbers(gains))
            wrench, signals = checked(command, self.respond.__name__, self.signals)
            rate = arrays.tree_like(state, command.rate, f"the rate of {self.respond.__name__}")
        return interface.Response(wrench, rate, report(wrench, signals))

    def _numbers(self, gains: Numbers) -> Numbers:
        return gains if self.vectors else arrays.arrays(gains)


@dataclass(frozen=True)
class DiscreteController:
    """A discrete-time controller: it acts at the instants of its period, and its command is held in between.

    gains, start, signals, vectors: as of `Controller`. update(measured, state, gains) → (`Command`, new state); the command has
    no rate. period_s: default of the key `period_s` [s], a whole number of steps of the integration; None: the period is
    `horizon.control_period_s`.
    """

    gains: type[Model]
    start: Callable[..., Any] | None = None
    update: Callable[..., tuple[Command, Any]] | None = None
    signals: Mapping[str, Signal] | None = None
    vectors: bool = False
    period_s: float | None = None

    family = "controllers"

    def __post_init__(self) -> None:
        check_form(self, functions=("update",), maybe=("start",), model=self.gains)

    @cached_property
    def component(self) -> Component[Any]:
        """The component of the registry."""
        doc = "period of the controller, a whole number of steps; by default horizon.control_period_s"
        period = number("s", default=self.period_s, above=0.0, doc=doc)
        return Component(with_gains(self.gains, period_s=(float | None, period)), self._build)

    def _build(self, parameters: Any) -> interface.DiscreteController:
        return interface.DiscreteController(self._start, self._update, columns(self.signals), parameters.period_s)

    def _start(self, measurement: Measurement, gains: Numbers) -> Any:
        seen = Measured.of(measurement, _nothing, not self.vectors)
        return begun(self.start, seen, gains if self.vectors else arrays.arrays(gains))

    def _update(
        self, measurement: Measurement, state: Any, saturate: interface.Saturate, gains: Numbers
    ) -> tuple[Channels, Any, Report]:
        assert self.update is not None
        numbers = gains if self.vectors else arrays.arrays(gains)
        name = self.update.__name__
        with given_by(self.update):
            given = self.update(Measured.of(measurement, saturate, not self.vectors), state, numbers)
            if not isinstance(given, tuple) or isinstance(given, Command) or len(given) != 2:
                raise UserMistake(f"{name} returns {arrays.kind(given)}", "accepted: Command(…), new_state")
            wrench, signals = checked(given[0], name, self.signals)
            return wrench, arrays.tree_like(state, given[1], f"the new state of {name}"), report(wrench, signals)


def check_form(form: Any, functions: tuple[str, ...], maybe: tuple[str, ...], model: Any) -> None:
    """TypeError where a form does not have what it needs."""
    kind = type(form).__name__
    if not (isinstance(model, type) and issubclass(model, Model)):
        raise TypeError(f"{kind}: found {model!r} as its parameters; accepted: a class that inherits from Parameters")
    for name in (*functions, *maybe):
        given = getattr(form, name)
        if not callable(given) and not (given is None and name in maybe):
            found = "missing" if given is None else f"found {given!r}"
            raise TypeError(f"{kind}: {name} is {found}; accepted: a function")


def with_gains(gains: type[Model], **more: Any) -> type[Model]:
    """The parameters of a controller: its gains below the key `gains`, and more keys."""
    doc = gains.__doc__ if gains.__doc__ != Model.__doc__ else "gains"
    fields: dict[str, Any] = {"gains": (gains, part(default={}, doc="gains")), **more}
    return create_model("Parameters", __base__=Model, __module__=gains.__module__, __doc__=doc or "Gains.", **fields)


def begun(start: Callable[..., Any] | None, seen: Measured, gains: Numbers) -> Any:
    """The checked state at t = 0."""
    if start is None:
        return ()
    with given_by(start):
        return arrays.state(start(seen, gains), f"the state of {start.__name__}")


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


def _nothing(command: Channels) -> tuple[Channels, Channels]:
    """The saturation before the flight: none."""
    return command, command * 0.0 + 1.0
