"""Verdict: the result of testing a requirement."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from rvjax.campaign import Requirement
    from rvjax.stats import Estimate

Word = Literal["PASS", "FAIL", "UNDECIDED"]
Basis = Literal["counted", "proved", "accepted", "conditional", "refused", "missing"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Evidence:
    """The evidence of a sequential method at each look.

    samples, failures: (looks,) of the class so far. passing, failing: (looks,) natural logarithm of the evidence for PASS and
    for FAIL. needed_pass, needed_fail: the thresholds of the two. decided: the first look that reaches its threshold, or None.
    """

    samples: NDArray[np.int64]
    failures: NDArray[np.int64]
    passing: NDArray[np.float64]
    failing: NDArray[np.float64]
    needed_pass: float
    needed_fail: float
    decided: int | None


@dataclass(frozen=True, kw_only=True)
class RareFailure:
    """What is known of the probability p that a sample does not comply, where a search for rare failures was asked for.

    allowed: the largest accepted p. value, low, high: the estimate of the search and its nominal bounds, each one-sided at the
    requirement's confidence, conditional on every failure region of weight having been reached; None without a search.
    proved_low, proved_high: proved bounds, the upper from ordinary flights alone. replicates, flights: independent estimates of
    the search, and its flights. ordinary, failing: samples, and those that fail. refusals: why the estimate is not trusted.
    basis: what the verdict rests on (`rvjax.analysis.verdicts.rare`).
    """

    method: str
    allowed: float
    value: float | None
    low: float | None
    high: float | None
    proved_low: float
    proved_high: float
    replicates: int
    flights: int
    ordinary: int
    failing: int
    refusals: tuple[str, ...]
    basis: Basis


@dataclass(frozen=True, kw_only=True)
class Under:
    """law: the name of the law that a requirement is judged under. kept: samples of it. flown: samples of the run."""

    law: str
    kept: int
    flown: int


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """The verdict on a requirement from `n` samples.

    n: samples of its class that were tested; a sequential method counts them up to its decision. successes: samples that comply.
    limit: the required share, or the value that the mean is compared with. estimate: the share of successes, or the mean; each
    end is a one-sided bound at the requirement's confidence. quantity: the quantile of a requirement on a quantile (unit of the
    metric); each end of its interval holds at the requirement's confidence. unit: of limit and estimate. more: roughly how many
    further samples would decide, None if decided or if no number would. evidence: of a sequential method. rare: of a search for
    rare failures. under: the law that it is judged under. text: a sentence.
    """

    requirement: Requirement
    verdict: Word
    successes: int
    n: int
    limit: float
    estimate: Estimate
    quantity: Estimate | None
    more: int | None
    text: str
    unit: str = "1"
    evidence: Evidence | None = None
    rare: RareFailure | None = None
    under: Under | None = None

    @property
    def low_bound(self) -> float:
        """The lower bound of the share of successes, or of the mean."""
        return self.estimate.low

    @property
    def high_bound(self) -> float:
        """The upper bound of the share of successes, or of the mean."""
        return self.estimate.high


def exit_code(verdicts: Sequence[Verdict]) -> int:
    """0 if all pass or nothing is required, 1 if a requirement fails, 3 if none fails and some are undecided."""
    return exit_code_of(verdict.verdict for verdict in verdicts)


def exit_code_of(verdicts: Iterable[str]) -> int:
    """`exit_code` of verdicts as words."""
    words = set(verdicts)
    return 1 if "FAIL" in words else 3 if "UNDECIDED" in words else 0
