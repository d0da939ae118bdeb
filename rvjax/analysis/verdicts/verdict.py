"""What a judgement comes to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from rvjax.campaign import Requirement
    from rvjax.stats import Estimate

Word = Literal["PASS", "FAIL", "UNDECIDED"]


@dataclass(frozen=True, eq=False)
class Evidence:
    """What a sequential method has seen, look by look.

    samples, failures: (looks,) of the class so far. passing, failing: (looks,) natural logarithm of the evidence for PASS, and
    for FAIL. needed_pass, needed_fail: what each has to reach. decided: the look at which it did; None where neither has.
    """

    samples: NDArray[np.int64]
    failures: NDArray[np.int64]
    passing: NDArray[np.float64]
    failing: NDArray[np.float64]
    needed_pass: float
    needed_fail: float
    decided: int | None


@dataclass(frozen=True)
class Verdict:
    """What `n` samples say about a requirement.

    n: samples of its class that were looked at, of a sequential method up to its decision. successes: those that comply.
    limit: the share that is required, or the value that the mean is compared with. estimate: of the share of successes, or of
    the mean; its low and high end are one-sided bounds, each at the requirement's confidence. quantity: the quantile, where the
    requirement is on one (unit of the metric); each end of its interval holds at the requirement's confidence. unit: of limit
    and estimate. more: roughly how many further samples would decide, None where it is decided or no number would. evidence: of
    a sequential method. text: one sentence.
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

    @property
    def low_bound(self) -> float:
        """The one-sided lower bound of the share of successes, or of the mean."""
        return self.estimate.low

    @property
    def high_bound(self) -> float:
        """The one-sided upper bound of the share of successes, or of the mean."""
        return self.estimate.high


def exit_code(verdicts: Sequence[Verdict]) -> int:
    """0 where all pass or nothing is required, 1 where one fails, 3 where none fails and one is undecided."""
    words = {verdict.verdict for verdict in verdicts}
    return 1 if "FAIL" in words else 3 if "UNDECIDED" in words else 0
