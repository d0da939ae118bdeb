"""Requirements beyond a fixed share: judged after every chunk, by a ratio of likelihoods, at most a share, and by the mean."""

from __future__ import annotations

import math
from itertools import permutations
from typing import Any

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray
from scipy import integrate, stats

from rvjax.analysis.verdicts import Tallies, Verdict, judge_all
from rvjax.campaign import Requirement
from rvjax.columns import Column
from rvjax.stats.sampling_design import Independent

COLUMNS = {"metric.x": Column("metric.x", "m", "made up", "lower")}


def chunk(first: int, outcomes: NDArray[np.bool_], x: NDArray[np.float64] | None = None) -> pd.DataFrame:
    """Samples from `first` on, captured where true; x: their metric."""
    words = np.where(outcomes, "captured", "not_settled")
    numbers = np.zeros(len(outcomes)) if x is None else x
    return pd.DataFrame({"sample": np.arange(first, first + len(outcomes)), "outcome": words, "metric.x": numbers})


def judged(frames: list[pd.DataFrame], **said: Any) -> Verdict:
    """The verdict of chunks on one requirement."""
    tallies = Tallies([Requirement(**{"metric": "captured", **said})], Independent())
    for frame in frames:
        tallies.add(frame, COLUMNS)
    return tallies.verdicts()[0]


def evidence(successes: int, failures: int, limit: float, above: bool) -> float:
    """∫ p^s q^f / (p₀^s q₀^f) over Beta(½, ½) cut at p₀, by quadrature: p = sin² φ makes the density flat."""
    edge = math.asin(math.sqrt(limit))
    low, high = (edge, math.pi / 2) if above else (0.0, edge)

    def ratio(phi: float) -> float:
        p = math.sin(phi) ** 2
        if (successes and p <= 0) or (failures and p >= 1):
            return 0.0
        logarithm = successes * math.log(p / limit) if successes else 0.0
        return math.exp(logarithm + (failures * math.log((1 - p) / (1 - limit)) if failures else 0.0))

    return integrate.quad(ratio, low, high, limit=200, points=[math.asin(math.sqrt(successes / max(successes + failures, 1)))])[
        0
    ] / (high - low)


def sequences() -> list[tuple[float, list[NDArray[np.bool_]]]]:
    """Limits, and chunks of samples whose true share is above, at and below them."""
    generator = np.random.Generator(np.random.Philox(key=11))
    found: list[tuple[float, list[NDArray[np.bool_]]]] = []
    for limit in (0.8, 0.95):
        for p in (limit - 0.1, limit, min(0.999, limit + 0.1)):
            found += [(limit, [generator.random(int(generator.integers(5, 40))) < p for _ in range(8)]) for _ in range(5)]
    return found


def frames(chunks: list[NDArray[np.bool_]]) -> list[pd.DataFrame]:
    """The chunks one behind the other."""
    firsts = np.concatenate([[0], np.cumsum([len(one) for one in chunks])])
    return [chunk(int(first), one) for first, one in zip(firsts, chunks, strict=False)]


def test_the_first_look_with_enough_evidence_decides() -> None:
    """Thirty sequences against quadrature. Kills: the last look for the first, ln 20 for 20, PASS and FAIL mixed up, a prior
    that is not cut at the limit, chunks counted twice."""
    words: list[str] = []
    for limit, chunks in sequences():
        verdict = judged(frames(chunks), at_least=limit, method="sequential")
        n = failures = 0
        expected = ("UNDECIDED", sum(map(len, chunks)))
        for one in chunks:
            n, failures = n + len(one), failures + int((~one).sum())
            passing, failing = (evidence(n - failures, failures, limit, above) for above in (True, False))
            if max(passing, failing) >= 20:
                expected = ("PASS" if passing >= 20 else "FAIL", n)
                break
        assert (verdict.verdict, verdict.n) == expected
        words.append(verdict.verdict)
    assert {words.count(word) > 3 for word in ("PASS", "FAIL", "UNDECIDED")} == {True}


