"""Verdicts: what counts as a success, and the exact probability of a wrong verdict."""

from __future__ import annotations

import math
import re
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy import stats as oracle

from rvjax.analysis import verdicts
from rvjax.analysis.verdicts import Tallies, account_and_verdicts, exit_code, judge_folder
from rvjax.campaign import Requirement
from rvjax.errors import FolderError, IncompleteError, UsageError
from rvjax.run_folder import Account, Column, RunDescription, RunFolder, Samples
from rvjax.stats import quantile_interval
from rvjax.stats.quantile_sketch import RELATIVE_ERROR
from rvjax.stats.sampling_design import Independent

judge, judge_all = partial(verdicts.judge, design=Independent()), partial(verdicts.judge_all, design=Independent())


def require(metric: str, **parts: Any) -> Any:
    """A requirement with the fields of `rvjax.campaign.Requirement`."""
    return Requirement(metric=metric, **parts)


def captured(k: int, n: int) -> pd.DataFrame:
    """A table of n samples, k of them captured."""
    return pd.DataFrame({"sample": range(n), "outcome": ["captured"] * k + ["not_settled"] * (n - k)})


def settled(values: list[float], outcome: str = "captured") -> pd.DataFrame:
    """A table with settling times."""
    n = len(values)
    return pd.DataFrame({"sample": range(n), "outcome": [outcome] * n, "metric.settling_time_s": values})


@pytest.mark.parametrize("confidence", [0.9, 0.95])
@pytest.mark.parametrize("limit", [0.5, 0.9, 0.95])
@pytest.mark.parametrize("n", [1, 22, 60])
def test_wrong_verdicts_are_no_likelier_than_promised(n: int, limit: float, confidence: float) -> None:
    """P(PASS) for p below the limit and P(FAIL) for p at or above it, summed over the lattice; both are largest at it.

    Kills: the point estimate or Wilson's bound as the judge, PASS and FAIL swapped, > for >= at the limit of both.
    """
    k = np.arange(n + 1)
    requirement = require("captured", at_least=limit, confidence=confidence)
    words = np.array([judge(requirement, captured(successes, n)).verdict for successes in k])
    for p in (limit - 1e-9, limit - 0.01, limit / 2):
        assert oracle.binom.pmf(k, n, p)[words == "PASS"].sum() <= 1 - confidence + 1e-9
    for p in (limit, limit + 0.01, (1 + limit) / 2):
        assert oracle.binom.pmf(k, n, p)[words == "FAIL"].sum() <= 1 - confidence + 1e-9
    order = {"FAIL": 0, "UNDECIDED": 1, "PASS": 2}
    assert np.all(np.diff([order[word] for word in words]) >= 0)


@pytest.mark.parametrize(
    ("k", "n", "word"),
    [
        (59, 59, "PASS"),
        (58, 58, "UNDECIDED"),
        (92, 93, "PASS"),
        (91, 92, "UNDECIDED"),
        (44, 50, "FAIL"),
        (45, 50, "UNDECIDED"),
        (0, 2, "FAIL"),
    ],
)
def test_verdict_turns_at_the_published_numbers(k: int, n: int, word: str) -> None:
    """59 and 93 at .95/.95; FAIL first where P(Bin(n, .95) <= k) < 5 %. Kills: a two-sided bound (74 for 59)."""
    verdict = judge(require("captured", at_least=0.95), captured(k, n))
    assert verdict.verdict == word
    assert (verdict.successes, verdict.n, verdict.limit) == (k, n, 0.95)
    assert verdict.low_bound <= verdict.estimate.value <= verdict.high_bound
    assert verdict.text.startswith(f"{word}: captured in {k} of {n} samples")


