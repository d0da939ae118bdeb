"""Delay line: a delay by whole steps.

    y(t) = x(t_{k−n})       for t in step k

t_k: beginning of step k; n: delay in steps. The line holds x at the beginnings of step k and of the n steps before it, the latest
first. Before the first step it holds the initial value.
"""

from __future__ import annotations

from typing import TypeVar

T = TypeVar("T")

MOST_STEPS = 64
"""Largest delay. Every sample carries n + 1 values through the flight."""


def filled(steps: int, initial: T) -> tuple[T, ...]:
    """The line of a delay of `steps` before the first step."""
    return (initial,) * (steps + 1)


def pushed(line: tuple[T, ...], value: T) -> tuple[T, ...]:
    """The line with the value of this step; the oldest value leaves it."""
    return (value, *line[:-1])


def delayed(line: tuple[T, ...]) -> T:
    """The oldest value, x(t_{k−n})."""
    return line[-1]