def test_chunks_in_any_order_and_none_behind_a_gap() -> None:
    """Kills: looks in the order of arrival, evidence from samples behind those that are still missing."""
    _, chunks = sequences()[6]
    made = frames(chunks)[:4]
    first = judged(made, at_least=0.8, method="sequential")
    for order in permutations(made):
        assert judged(list(order), at_least=0.8, method="sequential").text == first.text
    gap = judged([made[0], made[2], made[3]], at_least=0.8, method="sequential")
    assert gap.n == len(made[0])


@pytest.mark.parametrize(("n", "failures"), [(74, 0), (73, 0), (300, 9), (500, 60), (40, 40), (1, 0), (0, 0)])
def test_anytime_bounds_are_the_shares_that_are_not_refuted(n: int, failures: int) -> None:
    """A share just inside a bound has less evidence against it than 20, just outside at least as much. Kills: two-sided bounds,
    bounds of a fixed number of samples."""
    made = [chunk(0, np.arange(n) >= failures)] if n else []
    verdict = judged(made, at_least=0.95, method="sequential")
    low, high = verdict.low_bound, verdict.high_bound
    if n:
        assert low <= 1 - failures / n <= high
    for edge, above, step in ((low, True, 1e-6), (high, False, -1e-6)):
        if 0 < edge < 1:
            assert evidence(n - failures, failures, edge - step, above) >= 20 - 1e-6
            assert evidence(n - failures, failures, edge + step, above) < 20
    if n == 74:
        assert verdict.verdict == "PASS"
    if n == 73:
        assert verdict.verdict == "UNDECIDED"


def test_the_ratio_test_compares_two_shares() -> None:
    """ln ratio by the log-likelihoods of SciPy. Kills: β for α, the ratio upside down, a limit of at_most taken for a success."""
    for said, failures, expected in (
        ({"at_least": 0.9, "expected": 0.98}, 0, "PASS"),
        ({"at_least": 0.9, "expected": 0.98}, 3, "UNDECIDED"),
        ({"at_least": 0.9, "expected": 0.98}, 8, "FAIL"),
    ):
        outcomes = np.arange(40) >= failures
        verdict = judged([chunk(0, outcomes)], method="sprt", power=0.95, **said)
        assert verdict.evidence is not None
        ratio = stats.binom.logpmf(failures, 40, 0.02) - stats.binom.logpmf(failures, 40, 0.1)
        assert verdict.evidence.passing[0] == pytest.approx(ratio)
        assert (verdict.evidence.needed_pass, verdict.evidence.needed_fail) == pytest.approx((math.log(20), math.log(20)))
        assert verdict.verdict == expected
    x = np.where(np.arange(400) < 2, 5.0, 1.0)
    same = {"metric": "x", "above": 3.0, "at_most": 0.1, "expected": 0.02, "method": "sprt"}
    assert judged([chunk(0, x < 3, x)], **same).verdict == "PASS"
    assert judged([chunk(0, x < 3, 6.0 - x)], **same).verdict == "FAIL"


def test_at_most_counts_what_is_not_a_number_against_it() -> None:
    """Kills: NaN, which is not above anything, as compliance; the limit p for 1 - p."""
    x = np.array([1.0] * 90 + [5.0] * 4 + [math.nan] * 6)
    verdict = judged([chunk(0, np.ones(100, dtype=bool), x)], metric="x", above=3.0, at_most=0.2)
    assert (verdict.successes, verdict.n, verdict.limit) == (90, 100, 0.8)
    assert verdict.low_bound == pytest.approx(stats.beta.ppf(0.05, 90, 11))
    assert verdict.verdict == "PASS"
    assert judged([chunk(0, np.ones(100, dtype=bool), x)], metric="x", above=3.0, at_most=0.05).verdict == "FAIL"


@pytest.mark.parametrize("p", [0.1, 0.5])
@pytest.mark.parametrize("side", ["below", "above"])
def test_a_mean_is_judged_with_the_stated_risk(p: float, side: str) -> None:
    """Values 0 and 10 m with probabilities 1 - p and p, the limit at the true mean; summed over the lattice of 60 samples.

    Kills: a normal interval, bounds at half the confidence, below and above mixed up.
    """
    n, wrong = 60, 0.0
    for ones in range(n + 1):
        x = np.where(np.arange(n) < ones, 10.0, 0.0)
        verdict = judged([chunk(0, x < 20, x)], metric="x", mean=True, range=[0, 10], confidence=0.9, **{side: 10 * p})
        wrong += stats.binom.pmf(ones, n, p) * (verdict.verdict != "UNDECIDED")
        half = math.sqrt(2 * x.var(ddof=1) * math.log(20) / n) + 10 * 7 * math.log(20) / (3 * (n - 1))
        assert verdict.high_bound == pytest.approx(min(10.0, x.mean() + half))
    assert wrong <= 0.2  # either way, 0.1 each