def test_every_form_counts_the_same_successes() -> None:
    """Quantile q below v is P(X < v) >= q, above v is P(X > v) >= 1 - q. Kills: q for 1 - q, <= for <."""
    table = settled([*np.arange(1.0, 100.0), math.inf])
    below = judge(require("settling_time_s", below=97, at_least=0.9), table)
    quantile = judge(require("settling_time_s", below=97, quantile=0.9), table)
    above = judge(require("settling_time_s", above=4, quantile=0.1), table)
    assert (below.successes, quantile.successes, above.successes) == (96, 96, 96)
    assert below.limit == quantile.limit == above.limit == 0.9
    assert below.quantity is None
    assert quantile.quantity is not None
    assert quantile.quantity.value == 90
    assert quantile.quantity.low < 90 < quantile.quantity.high
    assert judge(require("settling_time_s", above=4, at_least=0.9), table).successes == 96


@pytest.mark.parametrize("lost", ["not_finite", "collided"])
@pytest.mark.parametrize("side", ["above", "below"])
def test_lost_and_collided_samples_fail_everything(side: str, lost: str) -> None:
    """NaN, or any value of a sample that is not finite or collided. Kills: counting over the others only; a collided sample that
    complies, because its safety metrics are numbers."""
    numbers = [math.nan] * 20 + [5.0] * 80
    for table in (settled(numbers), settled([5.0] * 100).assign(outcome=[lost] * 20 + ["captured"] * 80)):
        verdict = judge(require("settling_time_s", quantile=0.5, **{side: 5.0 + (1 if side == "below" else -1)}), table)
        assert (verdict.successes, verdict.n) == (80, 100)
        worst = judge(require("settling_time_s", quantile=0.99 if side == "below" else 0.01, **{side: 0.0}), table)
        assert worst.quantity is not None
        assert worst.quantity.value == (math.inf if side == "below" else -math.inf)
    assert judge(require("captured", at_least=0.5), settled(numbers, lost)).successes == 0


def test_channel_is_the_worst_one_unless_named() -> None:
    """Kills: the first channel for the worst, a channel that is ignored."""
    table = captured(50, 50).assign(**{"metric.saturation_duty.fx": 0.1, "metric.saturation_duty.any": 0.3})
    duty = {"below": 0.2, "at_least": 0.9}
    assert judge(require("saturation_duty", channel="fx", **duty), table).verdict == "PASS"
    assert judge(require("saturation_duty", channel="any", **duty), table).verdict == "FAIL"
    assert judge(require("saturation_duty", **duty), table).verdict == "FAIL"


def test_every_unknown_metric_and_channel_is_named_at_once() -> None:
    """Kills: stopping at the first, a message without what is accepted."""
    table = settled([1.0]).assign(**{"metric.saturation_duty.any": 0.3})
    wrong = [
        require("settling_tim_s", below=1, at_least=0.9),
        require("saturation_duty", channel="ty", below=1, at_least=0.9),
        require("settling_time_s", channel="fx", below=1, at_least=0.9, name="quick"),
    ]
    with pytest.raises(UsageError) as caught:
        judge_all(wrong, table)
    assert str(caught.value).splitlines() == [
        "settling_tim_s: metric 'settling_tim_s' is not in the table; accepted: captured, saturation_duty, settling_time_s",
        "saturation_duty (ty): saturation_duty has no channel 'ty'; accepted: any",
        "quick: settling_time_s has no channel 'fx'; accepted: none, this metric has no channels",
    ]


def test_exit_code_prefers_failure_to_doubt() -> None:
    """Kills: 3 where one failed, 3 or 1 without requirements."""
    table = captured(58, 60)
    passed, doubted, failed = (require("captured", at_least=p) for p in (0.5, 0.95, 0.999))
    assert exit_code(judge_all([passed], table)) == 0
    assert exit_code(judge_all([passed, doubted], table)) == 3
    assert exit_code(judge_all([passed, doubted, failed], table)) == 1
    assert exit_code(judge_all([], table)) == 0


