"""Programs of JAX that stand inside of an equation: of a call, a branch or a loop."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any


def inside(equation: Any) -> list[Any]:
    """The jaxprs among the parameters of an equation."""
    return _jaxprs(equation.params.values())


def _jaxprs(values: Iterable[Any]) -> list[Any]:
    found: list[Any] = []
    for value in values:
        if isinstance(value, (tuple, list)):
            found += _jaxprs(value)
        elif hasattr(value, "eqns") or hasattr(value, "jaxpr"):
            found.append(getattr(value, "jaxpr", value))
    return found
