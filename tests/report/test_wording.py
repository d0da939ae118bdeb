"""Numbers as text: outward intervals, significant digits, units; and the statistics that only the report uses."""

from __future__ import annotations

import itertools
import math
import re

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
        (Number("x", estimate(7.1e22, 6.92e22, 3.77e24), "N"), "0.07×10²⁴ N", "0.06 … 3.77"),
        (Number("x", estimate(math.inf, 2e300, math.inf)), "∞", "2.00 … ∞×10³⁰⁰"),
        (Number("x", estimate(-0.176, -0.225, -0.126)), "−0.176", "−0.225 … −0.126"),
        (Number("x", estimate(0.0352, 0.0341, 0.0361), "deg"), "0.0352°", "0.0341 … 0.0361"),
        (Number("x", 4096), "4,096", ""),
    ],
)
def test_numbers_read_as_written(item: Number, text: str, interval: str) -> None:
    """Mutation killed: rounding to nearest in an interval, an interval in another unit than its value."""
    assert tuple(part.replace("\u00a0", " ") for part in shown(item)) == (text, interval)


SHARES = st.floats(0, 1, allow_subnormal=False)
"""Without numbers below 2e-308, which have too few digits left to be compared."""


@given(SHARES, SHARES, SHARES)
def test_shown_intervals_hold_the_true_ones(a: float, b: float, c: float) -> None:
    """Mutation killed: rounding an end of an interval inwards."""
    low, value, high = sorted((a, b, c))
    text, interval = shown(Number("x", estimate(value, low, high), percent=True))
    ends = [float(end) for end in interval.split(" … ")]
    power = re.search("×10⁻([⁰¹²³⁴⁵⁶⁷⁸⁹]+)", text)
    scale = 10.0 ** -int(power[1].translate(str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹", "0123456789"))) if power else 1.0
    assert ends[0] * scale <= 100 * low * (1 + 1e-12)
    assert ends[1] * scale >= 100 * high * (1 - 1e-12)


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
