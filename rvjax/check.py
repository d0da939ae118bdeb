"""Verdicts: a requirement is a share of successes that must be reached, judged by exact one-sided bounds.

Every form counts successes k of n and compares the share p with a limit p0:

    captured at least p0            success: the outcome is captured
    X below v at least p0           success: X < v
    q-quantile of X below v         success: X < v,  p0 = q
    q-quantile of X above v         success: X > v,  p0 = 1 - q

PASS iff the lower bound of p is >= p0, FAIL iff its upper bound is < p0, UNDECIDED otherwise: each of the two is wrong
with probability <= 1 - confidence, for every n and every p (Clopper-Pearson). The number of samples has to be fixed
beforehand: judging again and again until it passes does not keep that promise. Samples that are no independent draws of one
law have no verdict: what judges them demands an `Independent`. A sample that is not finite, or whose metric is NaN, is a failure.
A campaign passes iff all its requirements do, which needs no correction of the confidence.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Decimal
from functools import singledispatch
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import pandas as pd  # pyright: ignore[reportMissingTypeStubs]

from rvjax import spec
from rvjax.basis import Basis, Exploration, Independent
from rvjax.columns import metric_and_channel
from rvjax.errors import IncompleteError, UsageError
from rvjax.results import CAMPAIGN, Account, Column, RunFolder, Samples
from rvjax.samplers import basis_of
from rvjax.sketch import Sketch
from rvjax.stats import (
    Estimate,
    clopper_pearson_lower,
    clopper_pearson_upper,
    wilks_smallest_n,
)
from rvjax.totals import AT_ONCE, Ledger

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rvjax.spec import Requirement, Spec

MANY = 10**9
"""More samples than this are not suggested."""


@dataclass(frozen=True)
class Verdict:
    """What `n` samples say about a requirement.

    `estimate`: the share of successes; its low and high end are one-sided bounds, each at the requirement's confidence.
    `limit`: the share that is required. `quantity`: the quantile, where the requirement is on one (unit of the metric); each
    end of its interval holds at the requirement's confidence. `more`: roughly how many further samples would decide, None
    where it is decided or no number would. `text`: one sentence.
    """

    requirement: Requirement
    verdict: Literal["PASS", "FAIL", "UNDECIDED"]
    successes: int
    n: int
    limit: float
    estimate: Estimate
    quantity: Estimate | None
    more: int | None
    text: str

    @property
    def low_bound(self) -> float:
        """The one-sided lower bound of the share of successes."""
        return self.estimate.low

    @property
    def high_bound(self) -> float:
        """The one-sided upper bound of the share of successes."""
        return self.estimate.high


class Tally:
    """How many of n independent samples comply with a requirement, counted exactly, and the distribution of its metric."""

    def __init__(self, requirement: Requirement, basis: Independent) -> None:
        self.requirement = requirement
        self._basis = basis
        self.n = self.successes = 0
        self._column: str | None = None
        self._unit = ""
        self._sketch = Sketch()
        self._waiting: list[NDArray[np.float64]] = []

    def add(self, frame: pd.DataFrame, columns: Mapping[str, Column]) -> None:
        """Counts some more samples; UsageError where their table lacks the metric or channel."""
        if self._column is None:
            self._column = _column(self.requirement, list(frame.columns))
            self._unit = columns[self._column].unit if self._column in columns else ""
        outcome: NDArray[Any] = np.asarray(frame["outcome"], dtype=object)
        if not self._column:
            success = outcome == "captured"
        else:
            values = np.where(outcome != "not_finite", np.asarray(frame[self._column], dtype=float), math.nan)
            success = _success(self.requirement, values)
            if self.requirement.quantile is not None:
                worst = math.inf if self.requirement.below is not None else -math.inf
                self._waiting.append(np.where(np.isnan(values), worst, values))
        if len(self._waiting) >= AT_ONCE:
            self._take_in()
        self.n += len(frame)
        self.successes += int(np.count_nonzero(success))

    def _take_in(self) -> None:
        if self._waiting:
            self._sketch.add(np.concatenate(self._waiting))
            self._waiting = []

    def verdict(self) -> Verdict:
        """What the samples counted so far say."""
        requirement, limit = self.requirement, _limit(self.requirement)
        estimate = self._basis.bounds(self.successes, self.n, requirement.confidence)
        verdict = "PASS" if estimate.low >= limit else "FAIL" if estimate.high < limit else "UNDECIDED"
        quantity = None
        if self._column and requirement.quantile is not None:
            self._take_in()
            quantity = self._basis.quantile(self._sketch, requirement.quantile, 2.0 * requirement.confidence - 1.0)
        more = _more(estimate, limit) if verdict == "UNDECIDED" else None
        outlook = f" {_outlook(more)}" if verdict == "UNDECIDED" else ""
        text = f"{verdict}: {_sentence(requirement, self.successes, limit, estimate, quantity, self._unit)}{outlook}"
        return Verdict(requirement, verdict, self.successes, self.n, limit, estimate, quantity, more, text)


class Tallies:
    """One fold of independent samples for several requirements."""

    def __init__(self, requirements: Iterable[Requirement], basis: Independent) -> None:
        self._tallies = tuple(Tally(requirement, basis) for requirement in requirements)

    def add(self, frame: pd.DataFrame, columns: Mapping[str, Column]) -> None:
        """Counts some more samples; UsageError names every metric or channel that their table lacks."""
        complaints: list[str] = []
        for tally in self._tallies:
            try:
                _limit(tally.requirement)
                tally.add(frame, columns)
            except UsageError as error:
                complaints.append(str(error))
        if complaints:
            raise UsageError("\n".join(complaints))

    def verdicts(self) -> tuple[Verdict, ...]:
        """What the samples counted so far say of each requirement."""
        return tuple(tally.verdict() for tally in self._tallies)


class Unjudged:
    """The fold of samples that no verdict can be issued on. UsageError where one is required of them."""

    def __init__(self, requirements: Iterable[Requirement], basis: Exploration) -> None:
        if any(True for _ in requirements):
            raise UsageError(f"{basis.sentence}; accepted: a campaign without requirements, or sampler: {{use: monte-carlo}}")

    def add(self, frame: pd.DataFrame, columns: Mapping[str, Column]) -> None:
        """Counts nothing."""

    def verdicts(self) -> tuple[Verdict, ...]:
        """None."""
        return ()


@singledispatch
def tallies(basis: Basis, requirements: Iterable[Requirement]) -> Tallies | Unjudged:
    """The fold of samples that stand on a basis: one that judges only if they are independent."""
    raise TypeError(f"{basis} is no basis")


@tallies.register(Independent)
def _(basis: Independent, requirements: Iterable[Requirement]) -> Tallies:
    return Tallies(requirements, basis)


@tallies.register(Exploration)
def _(basis: Exploration, requirements: Iterable[Requirement]) -> Unjudged:
    return Unjudged(requirements, basis)


def judge(requirement: Requirement, table: Samples | pd.DataFrame, basis: Independent) -> Verdict:
    """The verdict of a table of independent samples; UsageError where the table lacks the requirement's metric or channel."""
    return judge_all([requirement], table, basis)[0]


