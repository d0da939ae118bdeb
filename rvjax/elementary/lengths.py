"""Length of a vector of a few numbers in whole numbers: the C library's hypot differs from one machine to another."""

from __future__ import annotations

import math


def length(*parts: float) -> float:
    """√(x² + y² + …), the number nearest to it. ∞ with an infinite part, else NaN with a NaN."""
    if not all(map(math.isfinite, parts)):
        return math.inf if any(map(math.isinf, parts)) else math.nan
    shares = [float(part).as_integer_ratio() for part in parts]
    scale = max((below for _, below in shares), default=1)
    wholes = [above * (scale // below) for above, below in shares]
    square = sum(whole * whole for whole in wholes) << 256
    root = math.isqrt(square)
    root |= root * root != square  # what is cut off decides a tie
    try:
        return root / (scale << 128)
    except OverflowError:
        return math.inf
