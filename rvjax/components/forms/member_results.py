"""What the functions of a controller must give that a user's file writes as the members of this package are written.

    COMPONENT = Component(Parameters, build),   build(parameters) → `interface.Controller` or `interface.DiscreteController`

The forms of `rvjax.components.forms` check their results themselves; the members of this package are tested and fly unchecked.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from rvjax.components.controllers.interface import Controller, DiscreteController, Response, Saturate
from rvjax.components.forms import arrays
from rvjax.components.user_mistakes import UserMistake, given_by
from rvjax.physics.state import Measurement, Numbers, Report
from rvjax.physics.vectors import Channels, Vector

RESPONSE = "accepted: Response(command, rate, report)"
UPDATED = "accepted: (command, new state, report)"


def checked(built: Any) -> Any:
    """The controller, whose functions raise UserMistake where a result is wrong; anything else is not changed."""
    if isinstance(built, Controller):
        return built._replace(start=_start(built.start), respond=_respond(built.respond, built.signals))
    if isinstance(built, DiscreteController):
        return built._replace(start=_start(built.start), update=_update(built.update, built.signals))
    return built


def _start(function: Callable[..., Any]) -> Callable[[Measurement, Numbers], Any]:
    plain = _plain(function)

    def start(measurement: Measurement, gains: Numbers) -> Any:
        with given_by(plain):
            state = function(measurement, gains)
            arrays.state(state, f"the state of {plain.__name__}")
        return state

    return start


def _respond(function: Callable[..., Any], signals: Mapping[str, Any]) -> Callable[..., Response]:
    plain = _plain(function)

    def respond(measurement: Measurement, state: Any, saturate: Saturate, gains: Numbers) -> Response:
        with given_by(plain):
            given, name = function(measurement, state, saturate, gains), plain.__name__
            if not isinstance(given, Response):
                raise UserMistake(f"{name} returns {arrays.kind(given)}", RESPONSE)
            _check_channels(given.command, f"the command of {name}")
            arrays.tree_like(state, given.rate, f"the rate of {name}")
            _check_report(given.report, name, signals)
        return given

    return respond


def _update(function: Callable[..., Any], signals: Mapping[str, Any]) -> Callable[..., tuple[Channels, Any, Report]]:
    plain = _plain(function)

    def update(measurement: Measurement, state: Any, saturate: Saturate, gains: Numbers) -> tuple[Channels, Any, Report]:
        with given_by(plain):
            given, name = function(measurement, state, saturate, gains), plain.__name__
            if type(given) is not tuple or len(given) != 3:
                raise UserMistake(f"{name} returns {arrays.kind(given)}", UPDATED)
            command, new, report = given
            _check_channels(command, f"the command of {name}")
            arrays.tree_like(state, new, f"the new state of {name}")
            _check_report(report, name, signals)
        return command, new, report

    return update


def _check_channels(value: Any, what: str) -> None:
    if not isinstance(value, Channels):
        raise UserMistake(f"{what} is {arrays.kind(value)}", "accepted: Channels(force, torque)")
    for part, vector in (("force", value.force), ("torque", value.torque)):
        if not isinstance(vector, Vector):
            raise UserMistake(f"the {part} of {what} is {arrays.kind(vector)}", "accepted: a Vector")
        for axis, component in zip("xyz", vector.parts(), strict=True):
            arrays.number(component, f"the {part} of {what}, {axis}")


def _check_report(report: Any, name: str, signals: Mapping[str, Any]) -> None:
    """signals: those that the controller declares; without any, it says nothing about them."""
    if not isinstance(report, Report):
        raise UserMistake(f"the report of {name} is {arrays.kind(report)}", "accepted: Report(chi, drift, signals)")
    _check_channels(report.chi, f"chi in the report of {name}")
    arrays.number(report.drift, f"drift in the report of {name}")
    arrays.signals(report.signals, signals or None, f"the signals of {name}")


def _plain(function: Any) -> Any:
    """The user's function, also where it was given some of its arguments."""
    return function.func if isinstance(function, partial) else function