def judge_all(requirements: Iterable[Requirement], table: Samples | pd.DataFrame, basis: Independent) -> tuple[Verdict, ...]:
    """The verdict on each requirement; UsageError names every metric or channel that the table lacks."""
    counted = Tallies(requirements, basis)
    if isinstance(table, Samples):
        counted.add(table.frame, table.columns)
    else:
        counted.add(table, {})
    return counted.verdicts()


def campaign_of(folder: RunFolder) -> Spec:
    """The campaign of a run folder, with what was set beside the file (`overrides` of its provenance).

    FolderError where the file was changed since.
    """
    folder.campaign_text()  # verifies the file that is parsed next
    return spec.load(folder.path / CAMPAIGN, [str(item) for item in folder.provenance.get("overrides", ())])


def judge_folder(path: str | Path) -> tuple[Verdict, ...]:
    """The verdict of a finished run on each requirement of its campaign; errors as of `reckon`."""
    return reckon(path)[1]


def reckon(path: str | Path) -> tuple[Account, tuple[Verdict, ...]]:
    """How the samples of a finished run ended, and the verdict on each requirement of its campaign, in one pass.

    FolderError where the folder is none or is damaged. IncompleteError where samples are missing: a verdict on those
    that happen to be there would not keep its promise.
    """
    folder = RunFolder.open(path)
    if missing := folder.requested - sum(chunk.count for chunk in folder.chunks):
        raise IncompleteError(
            f"{path}: {missing} of {folder.requested} samples are missing; `rvjax run` with the same --out flies them"
        )
    campaign, ledger = campaign_of(folder), Ledger()
    counted = tallies(basis_of(campaign), campaign.require)
    for chunk, frame, columns in folder.tables():
        ledger.add(chunk, frame, columns)
        counted.add(frame, columns)
    return ledger.account(folder.requested), counted.verdicts()


def exit_code(verdicts: Sequence[Verdict]) -> int:
    """0 where all pass or nothing is required, 1 where one fails, 3 where none fails and one is undecided."""
    words = {verdict.verdict for verdict in verdicts}
    return 1 if "FAIL" in words else 3 if "UNDECIDED" in words else 0


# --- from a requirement to a share ----------------------------------------------------------------------------------


