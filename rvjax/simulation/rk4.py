"""The classical Runge–Kutta method of order 4 (E. Hairer, S. Nørsett, G. Wanner, "Solving ODEs I", table II.1.2)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import jax

from rvjax.physics.vectors import Scalar

Y = TypeVar("Y")


def step(rate: Callable[[Scalar, Y], Y], t: Scalar, y: Y, h: Scalar, first: Y) -> Y:
    """y(t+h) ≈ y + h/6 (k₁ + 2k₂ + 2k₃ + k₄) for ẏ = rate(t, y).

    first: k₁ = rate(t, y), which the caller has already. y: any tree of numbers.
    """
    k2 = rate(t + 0.5 * h, along(y, 0.5 * h, first))
    k3 = rate(t + 0.5 * h, along(y, 0.5 * h, k2))
    k4 = rate(t + h, along(y, h, k3))
    return jax.tree.map(lambda a, p, q, r, s: a + (h / 6.0) * (p + 2.0 * (q + r) + s), y, first, k2, k3, k4)


def along(y: Y, h: Scalar, slope: Y) -> Y:
    """y + h · slope, number by number."""

    def move(a: Any, k: Any) -> Any:
        return a + h * k

    return jax.tree.map(move, y, slope)
