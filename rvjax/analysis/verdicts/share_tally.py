"""A requirement on a share of samples, or on a quantile: counted exactly, judged once or after every chunk."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd  # pyright: ignore[reportMissingTypeStubs]

from rvjax.analysis.run_totals import AT_ONCE
from rvjax.analysis.verdicts import sentences
from rvjax.analysis.verdicts.compliance import RequirementEvaluator
from rvjax.analysis.verdicts.verdict import Evidence, Verdict, Word
from rvjax.columns import Column
from rvjax.errors import UsageError
from rvjax.stats import (
    Estimate,
    clopper_pearson_lower,
    clopper_pearson_upper,
    log_e_fail,
    log_e_pass,
    log_ratio,
    wilks_smallest_n,
)
from rvjax.stats.quantile_sketch import Sketch
from rvjax.stats.sampling_design import Independent

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rvjax.campaign import Requirement

ANYTIME = "e-process, each bound one-sided, whenever one stops"


class ShareTally:
    """How many of the samples of a class comply, chunk by chunk, and the distribution of the metric."""

    def __init__(self, requirement: Requirement, basis: Independent) -> None:
        self.requirement = requirement
        self.reading = RequirementEvaluator(requirement)
        self._basis = basis
        self._chunks: dict[int, tuple[int, int, int]] = {}
        self._sketch = Sketch()
        self._waiting: list[NDArray[np.float64]] = []
        if requirement.metric != "captured" and not (requirement.quantile or requirement.at_least or requirement.at_most):
            raise UsageError(f"{requirement.name or requirement.metric}: no share is required; accepted: at_least or quantile")

    def add(self, frame: pd.DataFrame, columns: Mapping[str, Column], begins: Sequence[int] = (0,)) -> None:
        """Counts the samples of chunks that begin at these rows; UsageError where their table lacks what it needs."""
        values, chosen = self.reading.values(frame, columns), self.reading.chosen(frame)
        if not len(frame):
            return
        counted = (np.ones(len(frame), dtype=bool), chosen, chosen & self.reading.comply(values))
        sizes = np.transpose([np.add.reduceat(one, begins, dtype=np.int64) for one in counted])
        firsts = frame["sample"].to_numpy()[list(begins)]
        found = zip(firsts.tolist(), sizes.tolist(), strict=True)
        self._chunks |= {first: (rows, of_class, complying) for first, (rows, of_class, complying) in found}
        values = values[chosen]
        if self.reading.of_metric and self.requirement.quantile is not None:
            worst = self.reading.bound.worst
            self._waiting.append(np.where(np.isnan(values), worst, values))
        if len(self._waiting) >= AT_ONCE:
            self._take_in()

    def _take_in(self) -> None:
        if self._waiting:
            self._sketch.add(np.concatenate(self._waiting))
            self._waiting = []

    def decided(self) -> bool:
        """Whether a sequential method has decided; one that is judged once never has before the end."""
        evidence = self._evidence()
        return evidence is not None and evidence.decided is not None

    def verdict(self) -> Verdict:
        """What the samples counted so far say."""
        evidence = self._evidence()
        return self._fixed() if evidence is None else self._sequential(evidence)

    def _fixed(self) -> Verdict:
        requirement = self.requirement
        n, successes = (sum(chunk[part] for chunk in self._chunks.values()) for part in (1, 2))
        estimate = self._basis.bounds(successes, n, requirement.confidence)
        word: Word = "UNDECIDED"
        if n:
            word = "PASS" if estimate.low >= requirement.limit else "FAIL" if estimate.high < requirement.limit else "UNDECIDED"
        more = fixed_more(estimate, requirement.limit) if word == "UNDECIDED" else None
        return self._stated(word, successes, estimate, self._quantity(), more)

    def _quantity(self) -> Estimate | None:
        """The quantile that is required, of all samples taken in."""
        quantile = self.requirement.quantile
        if not self.reading.of_metric or quantile is None:
            return None
        self._take_in()
        return self._basis.quantile(self._sketch, quantile, 2.0 * self.requirement.confidence - 1.0)

    def _evidence(self) -> Evidence | None:
        """The looks of a sequential method, at the ends of the chunks that lie without a gap from sample 0 on."""
        requirement, looks = self.requirement, list[tuple[int, int]]()
        if requirement.method == "fixed":
            return None
        behind, n, failures = 0, 0, 0
        for first in sorted(self._chunks):
            samples, of_class, complying = self._chunks[first]
            if first != behind:
                break
            behind, n, failures = behind + samples, n + of_class, failures + of_class - complying
            looks.append((n, failures))
        seen, failed = (np.array([look[part] for look in looks], dtype=np.int64) for part in (0, 1))
        limit, risk = requirement.limit, 1.0 - requirement.confidence
        if requirement.method == "sequential":
            passing, failing = log_e_pass(seen, failed, limit), log_e_fail(seen, failed, limit)
            needed = (-math.log(risk), -math.log(risk))
        else:
            passing = log_ratio(seen, failed, limit, requirement.design)
            failing, needed = -passing, (-math.log(risk), -math.log(1.0 - requirement.strength))
        over = (passing >= needed[0]) | (failing >= needed[1])
        decided = int(np.argmax(over)) if over.any() else None
        return Evidence(seen, failed, passing, failing, *needed, decided)

    def _sequential(self, evidence: Evidence) -> Verdict:
        at = evidence.decided if evidence.decided is not None else len(evidence.samples) - 1
        n, failures = (int(part[at]) if at >= 0 else 0 for part in (evidence.samples, evidence.failures))
        word: Word = "UNDECIDED"
        if evidence.decided is not None:
            word = "PASS" if evidence.passing[at] >= evidence.needed_pass else "FAIL"
        estimate = anytime(n, failures, self.requirement.confidence)
        more = sequential_more(self.requirement, n, failures) if word == "UNDECIDED" else None
        return self._stated(word, n - failures, estimate, None, more, evidence)

    def _stated(
        self,
        word: Word,
        successes: int,
        estimate: Estimate,
        quantity: Estimate | None,
        more: int | None,
        evidence: Evidence | None = None,
    ) -> Verdict:
        requirement = self.requirement
        text = sentences.of_share(requirement, successes, estimate, quantity, self.reading.unit)
        outlook = f" {sentences.outlook(requirement, estimate.n, more)}" if word == "UNDECIDED" else ""
        stopped = f" {sentences.stopped(requirement, evidence)}" if evidence is not None and word != "UNDECIDED" else ""
        told = f"{word}: {text}{stopped}{outlook}"
        return Verdict(requirement, word, successes, estimate.n, requirement.limit, estimate, quantity, more, told, "1", evidence)


def fixed_more(estimate: Estimate, limit: float) -> int | None:
    """How many samples more would decide if the share of successes stayed as it is; None above `words.MANY`."""
    share, n = estimate.value, estimate.n
    if not n:
        return wilks_smallest_n(limit, estimate.confidence)

    def decided(size: int) -> bool:
        if share >= limit:
            return clopper_pearson_lower(share * size, size, estimate.confidence) >= limit
        return clopper_pearson_upper(share * size, size, estimate.confidence) < limit

    return _first(lambda extra: decided(n + extra))


def sequential_more(requirement: Requirement, n: int, failures: int) -> int | None:
    """As `fixed_more`, of the e-process."""
    needed = -math.log(1.0 - requirement.confidence)

    def decided(extra: int) -> bool:
        size = n + extra
        failed = round(failures / n * size) if n else 0
        return max(float(log_e(size, failed, requirement.limit)) for log_e in (log_e_pass, log_e_fail)) >= needed

    return _first(decided) if requirement.method == "sequential" else None


def _first(holds: Callable[[int], bool]) -> int | None:
    more = bisect_left(range(sentences.MANY), True, key=holds)
    return more if more < sentences.MANY else None


def anytime(n: int, failures: int, confidence: float) -> Estimate:
    """The share of successes with two one-sided bounds that hold whenever one stops: all shares against which the e-process
    has less evidence than 1 / (1 - confidence). Without samples they are 0 and 1."""
    needed = -math.log(1.0 - confidence)

    def edge(log_e: Callable[..., NDArray[np.float64]], inside: float, outside: float) -> float:
        """The share nearest to `outside` that is still refuted, between it and `inside`; `outside` where none is."""
        for _ in range(60 if inside != outside else 0):
            middle = (inside + outside) / 2
            if float(log_e(n, failures, middle)) >= needed:
                outside = middle
            else:
                inside = middle
        return outside

    if not n:
        return Estimate(math.nan, 0.0, 1.0, 0, confidence, ANYTIME)
    share = 1.0 - failures / n
    return Estimate(share, edge(log_e_pass, share, 0.0), edge(log_e_fail, share, 1.0), n, confidence, ANYTIME)
