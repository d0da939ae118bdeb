"""Numbers as text: outward intervals, significant digits, units; and the statistics that only the report uses."""

from __future__ import annotations

import itertools
import math
import re
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from rvjax.report.blocks import Number
from rvjax.report.number_format import INFINITY, label, number, percent, quantity, setting, shown, spoken
from rvjax.stats import Estimate
from rvjax.stats.sampling_design import Independent


def estimate(value: float, low: float, high: float) -> Estimate:
    return Estimate(value, low, high, 100, 0.95, "made up")


@pytest.mark.parametrize(
    ("item", "text", "interval"),
    [
        (Number("x", estimate(141.63, 139.99, 143.41), "s"), "141.6 s", "139.9 … 143.5"),
        (Number("x", estimate(0.000537, 0.00052, 0.00056), "m"), "0.537 mm", "0.520 … 0.560"),
        (Number("x", estimate(0.9995, 0.99899, 0.9998), percent=True), "99.950 %", "99.899 … 99.980"),
        (Number("x", estimate(1.0, 0.9991, 1.0), percent=True), "100.00 %", "99.91 … 100.00"),
        (Number("x", estimate(0.0, 0.0, 0.0009), percent=True), "0 %", "0 … 0.0900"),
        (Number("x", estimate(0.0, 0.0, 0.0), "s"), "0 s", "0 … 0"),
        (Number("x", estimate(math.inf, 120.0, math.inf), "s"), "∞", "120 … ∞ s"),
        (Number("x", estimate(math.inf, 8.12e-5, math.inf), "m"), "∞", "81.2 … ∞ µm"),
        (Number("x", estimate(math.inf, 3.5e-5, math.inf)), "∞", "3.50 … ∞×10⁻⁵"),
        (Number("x", estimate(math.inf, math.inf, math.inf), "s"), "∞", "∞ … ∞"),
        (Number("x", estimate(-math.inf, -math.inf, 4.9), "m"), "−∞", "−∞ … 4.90 m"),
        (Number("x", estimate(2.1e-5, 1.9e-5, 2.4e-5)), "2.10×10⁻⁵", "1.90 … 2.40"),
        (Number("x", estimate(7.1e22, 6.92e22, 3.77e24), "N"), "0.071×10²⁴ N", "0.069 … 3.77"),
        (Number("x", estimate(1.33e15, 3.0e10, 3.24e18), "N"), "1.33×10¹⁵ N", "3.00×10¹⁰ … 3.24×10¹⁸"),
        (Number("x", estimate(5.2, 0.012, 3.1e12)), "5.2", "0.012 … 3.10×10¹²"),
        (Number("x", estimate(0.0, -3.2e-9, 41.0), "N"), "0 N", "−3.20×10⁻⁹ … 41.0"),
        (Number("x", estimate(9.9996e15, 2e8, 9.9996e15)), "1.00×10¹⁶", "200,000,000×10⁰ … 1.00×10¹⁶"),
        (Number("x", estimate(0.99996, 0.61, 0.999999), percent=True), "99.996 %", "61.0 … 99.9999"),
        (Number("x", estimate(0.5, 1e-9, 1.0), percent=True), "50 %", "1.00×10⁻⁷ … 100"),
        (Number("x", estimate(1e-12, 0.0, 1.0), percent=True), "1.00×10⁻¹⁰ %", "0 … 100×10⁰"),
        (Number("x", estimate(4e-12, 1e-14, 3e-9)), "4.00×10⁻¹²", "1.00×10⁻¹⁴ … 3.00×10⁻⁹"),
        (Number("x", estimate(300.00000000003394, 144.2, 300.00000000003394), "s"), "300 s", "144 … 300"),
        (Number("x", estimate(math.inf, 2e300, math.inf)), "∞", "2.00 … ∞×10³⁰⁰"),
        (Number("x", estimate(-0.176, -0.225, -0.126)), "−0.176", "−0.225 … −0.126"),
        (Number("x", estimate(0.0352, 0.0341, 0.0361), "deg"), "0.0352°", "0.0341 … 0.0361"),
        (Number("x", 4096), "4,096", ""),
    ],
)
def test_numbers_read_as_written(item: Number, text: str, interval: str) -> None:
    """Mutation killed: rounding to nearest in an interval, an interval in another unit than its value."""
    assert tuple(part.replace("\u00a0", " ") for part in shown(item)) == (text, interval)


POWERS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹−", "-0123456789-")
NUMBER = re.compile(r"(−?[\d,]+(?:\.(\d+))?)(?:×10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+))?")


def read(text: str, power: int = 0) -> tuple[Fraction, Fraction]:
    """(value, its last place) of a printed number; power: of ten, of a number that has none by itself."""
    match = NUMBER.match(text)
    assert match is not None, text
    by_ten = Fraction(10) ** (int(match[3].translate(POWERS)) if match[3] else power)
    return Fraction(match[1].replace(",", "").translate(POWERS)) * by_ten, by_ten / 10 ** len(match[2] or "")


