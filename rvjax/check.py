"""Verdicts: a requirement is a share of successes that must be reached, judged by exact one-sided bounds.

Every form counts successes k of n and compares the share p with a limit p0:

    captured at least p0            success: the outcome is captured
    X below v at least p0           success: X < v
    q-quantile of X below v         success: X < v,  p0 = q
    q-quantile of X above v         success: X > v,  p0 = 1 - q

PASS iff the lower bound of p is >= p0, FAIL iff its upper bound is < p0, UNDECIDED otherwise: each of the two is wrong
with probability <= 1 - confidence, for every n and every p (Clopper-Pearson). The number of samples has to be fixed
beforehand: judging again and again until it passes does not keep that promise. A sample that is not finite, or whose
metric is NaN, is a failure. A campaign passes iff all its requirements do, which needs no correction of the confidence.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import pandas as pd  # pyright: ignore[reportMissingTypeStubs]

from rvjax import spec
from rvjax.errors import IncompleteError, UsageError
from rvjax.results import CAMPAIGN, RunFolder, Samples
from rvjax.stats import (
    Estimate,
    clopper_pearson_lower,
    clopper_pearson_upper,
    quantile_interval,
    wilks_smallest_n,
)

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


def judge(requirement: Requirement, table: Samples | pd.DataFrame) -> Verdict:
    """The verdict of a samples table on one requirement; UsageError where the table lacks its metric or channel."""
    frame = table.frame if isinstance(table, Samples) else table
    column = _column(requirement, list(frame.columns))
    unit = table.columns[column].unit if isinstance(table, Samples) and column else ""
    outcome: NDArray[Any] = np.asarray(frame["outcome"], dtype=object)
    values: NDArray[np.float64] | None = None
    if not column:
        success, limit = outcome == "captured", requirement.at_least
    else:
        values = np.where(outcome != "not_finite", np.asarray(frame[column], dtype=float), math.nan)
        success, limit = _compare(requirement, values)
    if limit is None:
        raise UsageError(f"{_label(requirement)}: no share is required; accepted: at_least or quantile")
    n, k = len(frame), int(np.count_nonzero(success))
    estimate = _share(k, n, requirement.confidence)
    verdict = "PASS" if estimate.low >= limit else "FAIL" if estimate.high < limit else "UNDECIDED"
    quantity = None
    if values is not None and requirement.quantile is not None:
        worst = math.inf if requirement.below is not None else -math.inf
        quantity = quantile_interval(values, requirement.quantile, 2.0 * requirement.confidence - 1.0, worst=worst)
    more = _more(estimate, limit) if verdict == "UNDECIDED" else None
    outlook = f" {_outlook(more)}" if verdict == "UNDECIDED" else ""
    text = f"{verdict}: {_sentence(requirement, k, limit, estimate, quantity, unit)}{outlook}"
    return Verdict(requirement, verdict, k, n, limit, estimate, quantity, more, text)


def judge_all(requirements: Iterable[Requirement], table: Samples | pd.DataFrame) -> tuple[Verdict, ...]:
    """The verdict on each requirement; UsageError names every metric or channel that the table lacks."""
    verdicts: list[Verdict] = []
    complaints: list[str] = []
    for requirement in requirements:
        try:
            verdicts.append(judge(requirement, table))
        except UsageError as error:
            complaints.append(str(error))
    if complaints:
        raise UsageError("\n".join(complaints))
    return tuple(verdicts)


def campaign_of(folder: RunFolder) -> Spec:
    """The campaign of a run folder, with what was set beside the file (`overrides` of its provenance).

    FolderError where the file was changed since.
    """
    folder.campaign_text()  # verifies the file that is parsed next
    return spec.load(folder.path / CAMPAIGN, [str(item) for item in folder.provenance.get("overrides", ())])


def judge_folder(path: str | Path) -> tuple[Verdict, ...]:
    """The verdict of a finished run on each requirement of its campaign.

    FolderError where the folder is none or is damaged. IncompleteError where samples are missing: a verdict on those
    that happen to be there would not keep its promise.
    """
    folder = RunFolder.open(path)
    if missing := folder.account().missing:
        raise IncompleteError(
            f"{path}: {missing} of {folder.requested} samples are missing; `rvjax run` with the same --out flies them"
        )
    return judge_all(campaign_of(folder).require, folder.samples())


def exit_code(verdicts: Sequence[Verdict]) -> int:
    """0 where all pass or nothing is required, 1 where one fails, 3 where none fails and one is undecided."""
    words = {verdict.verdict for verdict in verdicts}
    return 1 if "FAIL" in words else 3 if "UNDECIDED" in words else 0


# --- from a requirement to a share ----------------------------------------------------------------------------------


def _column(requirement: Requirement, columns: Sequence[str]) -> str:
    """The column that a requirement is on; empty for the outcome."""
    metric, channel = requirement.metric, requirement.channel
    metrics = sorted({"captured"} | {name.split(".")[1] for name in columns if name.startswith("metric.")})
    channels = [name.split(".", 2)[2] for name in columns if name.startswith(f"metric.{metric}.")]
    if metric not in metrics:
        accepted = ", ".join(metrics)
        raise UsageError(f"{_label(requirement)}: metric {metric!r} is not in the table; accepted: {accepted}")
    if channels and (channel or "any") in channels:
        return f"metric.{metric}.{channel or 'any'}"
    if channel is None and not channels:
        return "" if metric == "captured" else f"metric.{metric}"
    accepted = ", ".join(channels) or "none, it has one value for all"
    raise UsageError(f"{_label(requirement)}: {metric} has no channel {channel or 'any'!r}; accepted: {accepted}")


def _compare(requirement: Requirement, values: NDArray[np.float64]) -> tuple[NDArray[np.bool_], float | None]:
    """Which values are successes (NaN never is), and the share of them that is required."""
    quantile = requirement.quantile
    if requirement.below is not None:
        return values < requirement.below, requirement.at_least if quantile is None else quantile
    if requirement.above is not None:
        return values > requirement.above, requirement.at_least if quantile is None else 1 - quantile
    raise UsageError(f"{_label(requirement)}: nothing to compare {requirement.metric} with; accepted: below or above")


def _share(successes: int, n: int, confidence: float) -> Estimate:
    low, high = clopper_pearson_lower(successes, n, confidence), clopper_pearson_upper(successes, n, confidence)
    value = successes / n if n else math.nan
    return Estimate(value, low, high, n, confidence, "Clopper-Pearson, each bound one-sided")


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
    percent = _percentages(limit, share.low, share.high, share.value)
    observed = f" ({percent[3]})" if share.n else ""
    confidence = f"with {100 * share.confidence:.6g} % confidence"
    text = (
        f"{name}{requirement.metric}{channel}{threshold} in {successes} of {share.n} samples{observed}. "
        f"The share is at least {percent[1]} and at most {percent[2]}, each {confidence}; required is {percent[0]}."
    )
    if quantity is not None:
        low, middle, high = (_number(number, unit) for number in (quantity.low, quantity.value, quantity.high))
        text += f" The {requirement.quantile:g}-quantile is {middle}; at least {low} and at most {high}, each {confidence}."
    return text


def _outlook(more: int | None) -> str:
    if more is None:
        return f"The share is so close to what is required that more than {MANY:,} further samples would be needed."
    return f"About {more:,} more samples would decide if the share stayed the same."


def _percentages(limit: float, *shares: float) -> list[str]:
    """The limit and the shares in percent, with the decimals (2 to 8) that it takes to tell them apart."""
    gaps = [abs(100 * (share - limit)) for share in shares if abs(share - limit) > 1e-9]
    digits = max([2, *(math.ceil(-math.log10(gap)) + 1 for gap in gaps)])
    return [f"{100 * share:.{min(digits, 8)}f} %" for share in (limit, *shares)]


def _number(value: float, unit: str) -> str:
    return f"{value:.4g} {unit}" if unit not in ("", "1") else f"{value:.4g}"