@pytest.mark.parametrize(("k", "n", "limit"), [(20, 20, 0.95), (300, 302, 0.98), (92, 100, 0.95), (0, 1, 0.9)])
def test_the_suggested_number_of_samples_is_the_first_that_decides(k: int, n: int, limit: float) -> None:
    """At the same share. Kills: the total in place of the further samples, the wrong bound."""
    verdict = judge(require("captured", at_least=limit), captured(k, n))
    assert verdict.verdict == "UNDECIDED"
    assert verdict.more is not None
    assert f"About {verdict.more:,} more samples" in verdict.text
    decided: list[bool] = []
    for total in (n + verdict.more - 1, n + verdict.more):
        successes = k / n * total
        low = oracle.beta.ppf(0.05, successes, total - successes + 1) if k else 0
        high = oracle.beta.ppf(0.95, successes + 1, total - successes) if k < n else 1
        decided.append(low >= limit or high < limit)
    assert decided == [False, True]


def test_a_finished_folder_is_judged_by_its_own_campaign(tmp_path: Path) -> None:
    """With what was set beside the file; not before every sample is there. Kills: judging what happens to be there."""
    text = (Path(__file__).parents[2] / "campaigns" / "docking-faulted.yaml").read_text()
    provenance = {"overrides": ["require=[{metric: captured, at_least: 0.6, confidence: 0.9}]"]}
    columns = {"metric.peak_chi": Column("metric.peak_chi", "1", "largest Nussbaum argument", "lower")}
    description = RunDescription(identity={}, provenance=provenance, campaign_text=text, samples=8, name="docking")
    with RunFolder.create(tmp_path / "run", description) as folder:
        for chunk in (0, 1):
            if chunk:
                with pytest.raises(IncompleteError, match="4 of 8 samples are missing"):
                    judge_folder(tmp_path / "run")
            table = captured(4, 4).assign(**{"sample": range(4 * chunk, 4 * chunk + 4), "metric.peak_chi": 0.5})
            folder.commit(chunk, table, columns)
    (verdict,) = judge_folder(tmp_path / "run")
    assert (verdict.verdict, verdict.n, verdict.limit) == ("PASS", 8, 0.6)
    assert account_and_verdicts(tmp_path / "run") == (Account(8, 8, 0, 0, 0, 0), (verdict,))
    with (tmp_path / "run" / "campaign.yaml").open("a") as file:
        file.write("# edited\n")
    with pytest.raises(FolderError, match=r"campaign\.yaml: damaged or edited"):
        judge_folder(tmp_path / "run")


def test_a_folder_with_a_sample_twice_is_not_judged(tmp_path: Path) -> None:
    """As many rows as were requested, but not of as many samples. Kills: a count of rows passed off as one of samples."""
    text = (Path(__file__).parents[2] / "campaigns" / "docking-faulted.yaml").read_text()
    provenance = {"overrides": ["require=[{metric: captured, at_least: 0.6}]"]}
    description = RunDescription(identity={}, provenance=provenance, campaign_text=text, samples=8, name="docking")
    with RunFolder.create(tmp_path / "run", description) as folder:
        for chunk in (0, 1):
            folder.commit(chunk, captured(4, 4), {})
    with pytest.raises(FolderError, match=r"chunk 1: .* is there twice"):
        judge_folder(tmp_path / "run")


def test_no_samples_and_a_share_at_the_limit_are_undecided() -> None:
    """Kills: a division by zero, an endless search."""
    nothing = judge(require("captured", at_least=0.99), captured(0, 0))
    assert (nothing.verdict, nothing.more) == ("UNDECIDED", 299)
    even = judge(require("captured", at_least=0.5), captured(50, 100))
    assert (even.verdict, even.more) == ("UNDECIDED", None)
    assert "1,000,000,000" in even.text


