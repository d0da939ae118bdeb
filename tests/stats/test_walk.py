"""Exact ends of a boundary: against every sequence of samples there is, and what peeking does to a fixed-n verdict."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from scipy import stats as oracle

from rvjax.stats import Boundary, decisions, fixed_boundary, schedule, walk

BOUNDARIES = [
    Boundary(np.arange(1, 12), np.array([-1, -1, 0, 0, 0, 1, 1, 1, 2, 2, 2]), np.array([2, 3, 3, 3, 4, 4, 4, 5, 5, 5, 6])),
    Boundary(np.array([3, 6, 9, 11]), np.array([0, 0, 1, 2]), np.array([3, 4, 5, 6])),
    Boundary(np.array([4, 5, 11]), np.array([-1, -1, -1]), np.array([5, 6, 12])),
    Boundary(np.array([5, 10]), np.array([-1, 6]), np.array([2, 5])),
]


def ends(sequence: tuple[int, ...], boundary: Boundary) -> tuple[int, int]:
    """What a sequence of failures ends in (1, -1, 0) and the index of the look, by definition."""
    for j, (n, most, least) in enumerate(zip(*(part.tolist() for part in boundary), strict=True)):
        failures = sum(sequence[:n])
        if failures <= most or failures >= least:
            return (1 if failures <= most else -1), j
    return 0, len(boundary.looks) - 1


@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize("p", [0.0, 0.2, 0.7, 0.95, 1.0])
def test_walk_is_the_sum_over_all_sequences(boundary: Boundary, p: float) -> None:
    """All 2^11 of them, weighed. Kills: < for <= at either side, p and 1 - p swapped, samples that count the last chunk twice."""
    last = int(boundary.looks[-1])
    passed, failed, undecided, samples = np.zeros(boundary.looks.size), np.zeros(boundary.looks.size), 0.0, 0.0
    for sequence in product((0, 1), repeat=last):
        weight = (1 - p) ** sum(sequence) * p ** (last - sum(sequence))
        end, j = ends(sequence, boundary)
        passed[j] += weight * (end == 1)
        failed[j] += weight * (end == -1)
        undecided += weight * (end == 0)
        samples += weight * boundary.looks[j]
    found = walk(p, boundary)
    assert found.passed == pytest.approx(passed, abs=1e-13)
    assert found.failed == pytest.approx(failed, abs=1e-13)
    assert (found.passes, found.fails) == pytest.approx((passed.sum(), failed.sum()), abs=1e-13)
    assert (found.undecided, found.samples) == pytest.approx((undecided, samples), abs=1e-12)


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_what_is_decided_stays_decided(boundary: Boundary) -> None:
    """Every sequence, all at once. Kills: a verdict per look, FAIL before PASS, a verdict that begins one look late."""
    sequences = np.array(list(product((0, 1), repeat=int(boundary.looks[-1]))))
    found = decisions(np.cumsum(sequences, axis=1)[:, boundary.looks - 1], boundary)
    for row, sequence in zip(found[::5], sequences[::5].tolist(), strict=True):
        end, j = ends(tuple(sequence), boundary)
        assert row.tolist() == [0] * j + [end] * (len(row) - j)


def test_one_look_is_the_binomial_law() -> None:
    """Kills: a law that is not normalised, a chunk of one sample too few."""
    for n, p in ((100, 0.9), (2000, 0.999), (20_000, 0.5)):
        most, least = int(n * (1 - p)), int(n * (1 - p)) + 20
        found = walk(p, Boundary(np.array([n]), np.array([most]), np.array([least])))
        assert found.passes == pytest.approx(oracle.binom.cdf(most, n, 1 - p), rel=1e-11)
        assert found.fails == pytest.approx(oracle.binom.sf(least - 1, n, 1 - p), rel=1e-9)
        assert found.samples == n


def test_chunks_do_not_matter_where_nothing_ends() -> None:
    """Kills: states that are dropped though they matter, a new chunk's law of the wrong size."""
    n, most = 3000, 25
    whole = [np.append(np.full(len(looks) - 1, -1), most) for looks in (schedule(n), schedule(n, 7), schedule(n, 1000))]
    found = [
        walk(0.99, Boundary(schedule(n, c), passes, schedule(n, c) + 1)) for c, passes in zip((1, 7, 1000), whole, strict=True)
    ]
    assert [one.passes for one in found] == pytest.approx([oracle.binom.cdf(most, n, 0.01)] * 3, rel=1e-10)


def test_peeking_with_a_fixed_n_verdict_breaks_its_promise() -> None:
    """24.6 % in place of 5 %: .99/.95 looked at every 100 samples up to 10,000. Kills: a walk that goes on after its end."""
    looks = schedule(10_000, 100)
    peeked = fixed_boundary(looks, 0.99, 0.95)
    assert f"{walk(0.99, peeked._replace(fails=looks + 1)).passes:.3f}" == "0.246"
    assert walk(0.99, Boundary(*(part[-1:] for part in peeked))).passes <= 0.05


def test_schedule_ends_with_the_last_sample() -> None:
    """Kills: a last chunk that is left out, or a look twice."""
    assert schedule(10, 4).tolist() == [4, 8, 10]
    assert schedule(8, 4).tolist() == [4, 8]
    assert schedule(3, 10).tolist() == [3]
    assert schedule(4).tolist() == [1, 2, 3, 4]


def test_impossible_walks_are_refused() -> None:
    """Kills: a check that is left out."""
    good = BOUNDARIES[1]
    for p in (-0.1, 1.1, float("nan")):
        with pytest.raises(ValueError, match="p must be between 0 and 1"):
            walk(p, good)
    with pytest.raises(ValueError, match="rising"):
        walk(0.5, good._replace(looks=np.array([3, 6, 6, 11])))
    for failures in ([2, 1, 1, 1], [4, 4, 4, 4], [0, 0, 0]):
        with pytest.raises(ValueError, match="failures must be one count per look"):
            decisions(failures, good)
    with pytest.raises(ValueError, match="most must be whole numbers >= 1"):
        schedule(0)
