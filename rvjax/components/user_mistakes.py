"""What an error of a user's code means, and what would be accepted instead."""

from __future__ import annotations

import builtins
from collections.abc import Iterator
from contextlib import contextmanager
from difflib import get_close_matches
from typing import Any

CONDITION = "accepted: jnp.where(condition, a, b), or jax.lax.cond; all samples fly through the same program"
_TRACED: tuple[tuple[str, str, str], ...] = (
    ("TracerBoolConversionError", "a Python if, while, and, or or not on a number of the flight", CONDITION),
    ("TracerIntegerConversionError", "a number of the flight as an index or a count", "accepted: jnp.take, or a fixed number"),
    ("TracerArrayConversionError", "NumPy on a number of the flight", "accepted: the same function of jax.numpy (jnp)"),
    ("UnexpectedTracerError", "a number of the flight was kept outside of the function", "accepted: a pure function"),
    ("NonConcreteBooleanIndexError", "indexing with a condition", CONDITION),
    ("ConcretizationTypeError", "float(), int() or another conversion of a number of the flight", "accepted: the number itself"),
)
"""Errors of JAX, the most special first: name of the class, what it means, what to write."""


class UserMistake(Exception):
    """What a user's component gives is not accepted. function: of the user, which gave it."""

    def __init__(self, found: str, accepted: str) -> None:
        super().__init__(found)
        self.found, self.accepted, self.function = found, accepted, None


@contextmanager
def given_by(function: Any) -> Iterator[None]:
    """Errors in here are those of this function of the user, or of what it gives."""
    try:
        yield
    except Exception as error:
        if getattr(error, "function", None) is None:
            error.function = function  # pyright: ignore[reportAttributeAccessIssue]
        raise


def words_of(error: BaseException) -> tuple[str, str]:
    """(what was found, what is accepted) of an error."""
    if isinstance(error, UserMistake):
        return error.found, error.accepted
    kinds = [kind.__name__ for kind in type(error).__mro__]
    for name, found, accepted in _TRACED:
        if name in kinds:
            return found, accepted
    if "converted to a scalar index" in str(error):
        return _TRACED[1][1:]
    text = next((line.strip() for line in str(error).splitlines() if line.strip()), "")
    if isinstance(error, SyntaxError):
        return f"syntax error: {error.msg}", "accepted: Python"
    if isinstance(error, AttributeError) and error.name and _names(error.obj):
        near = get_close_matches(error.name, _names(error.obj), n=1)
        known = f"did you mean {near[0]}?" if near else f"accepted: {', '.join(_names(error.obj))}"
        return f"there is no {error.name} here", known
    if isinstance(error, NameError) and error.name:
        near = get_close_matches(error.name, dir(builtins), n=1)
        return f"NameError: {text}", f"did you mean {near[0]}?" if near else ""
    if isinstance(error, SystemExit):
        return "the file ends the program", "accepted: definitions only"
    return f"{type(error).__name__}: {text}" if text else type(error).__name__, ""


def _names(thing: Any) -> list[str]:
    """The names that a value of the flight has, such as the gains of a campaign."""
    names = getattr(thing, "NAMES", None) or (list(thing) if type(thing).__name__ == "Numbers" else getattr(thing, "_fields", ()))
    return list(names)