MAGNITUDES = st.builds(
    lambda sign, mantissa, exponent: sign * float(f"{mantissa:.3f}e{exponent}"),
    st.sampled_from((-1.0, 1.0)),
    st.floats(1, 9.999),
    st.integers(-30, 30),
)
SHARES = st.one_of(
    st.floats(0, 1),
    st.builds(lambda nines, x: 1.0 - x * 10.0**-nines, st.integers(1, 10), st.floats(0.1, 0.9)),
    st.builds(lambda zeros, x: x * 10.0**-zeros, st.integers(1, 30), st.floats(0.1, 0.9)),
).map(lambda share: float(f"{share:.11g}") if share > 1e-200 else 0.0)
"""Of up to 11 digits, as those of counts are, and none below 1e-200."""


def check(numbers: list[float], item: Number) -> None:
    """The three printed numbers, read back: rounded in the right way, in order, and 0 only for 0."""
    text, interval = shown(item)
    low, high = interval.split(" … ")
    split = [read(low), read(text), read(high)]
    common = NUMBER.match(text)
    assert common is not None
    if common[3] and "×" not in interval:  # the power of ten of the value is that of the ends too
        power = int(common[3].translate(POWERS))
        split = [read(low, power), read(text), read(high, power)]
    unit = {"mN": 1000, "µN": 10**6, "nN": 10**9, "%": 100}.get(re.sub(r"^[^a-zµ%N]*", "", text), 1)
    values = [Fraction(repr(x)) * unit for x in numbers]
    (bottom, ulp), (middle, step), (top, last) = split
    slack = Fraction(1, 10**11)
    assert 0 <= values[0] - bottom + abs(values[0]) * slack <= ulp * Fraction(11, 10)
    assert 0 <= top - values[2] + abs(values[2]) * slack <= last * Fraction(11, 10)
    assert abs(middle - values[1]) <= step * Fraction(51, 100)
    assert bottom <= middle <= top
    for value, (printed, place) in zip(values, split, strict=True):
        assert (value == 0) == (printed == 0)
        assert place <= abs(value) / 10 or value == 0 or abs(printed) >= place * 10


@example(3.0e10, 1.33e15, 3.24e18)
@given(MAGNITUDES, MAGNITUDES, MAGNITUDES)
def test_a_value_and_its_bounds_keep_their_digits(a: float, b: float, c: float) -> None:
    """Kills: decimals of the largest number for all three, 0.00 for 1.33e15, an end rounded inwards, a power of ten lost."""
    low, value, high = numbers = sorted((a, b, c))
    check(numbers, Number("x", estimate(value, low, high), "N"))


@example(0.5, 0.99996, 0.99999999)
@given(SHARES, SHARES, SHARES)
def test_shown_intervals_hold_the_true_ones(a: float, b: float, c: float) -> None:
    """Kills: an end of an interval rounded inwards, 0 % and 100 % for a share that is neither."""
    low, value, high = numbers = sorted((a, b, c))
    item = Number("x", estimate(value, low, high), percent=True)
    check(numbers, item)
    text, interval = shown(item)
    for share, part in zip((value, low, high), (text, *interval.split(" … ")), strict=True):
        assert (share == 1.0) == (read(part)[0] == 100)


@example(5e-324)
@example(-1.7e308)
@given(st.floats(allow_nan=False))
def test_lone_values_never_read_like_code(value: float) -> None:
    """Mutation killed: str(float), which gives 1e-05 and inf."""
    for text in (number(value), setting(value), quantity(value, "m"), quantity(value, "1")):
        assert not re.search(r"e[-+]?\d|inf|nan", text)
        assert len(text) <= 16


def test_names_read_as_words() -> None:
    assert label("settling_time_s") == "settling time"
    assert label("saturation_duty.fx") == "saturation duty, force x"
    assert label("peak_chi") == "peak |χ|"
    assert percent(0.9973) == "99.73\u00a0%"
    assert percent(0.9999995) == "99.99995\u00a0%"
    assert number(math.inf) == INFINITY
    assert "95\u00a0% confidence" in spoken(Number("x", estimate(1, 0.5, 2), "s"))


def test_rank_correlation_is_that_of_ranks() -> None:
    """Mutation killed: correlating values instead of ranks; ±inf must be ordinary ranks. Six pairs, by hand."""
    x = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    y = np.array([10.0, 11.0, 9.0, 1e9, math.inf, 12.0])
    assert Independent().correlation(x, y, 0.95).value == pytest.approx(1 - 6 * (1 + 1 + 4 + 1 + 1 + 4) / (6 * 35))
    assert Independent().correlation(x, np.exp(x), 0.95).value == pytest.approx(1.0)
    assert Independent().correlation(x, np.ones(6), 0.95) == Estimate(
        0.0, -1.0, 1.0, 6, 0.95, Independent().correlation(x, x, 0.95).method
    )


def test_rank_correlation_rarely_sees_what_is_not_there() -> None:
    """Exact error rate without relation, over all 5,040 orders of 7 samples: at most nominal.

    Mutations killed: 1/√n or 1/√(n − 1) instead of 1/√(n − 3), a one-sided quantile.
    """
    x = np.arange(7.0)
    orders = (np.array(order, dtype=float) for order in itertools.permutations(range(7)))
    clear = sum(not bound.low <= 0 <= bound.high for bound in (Independent().correlation(x, order, 0.95) for order in orders))
    assert clear / math.factorial(7) <= 0.05