def _column(requirement: Requirement, columns: Sequence[str]) -> str:
    """The column that a requirement is on; empty for the outcome."""
    metric, channel = requirement.metric, requirement.channel
    known = [metric_and_channel(name.removeprefix("metric.")) for name in columns if name.startswith("metric.")]
    metrics = sorted({"captured"} | {name for name, _ in known})
    channels = [own for name, own in known if name == metric and own]
    if metric not in metrics:
        accepted = ", ".join(metrics)
        raise UsageError(f"{_label(requirement)}: metric {metric!r} is not in the table; accepted: {accepted}")
    if channels and (channel or "any") in channels:
        return f"metric.{metric}.{channel or 'any'}"
    if channel is None and not channels:
        return "" if metric == "captured" else f"metric.{metric}"
    accepted = ", ".join(channels) or "none, it has one value for all"
    raise UsageError(f"{_label(requirement)}: {metric} has no channel {channel or 'any'!r}; accepted: {accepted}")


def _success(requirement: Requirement, values: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which values are successes (NaN never is)."""
    if requirement.below is not None:
        return values < requirement.below
    if requirement.above is not None:
        return values > requirement.above
    raise UsageError(f"{_label(requirement)}: nothing to compare {requirement.metric} with; accepted: below or above")


def _limit(requirement: Requirement) -> float:
    """The share of successes that is required."""
    if requirement.quantile is not None:
        return requirement.quantile if requirement.below is not None else 1 - requirement.quantile
    if requirement.at_least is None:
        raise UsageError(f"{_label(requirement)}: no share is required; accepted: at_least or quantile")
    return requirement.at_least


def _more(estimate: Estimate, limit: float) -> int | None:
    """How many samples more would decide if the share of successes stayed as it is; None above `MANY`."""
    share, n = estimate.value, estimate.n
    if not n:
        return wilks_smallest_n(limit, estimate.confidence)

    def decided(size: int) -> bool:
        if share >= limit:
            return clopper_pearson_lower(share * size, size, estimate.confidence) >= limit
        return clopper_pearson_upper(share * size, size, estimate.confidence) < limit

    more = bisect_left(range(MANY), True, key=lambda extra: decided(n + extra))
    return more if more < MANY else None


# --- words ----------------------------------------------------------------------------------------------------------


def _label(requirement: Requirement) -> str:
    channel = f" ({requirement.channel})" if requirement.channel else ""
    return requirement.name or requirement.metric + channel


def _sentence(
    requirement: Requirement, successes: int, limit: float, share: Estimate, quantity: Estimate | None, unit: str
) -> str:
    side, value = ("below", requirement.below) if requirement.below is not None else ("above", requirement.above)
    name = f"{requirement.name}: " if requirement.name else ""
    channel = f" ({requirement.channel})" if requirement.channel else ""
    threshold = "" if value is None else f" {side} {_number(value, unit)}"
    percent = _percentages(limit, share)
    observed = f" ({percent[3]})" if share.n else ""
    confidence = f"with {100 * share.confidence:.6g} % confidence"
    text = (
        f"{name}{requirement.metric}{channel}{threshold} in {successes} of {share.n} samples{observed}. "
        f"The share is at least {percent[1]} and at most {percent[2]}, each {confidence}; required is {percent[0]}."
    )
    if quantity is not None:
        low, high = _number(quantity.low, unit, ROUND_FLOOR), _number(quantity.high, unit, ROUND_CEILING)
        middle = _number(quantity.value, unit)
        text += f" The {requirement.quantile:g}-quantile is {middle}; at least {low} and at most {high}, each {confidence}."
    return text


def _outlook(more: int | None) -> str:
    if more is None:
        return f"The share is so close to what is required that more than {MANY:,} further samples would be needed."
    return f"About {more:,} more samples would decide if the share stayed the same."


def _percentages(limit: float, share: Estimate) -> list[str]:
    """The limit, the share's lower bound, rounded down, its upper one, rounded up, and its value in percent.

    With the decimals (2 to 8) that it takes to tell them from the limit.
    """
    gaps = [abs(100 * (end - limit)) for end in (share.low, share.high, share.value) if abs(end - limit) > 1e-9]
    place = Decimal(1).scaleb(-min(max([2, *(math.ceil(-math.log10(gap)) + 1 for gap in gaps)]), 8))
    ends = ((limit, ROUND_HALF_EVEN), (share.low, ROUND_FLOOR), (share.high, ROUND_CEILING), (share.value, ROUND_HALF_EVEN))
    return [f"{_rounded(100 * end, place, way)} %" for end, way in ends if not math.isnan(end)]


def _rounded(value: float, place: Decimal, way: str) -> Decimal:
    """A number to a decimal place; what the 15th digit of it is off by is no reason to go one further."""
    return Decimal(f"{value:.14g}").quantize(place, rounding=way)


def _number(value: float, unit: str, way: str = ROUND_HALF_EVEN) -> str:
    """A number to four digits with its unit."""
    if value and math.isfinite(value):
        value = float(_rounded(value, Decimal(1).scaleb(math.floor(math.log10(abs(value))) - 3), way))
    return f"{value:.4g} {unit}" if unit not in ("", "1") else f"{value:.4g}"
