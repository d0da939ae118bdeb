"""Numbers and units as text: significant digits, SI prefixes, intervals rounded outwards."""

from __future__ import annotations

import math
import re
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Decimal

from rvjax.columns import MARGIN, metric_and_channel
from rvjax.report.blocks import Number
from rvjax.stats import Estimate
from rvjax.stats.sampling_design import Observed

INFINITY = "∞"
LARGEST = 1e9
"""A number with an interval is written with a power of ten from here on, such as the torque command of a runaway."""

SPACE = "\u00a0"  # no-break space between a number and its unit
_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_PREFIXES = ((1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))
_SYMBOLS = {"1": "", "": "", "deg": "°", "deg/s": "°/s"}
_PREFIXED = ("m", "m/s", "rad", "rad/s", "N", "N·m", "N*m")
_UNIT_ENDINGS = re.compile(r"_(s|m|m_s|deg|deg_s|rad|rad_s|N|Nm|Nms|kg|kgm2)$")
_CHANNELS = {"fx": "force x", "fy": "force y", "fz": "force z", "tx": "torque x", "ty": "torque y", "tz": "torque z"}


def axis_label(words: str, unit: str) -> str:
    """The label of an axis: the quantity and its unit, if any."""
    return words if unit in ("1", "") else f"{words}, {unit}"


def count(value: int) -> str:
    """A count with thousands separators: 4,096."""
    return f"{value:,d}"


def power_of_ten(exponent: int) -> str:
    """10⁻³: a power of ten in plain text."""
    return "10" + str(exponent).translate(_SUPERSCRIPTS)


def number(value: float, digits: int = 3) -> str:
    """A value without an interval, to `digits` significant digits; never in the form 1e-05."""
    if not math.isfinite(value) or value == 0.0:
        return _special(value)
    exponent = math.floor(math.log10(abs(value)))
    if -4 <= exponent < 6:
        return _fixed(value, max(digits - 1 - exponent, 0), ROUND_HALF_EVEN)
    return f"{_fixed(_scaled(value, exponent), digits - 1, ROUND_HALF_EVEN)}×{power_of_ten(exponent)}"


def _scaled(value: float, exponent: int) -> float:
    """value / 10^exponent, also if 10^exponent overflows."""
    return float(Decimal(value).scaleb(-exponent))


def setting(value: float) -> str:
    """A chosen value, as its author wrote it: 0.05, 300, 2×10⁻⁵."""
    if value and not 1e-4 <= abs(value) < 1e6:
        return number(value)
    return f"{value:.6g}".replace("-", "−")


def quantity(value: float, unit: str) -> str:
    """A value without an interval, with its unit and an SI prefix: 0.54 mm."""
    scale, symbol = prefixed(value, unit)
    return _with_unit(number(value / scale), value, symbol)


def prefixed(largest: float, unit: str) -> tuple[float, str]:
    """(scale, unit text) such that |largest| / scale ≥ 0.5 if an SI prefix allows it."""
    if unit in _SYMBOLS:
        return 1.0, _SYMBOLS[unit]
    if unit not in _PREFIXED or not math.isfinite(largest) or largest == 0.0:
        return 1.0, unit
    for scale, letter in _PREFIXES:
        if abs(largest) >= 0.5 * scale:
            return scale, letter + unit
    return _PREFIXES[-1][0], _PREFIXES[-1][1] + unit


