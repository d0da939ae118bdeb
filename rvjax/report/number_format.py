"""Numbers and units as text: significant digits, SI prefixes, intervals rounded outwards."""

from __future__ import annotations

import math
import re
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Decimal

from rvjax.analysis.percentages import chosen, estimated, rounded
from rvjax.columns import MARGIN, metric_and_channel
from rvjax.report.blocks import Number
from rvjax.stats import Estimate
from rvjax.stats.sampling_design import Observed

INFINITY = "∞"
LARGEST = 1e9
"""A number with an interval is written with a power of ten from here on, such as the torque command of a runaway."""

APART = 100.0
"""A value and its ends share a power of ten if the largest is less than this many times the smallest."""

SPACE = "\u00a0"  # no-break space between a number and its unit
_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_POWERLESS = ("0", INFINITY, "−" + INFINITY)
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
    return _with_power(_exact(value), digits, ROUND_HALF_EVEN)


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

    An infinite value has no unit; then the interval has it, if one of its ends is finite. A value and its ends share a power of
    ten and their decimals. A number that is much smaller has more decimals, or a power of ten by itself.
    """
    if isinstance(item.value, int):
        return count(item.value), ""
    if isinstance(item.value, Observed):
        return _observed(item.value.value, item), ""
    estimate = item.value
    reference = next(filter(math.isfinite, (estimate.value, estimate.low, estimate.high)), math.inf)
    scale, symbol = (0.01, "%") if item.percent else prefixed(reference, item.unit)
    value, low, high = (x / scale for x in (estimate.value, estimate.low, estimate.high))
    sizes = [abs(x) for x in (value, low, high) if math.isfinite(x) and x != 0.0]
    if sizes and not 1e-3 <= max(sizes) < LARGEST and max(sizes) / min(sizes) < APART:
        exponent = math.floor(math.log10(max(sizes)))
        value, low, high = (_scaled(x, exponent) for x in (value, low, high))
        symbol = f"×{power_of_ten(exponent)} {symbol}".strip()
    decimals = _decimals(value, low, high)
    text = _with_unit(_digits(value, decimals, ROUND_HALF_EVEN, item.percent), value, symbol)
    low_text = _digits(low, decimals, ROUND_FLOOR, item.percent)
    high_text = _digits(high, decimals, ROUND_CEILING, item.percent)
    if "×" in text and not symbol.startswith("×"):  # a power of ten of the value alone: the ends say theirs too
        low_text, high_text = (end if "×" in end or end in _POWERLESS else f"{end}×10⁰" for end in (low_text, high_text))
    interval = f"{low_text} … {high_text}"
    return text, interval if math.isfinite(value) else _with_unit(interval, reference, symbol)


def _digits(value: float, decimals: int, way: str, in_percent: bool) -> str:
    """A value to `decimals` places, and to more where fewer than two significant digits would remain.

    A percentage reads as 100 only if it is 100. Below 10⁻⁴ and from `LARGEST` on, the value has a power of ten by itself.
    """
    if not math.isfinite(value) or value == 0.0:
        return _special(value)
    exact = _exact(value)
    if not -4 <= exact.adjusted() < math.log10(LARGEST):
        return _with_power(exact, 3, way)
    places = max(decimals, 1 - exact.adjusted())
    return _plain(rounded(exact, places, way) if in_percent else exact.quantize(Decimal(1).scaleb(-places), rounding=way))


def _with_power(value: Decimal, digits: int, way: str) -> str:
    """1.33×10¹⁵: a value to some significant digits, with a power of ten."""
    value = value.quantize(Decimal(1).scaleb(value.adjusted() - digits + 1), rounding=way)
    mantissa = value.scaleb(-value.adjusted()).quantize(Decimal(1).scaleb(1 - digits))
    return f"{_plain(mantissa)}×{power_of_ten(value.adjusted())}"


def _observed(value: float, item: Number) -> str:
    """An observed value, which has no interval."""
    if not item.percent:
        return quantity(value, item.unit)
    return share(value) if math.isfinite(value) else number(value)


def spoken(item: Number) -> str:
    """A number for use in a sentence: 97.2 % (96.6 … 97.7, 95 % confidence)."""
    value, interval = shown(item)
    if not isinstance(item.value, Estimate):
        return value
    return f"{value} ({interval}, {percent(item.value.confidence)} confidence)"


def percent(share: float) -> str:
    """A chosen share (a confidence, a quantile) in percent, as its author wrote it: 95 %, 99.73 %, 99.99995 %."""
    return f"{chosen(share)}{SPACE}%".replace("-", "−")


def share(value: float, digits: int = 3) -> str:
    """An observed share in percent to `digits` significant digits; only 1 reads as 100 %."""
    return f"{estimated(value, digits)}{SPACE}%".replace("-", "−")


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
    return _plain(_exact(value).quantize(Decimal(1).scaleb(-decimals), rounding=rounding))


def _exact(value: float) -> Decimal:
    """A value to 12 digits, so that the error of a sum of many steps does not move an end of an interval to the next place."""
    return Decimal(f"{value:.12g}")


def _plain(value: Decimal) -> str:
    """A decimal number with a typographic minus, and with thousands separators from 10,000 on."""
    text = f"{value:f}" if abs(value) < 10_000 else f"{value:,f}"
    return (text.removeprefix("-") if not value else text).replace("-", "−")


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
