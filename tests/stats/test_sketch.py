"""The sketch against the sorted numbers themselves: ranks, counts, and independence of order and grouping."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rvjax.stats.quantile_sketch import EXACT, RELATIVE_ERROR, Sketch

NUMBERS = st.lists(st.floats(allow_nan=False, min_value=-1e9, max_value=1e9) | st.sampled_from([math.inf, -math.inf, 0.0, -0.0]))


def stream(n: int) -> np.ndarray:
    """Numbers of both signs over twenty decades, with zeros and infinities, in no order."""
    generator = np.random.Generator(np.random.Philox(key=3))
    x = generator.lognormal(0, 6, n) * generator.choice([1.0, -1.0], n)
    x[generator.uniform(size=n) < 0.02] = 0.0
    x[generator.uniform(size=n) < 0.02] = math.inf
    x[generator.uniform(size=n) < 0.02] = -math.inf
    return x


def test_every_rank_lies_between_its_bounds_and_the_error_is_the_stated_one() -> None:
    """Kills: a bucket too narrow or shifted by one, negative numbers in ascending magnitude, ranks off by one."""
    x = stream(200_000)
    ranked = np.sort(x)
    sketch = Sketch()
    for part in np.split(x, 80):
        sketch.add(part)
    assert sketch.n == x.size
    for rank in [*range(0, x.size, 97), EXACT - 1, EXACT, x.size - EXACT - 1, x.size - EXACT, x.size - 1]:
        truth = ranked[rank]
        assert sketch.low(rank) <= truth <= sketch.high(rank)
        value = sketch.value(rank)
        assert value == truth or abs(value - truth) <= RELATIVE_ERROR * abs(truth) * (1 + 1e-12)
        if rank < EXACT or rank >= x.size - EXACT:
            assert sketch.low(rank) == truth == sketch.high(rank)


@pytest.mark.parametrize("limit", [-math.inf, 0.5, 1.0, 10.0, 2.0**40, math.inf])
def test_counts_at_an_edge_are_exact(limit: float) -> None:
    """Kills: > for >=, an edge that belongs to the bucket below."""
    x = np.concatenate([stream(100_000), np.full(50, limit)])
    assert Sketch(x).at_least(limit) == np.count_nonzero(x >= limit)
    assert Sketch(x).positive == np.count_nonzero(x > 0)
    assert Sketch(x).finite == np.count_nonzero(x < math.inf)


def test_counts_elsewhere_are_refused_but_in_the_exact_tails() -> None:
    """Kills: a count of whole buckets passed off as one of numbers."""
    x = stream(100_000)
    with pytest.raises(ValueError, match="no edge"):
        Sketch(x).at_least(1.23456789)
    late = float(np.sort(x[np.isfinite(x)])[-100])
    assert Sketch(x).at_least(late) == np.count_nonzero(x >= late)


def test_order_and_grouping_change_nothing() -> None:
    """Bit for bit. Kills: sums of floats, tails cut before they are merged, buckets that depend on what came first."""
    x = stream(50_000)
    whole = Sketch(x)
    generator = np.random.Generator(np.random.Philox(key=4))
    for parts in (2, 7, 120):
        shuffled = np.array_split(generator.permutation(x), parts)
        added, merged = Sketch(), Sketch()
        for part in shuffled:
            added.add(part)
            merged.merge(Sketch(part))
        assert added == whole
        assert merged == whole
    assert Sketch(x[1:]) != whole


@settings(max_examples=100, deadline=None)
@given(numbers=NUMBERS, at=st.integers(0, 50))
def test_few_numbers_are_known_exactly(numbers: list[float], at: int) -> None:
    """Kills: rounding where there is no need for it, zeros of two signs, whose order would depend on what came first."""
    sketch = Sketch(numbers[:at])
    sketch.add(numbers[at:])
    values = [sketch.value(rank) for rank in range(sketch.n)]
    assert values == sorted(numbers)
    assert not any(value == 0 and math.copysign(1, value) < 0 for value in values)


def test_memory_is_bounded() -> None:
    """Kills: keeping what was counted: a million numbers over ten octaves take two words a bucket beside the tails."""

    def size(sketch: Sketch) -> int:
        return sum(part.nbytes for part in vars(sketch).values() if isinstance(part, np.ndarray))

    many = Sketch(np.random.Generator(np.random.Philox(key=5)).uniform(1, 1000, 1_000_000))
    assert size(many) <= 8 * (2 * EXACT + 2 * 10 * 1024)


def test_what_has_no_rank_is_refused() -> None:
    """Kills: NaN sorted behind infinity, a rank counted from the end."""
    with pytest.raises(ValueError, match="NaN has no rank"):
        Sketch([1.0, math.nan])
    for rank in (-1, 2):
        with pytest.raises(IndexError, match="of 2 numbers"):
            Sketch([1.0, 2.0]).value(rank)
