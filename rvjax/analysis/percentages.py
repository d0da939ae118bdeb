"""Shares as percentages in text. Only the share 0 reads as 0, and only the share 1 reads as 100.

chosen      as the author wrote it: 0.95 → 95, 0.9999995 → 99.99995
estimated   to some significant digits, and to more where they would read as 0 or 100: 0.99996 → 99.996
"""

from __future__ import annotations

import math
from decimal import ROUND_HALF_EVEN, Decimal

TYPED = 12
"""A share of up to this many significant digits reads as its author wrote it. Others are the results of computations."""

KEPT = 6
"""Significant digits of a computed share, or of its distance from 1 where that is smaller."""


def chosen(share: float) -> str:
    """A chosen share (a confidence, a quantile, a limit) in percent, without the sign %."""
    if not math.isfinite(share):
        return f"{share}"
    value = Decimal(repr(float(share)))
    if len(value.as_tuple().digits) > TYPED:
        nearest = min(part for part in (abs(value), abs(1 - value)) if part)
        value = value.quantize(Decimal(1).scaleb(min(nearest.adjusted() + 1 - KEPT, -2)))
    return _plain(100 * value)


def estimated(share: float, digits: int = 3, way: str = ROUND_HALF_EVEN) -> str:
    """A share, or a difference of shares, in percent to `digits` significant digits, without the sign %. way: of rounding."""
    if not math.isfinite(share):
        return f"{share}"
    value = Decimal(f"{100 * share:.14g}")
    return _plain(rounded(value, max(digits - 1 - value.adjusted(), 0), way)) if value else "0"


def rounded(value: Decimal, decimals: int, way: str = ROUND_HALF_EVEN) -> Decimal:
    """A percentage to `decimals` places, and to more where it would become 0 or 100 without being so."""
    result = value.quantize(Decimal(1).scaleb(-decimals), rounding=way)
    if result in (-100, 0, 100) and (apart := abs(value - result)):
        return value.quantize(Decimal(1).scaleb(min(apart.adjusted(), -decimals)), rounding=way)
    return result


def _plain(value: Decimal) -> str:
    """The number without an exponent and without zeros at its end."""
    text = f"{value:f}"
    return text.rstrip("0").rstrip(".") if "." in text else text