def shown(item: Number) -> tuple[str, str]:
    """(value with unit, interval) of a number as text; the interval of a count or of an observed value is empty.

    An infinite value has no unit; then the interval has it, if one of its ends is finite.
    """
    if isinstance(item.value, int):
        return count(item.value), ""
    if isinstance(item.value, Observed):
        return _observed(item.value.value, item), ""
    estimate = item.value
    reference = next(filter(math.isfinite, (estimate.value, estimate.low, estimate.high)), math.inf)
    scale, symbol = (0.01, "%") if item.percent else prefixed(reference, item.unit)
    value, low, high = (x / scale for x in (estimate.value, estimate.low, estimate.high))
    ends = [x for x in (value, low, high) if math.isfinite(x)]
    largest = max(map(abs, ends), default=0.0)
    if largest > 0.0 and not 1e-3 <= largest < LARGEST:
        exponent = math.floor(math.log10(largest))
        value, low, high = (_scaled(x, exponent) for x in (value, low, high))
        symbol = f"×{power_of_ten(exponent)} {symbol}".strip()
    decimals = _decimals(value, low, high)
    text = _with_unit(_fixed(value, decimals, ROUND_HALF_EVEN), value, symbol)
    interval = f"{_fixed(low, decimals, ROUND_FLOOR)} … {_fixed(high, decimals, ROUND_CEILING)}"
    return text, interval if math.isfinite(value) else _with_unit(interval, reference, symbol)


def _observed(value: float, item: Number) -> str:
    """An observed value, which has no interval."""
    if not item.percent:
        return quantity(value, item.unit)
    return f"{number(100.0 * value)}{SPACE}%" if math.isfinite(value) else number(value)


def spoken(item: Number) -> str:
    """A number for use in a sentence: 97.2 % (96.6 … 97.7, 95 % confidence)."""
    value, interval = shown(item)
    if not isinstance(item.value, Estimate):
        return value
    return f"{value} ({interval}, {percent(item.value.confidence)} confidence)"


def percent(share: float) -> str:
    """A chosen share (a confidence, a quantile) in percent: 95 %, 99.73 %."""
    return f"{share * 100:.6g}{SPACE}%"


def label(name: str) -> str:
    """A metric as words: settling_time_s → settling time; saturation_duty.fx → saturation duty, force x."""
    if name.startswith(MARGIN):
        return f"margin {name.removeprefix(MARGIN)}"
    stem, part = metric_and_channel(name)
    words = _UNIT_ENDINGS.sub("", stem).replace("_", " ").replace("delta v", "Δv").replace("chi", "|χ|")
    return f"{words}, {channel(part)}" if part else words


def capital(words: str) -> str:
    """The words with a capital first letter."""
    return words[:1].upper() + words[1:]


def channel(name: str) -> str:
    """A channel as words: fx → force x, any → worst channel."""
    return _CHANNELS.get(name, "worst channel" if name == "any" else name)


def _decimals(value: float, low: float, high: float) -> int:
    """The number of decimals that gives the interval's width two significant digits and the value three to five."""
    finite = [abs(x) for x in (value, low, high) if math.isfinite(x) and x != 0.0]
    if not finite:
        return 0
    leading = math.floor(math.log10(max(finite)))
    by_width = 2 - leading
    if math.isfinite(high - low) and high > low:
        by_width = 1 - math.floor(math.log10(high - low))
    return max(min(max(by_width, 2 - leading), 4 - leading), 0)


def _fixed(value: float, decimals: int, rounding: str) -> str:
    if not math.isfinite(value) or value == 0.0:
        return _special(value)
    text = str(Decimal(f"{value:.14g}").quantize(Decimal(1).scaleb(-decimals), rounding=rounding))
    text = text.removeprefix("-") if float(text) == 0.0 else text
    return text.replace("-", "−") if abs(value) < 1e4 else f"{Decimal(text):,}".replace("-", "−")


def _with_unit(text: str, value: float, symbol: str) -> str:
    """The text and its unit: no unit after infinity, no space before a degree sign or a power of ten."""
    if not math.isfinite(value):
        return text
    return text + symbol if symbol.startswith(("°", "×")) or not symbol else f"{text}{SPACE}{symbol}"


def _special(value: float) -> str:
    if value == 0.0:
        return "0"
    if math.isnan(value):
        return "not finite"
    return INFINITY if value > 0 else "−" + INFINITY
