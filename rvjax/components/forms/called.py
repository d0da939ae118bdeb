"""Calls of a user's functions whose result is checked: an error, or a wrong result, is that of the function.

Each function of this module takes a function of the user and its arguments, and gives the result in the form of this package.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from rvjax.components.forms import arrays
from rvjax.components.user_mistakes import UserMistake, given_by
from rvjax.physics.vectors import Channels


class Wrench(NamedTuple):
    """force [N] and torque [N·m] on the pursuer's centre of mass, in P, each of shape (3,)."""

    force: Any
    torque: Any


def begun(function: Callable[..., Any] | None, what: str, *arguments: Any) -> Any:
    """The first state or memory. what: its name in messages."""
    assert function is not None
    with given_by(function):
        return arrays.state(function(*arguments), f"{what} of {function.__name__}")


def following(function: Callable[..., Any] | None, before: Any, what: str, *arguments: Any) -> Any:
    """A state, memory or rate in the structure of the one before. what: its name in messages."""
    assert function is not None
    with given_by(function):
        return arrays.tree_like(before, function(*arguments), f"{what} of {function.__name__}")


def wrench(function: Callable[..., Wrench] | None, *arguments: Any) -> Channels:
    """A force and a torque."""
    assert function is not None
    name = function.__name__
    with given_by(function):
        given = function(*arguments)
        if not isinstance(given, Wrench):
            raise UserMistake(f"{name} returns {arrays.kind(given)}", "accepted: Wrench(force=…, torque=…)")
        force, torque = (arrays.vector(part, f"the {what} of {name}") for what, part in given._asdict().items())
    return Channels(force, torque)
