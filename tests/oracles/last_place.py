"""Errors in units in the last place, from exact values of mpmath. The unit is never below the smallest positive number."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mpmath
import numpy as np
from numpy.typing import NDArray


def errors(found: NDArray[Any], exact: Sequence[Any]) -> NDArray[np.float64]:
    """|found − exact| in units of the exact value's binade; ∞ where one is NaN or infinite and the other is not."""
    return np.array([_error(float(a), b, found.dtype) for a, b in zip(found, exact, strict=True)])


def _error(found: float, exact: Any, kind: Any) -> float:
    info = np.finfo(kind)
    if mpmath.isnan(exact) or mpmath.isinf(exact) or exact == 0:
        return 0.0 if found == float(exact) or (np.isnan(found) and mpmath.isnan(exact)) else np.inf
    if not np.isfinite(found):
        half_up = mpmath.ldexp(1, int(info.maxexp)) - mpmath.ldexp(1, int(info.maxexp) - info.nmant - 2)
        return 0.0 if abs(exact) >= half_up and not np.isnan(found) and (found > 0) == (exact > 0) else np.inf
    exponent = max(mpmath.frexp(exact)[1] - 1, int(info.minexp))
    return float(abs(mpmath.mpf(found) - exact) / mpmath.ldexp(1, exponent - info.nmant))