def test_sentence_has_the_name_the_unit_and_distinct_numbers() -> None:
    """Kills: percentages rounded until the bound seems to reach the limit."""
    table = settled([float(t) for t in range(1000)])
    columns = {"metric.settling_time_s": Column("metric.settling_time_s", "s", "time", "lower")}
    verdict = judge(require("settling_time_s", name="quick", quantile=0.9, below=940), Samples(table, columns))
    assert verdict.text == (
        "PASS: quick: settling_time_s below 940 s in 940 of 1000 samples (94.00 %). The share is at least 92.61 % and "
        "at most 95.19 %, each with 95 % confidence; 90.00 % is required. The 0.9-quantile is 899 s, at least "
        "883 s and at most 915 s, each with 95 % confidence."
    )
    tight = judge(require("captured", at_least=0.95049240), captured(59, 59))
    assert tight.verdict == "UNDECIDED"
    assert "at least 95.04923" in tight.text
    assert "95.04924000 % is required" in tight.text


def test_bounds_in_a_sentence_are_rounded_outwards() -> None:
    """Shares and quantiles, of both signs. Kills: an end rounded to the nearest digit, or towards zero."""
    generator = np.random.Generator(np.random.Philox(key=6))
    for _ in range(100):
        values = generator.choice([-1.0, 1.0]) * generator.lognormal(0, 3, int(generator.integers(300, 400)))
        limit = float(generator.uniform(0.5, 0.99))
        verdict = judge(require("settling_time_s", quantile=limit, below=float(np.quantile(values, 0.9))), settled(list(values)))
        shares, quantiles = re.findall(r"at least (\S+)(?: %)? and at most (\S+?)(?: %)?,", verdict.text)
        assert float(shares[0]) <= 100 * verdict.low_bound < float(shares[0]) + 0.01
        assert float(shares[1]) - 0.01 < 100 * verdict.high_bound <= float(shares[1])
        assert verdict.quantity is not None
        low, high = verdict.quantity.low, verdict.quantity.high
        assert low - 2e-3 * abs(low) <= float(quantiles[0]) <= low
        assert math.isinf(high) or high <= float(quantiles[1]) <= high + 2e-3 * abs(high)


def test_a_tally_that_is_fed_in_parts_says_the_same() -> None:
    """In any order and grouping; what is counted is exact, also where the quantile is read from buckets.

    Kills: a part that is not counted, a count taken from buckets, an interval narrowed by them, not finite ones left out.
    """
    generator = np.random.Generator(np.random.Philox(key=7))
    n = 30_000
    times = generator.lognormal(4.5, 1.0, n)
    outcome = generator.choice(["captured", "not_settled", "not_finite"], n, p=[0.9, 0.09, 0.01])
    times[outcome == "not_settled"] = math.inf
    table = pd.DataFrame({"sample": range(n), "outcome": outcome, "metric.settling_time_s": times})
    wanted = [
        require("settling_time_s", quantile=0.6, below=120.0),
        require("settling_time_s", quantile=0.4, above=80.0),
        require("settling_time_s", at_least=0.6, below=120.0),
        require("captured", at_least=0.9),
    ]
    whole = judge_all(wanted, table)
    for parts in (1, 7, 300):
        tallies = Tallies(wanted, Independent())
        for part in generator.permutation(parts):
            tallies.add(table.iloc[part::parts], {})
        assert tallies.verdicts() == whole
    finite = np.where(outcome == "not_finite", math.nan, times)
    exact = (np.sum(finite < 120), np.sum(finite > 80), np.sum(finite < 120), np.sum(outcome == "captured"))
    assert tuple(verdict.successes for verdict in whole) == exact
    for verdict, q, worst in ((whole[0], 0.6, math.inf), (whole[1], 0.4, -math.inf)):
        truth, found = quantile_interval(finite, q, 0.9, worst=worst), verdict.quantity
        assert found is not None
        assert found.low <= truth.low <= truth.high <= found.high
        assert abs(found.value - truth.value) <= RELATIVE_ERROR * truth.value
        assert "bucket" in found.method