def test_a_mean_of_values_in_parts_out_of_range_and_not_finite() -> None:
    """Kills: moments that depend on the chunks, a value beyond the range that passes, a lost flight left out of the mean."""
    generator = np.random.Generator(np.random.Philox(key=3))
    x = generator.uniform(0, 4, 3000)
    said = {"metric": "x", "mean": True, "below": 3.0, "range": [0, 10]}
    whole = judged([chunk(0, x < 9, x)], **said)
    parts = [chunk(first, x[first : first + 700] < 9, x[first : first + 700]) for first in range(0, 3000, 700)]
    assert whole.verdict == "PASS"
    assert judged(parts[::-1], **said).estimate == judged(parts, **said).estimate
    assert judged(parts, **said).low_bound == pytest.approx(whole.low_bound, rel=1e-12)
    x[5] = 11.0
    outside = judged([chunk(0, x < 99, x)], **said)
    assert outside.verdict == "UNDECIDED"
    assert "1 values lie outside the stated range of 0 m to 10 m" in outside.text
    x[5:1500] = math.nan
    lost = judged([chunk(0, x < 99, x)], **said)
    assert lost.estimate.value == pytest.approx((np.nansum(x) + 1495 * 10) / 3000)
    assert lost.verdict == "FAIL"


def test_a_mean_without_a_range_says_that_it_is_approximate() -> None:
    """By the bootstrap where there are few values, by the central limit theorem where there are many. Kills: silence about it."""
    generator = np.random.Generator(np.random.Philox(key=4))
    for n in (200, 6000):
        x = generator.normal(2, 1, n)
        verdict = judged([chunk(0, x < 99, x)], metric="x", mean=True, below=2.5)
        assert verdict.verdict == "PASS"
        assert "approximate" in verdict.text
        assert "approximate" in verdict.estimate.method
        assert verdict.high_bound == pytest.approx(x.mean() + 1.645 / math.sqrt(n), abs=0.1 / math.sqrt(n) * 2)
    x = np.full(20, math.inf)
    assert judged([chunk(0, x < 99, x)], metric="x", mean=True, below=2.5).verdict != "PASS"


def test_every_missing_draw_of_a_class_is_named() -> None:
    """Kills: a class of nobody that is judged as all."""
    from rvjax.errors import UsageError

    requirements = [Requirement(metric="captured", at_least=0.5, where={"a.b": {"below": 1.0}})]  # pyright: ignore
    with pytest.raises(UsageError, match=r"captured: where: no draw 'a\.b' in the table"):
        judge_all(requirements, chunk(0, np.ones(3, dtype=bool)), Independent())


def test_a_class_has_its_own_looks_and_its_edges() -> None:
    """Draws 0, 1, 2, 0, 1, 2, …: below 1, at least 1, equal to 1. Kills: failures counted among all samples, an edge that belongs
    to both sides or to none."""
    outcomes = np.arange(600) % 3 == 0  # captured where the draw is 0
    made = [chunk(first, outcomes[first : first + 300]).assign(**{"draw.d": np.arange(300) % 3}) for first in (0, 300)]
    said = {"at_least": 0.9, "method": "sequential"}
    for condition, n, word in (({"below": 1.0}, 100, "PASS"), ({"at_least": 1.0}, 200, "FAIL"), ({"equals": 1.0}, 100, "FAIL")):
        verdict = judged(made, where={"d": condition}, **said)
        assert (verdict.verdict, verdict.n) == (word, n)
        assert verdict.successes == (n if word == "PASS" else 0)
        assert f"samples with d {'<' if word == 'PASS' else '≥' if n == 200 else '='} 1" in verdict.text
    assert judged(made, where={"d": {"at_least": 7.0}}, **said).verdict == "UNDECIDED"
    assert judged(made, where={"d": {"at_least": 7.0}}, at_least=0.9).verdict == "UNDECIDED"
