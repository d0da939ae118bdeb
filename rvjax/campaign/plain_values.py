"""The plain values that a campaign is made of, the places where they stand, and their descriptions in messages."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeGuard

Place = tuple[str | int, ...]
"""Keys and list indices from the top of the file to a value."""


def dotted(place: Place) -> str:
    """("faults", 0, "onset_s") → `faults.0.onset_s`, as in `--set`."""
    return ".".join(map(str, place))


def is_number(value: object) -> TypeGuard[int | float]:
    """Whether a value is a number; true and false are not."""
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def is_list(value: object) -> TypeGuard[list[Any]]:
    """Whether a value is a list."""
    return isinstance(value, list)


def is_mapping(value: object) -> TypeGuard[dict[str, Any]]:
    """Whether a value is a mapping; its keys are text."""
    return isinstance(value, dict)


def describe(value: object) -> str:
    """A value in words, for messages: `the text 'yes'`, `a list of 2`, `nothing`."""
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return f"the text {shorten(value)!r}"
    if is_list(value):
        return f"a list of {len(value)}"
    if is_mapping(value):
        return f"a mapping with {', '.join(shorten(key) for key in list(value)[:3]) or 'nothing in it'}"
    return str(value)


def exact(value: float) -> str:
    """A number with the digits that give the same number when it is read again, and no more: 60, 0.1, 1e-05."""
    return repr(float(value)).removesuffix(".0") if isinstance(value, float) else str(value)


def shortest(value: float, accepted: Callable[[float], bool]) -> str:
    """The number with the fewest digits that is near `value` and accepted; with all digits where no shorter number is."""
    for digits in range(1, 17):
        rounded = float(f"{value:.{digits}g}")
        if accepted(rounded):
            return exact(rounded)
    return exact(float(value))


def shorten(text: str, most: int = 40) -> str:
    """The first `most` characters of a user's text, for a message."""
    return text if len(text) <= most else f"{text[: most - 1]}…"
