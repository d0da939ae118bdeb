"""A requirement on a share of samples, or on a quantile: exact counts, judged at the end or after every chunk."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd  # pyright: ignore[reportMissingTypeStubs]

from rvjax.analysis.run_totals import AT_ONCE, sketch_of
from rvjax.analysis.verdicts import sentences
from rvjax.analysis.verdicts.compliance import RequirementEvaluator
from rvjax.analysis.verdicts.rare import conclude
from rvjax.analysis.verdicts.verdict import Evidence, Under, Verdict, Word
from rvjax.columns import Column
from rvjax.errors import UsageError
from rvjax.run_folder.named_arrays import Record
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

_COUNTS = ("rows", "kept", "of_class", "complying")
"""What is counted of a chunk."""

ANYTIME = "e-process, one-sided bounds, valid at any stopping time"


class ShareTally:
    """How many samples of a class comply, and the distribution of the metric, chunk by chunk in any order."""

    def __init__(self, requirement: Requirement, design: Independent) -> None:
        self.requirement = requirement
        self.evaluator = RequirementEvaluator(requirement)
        self._design = design
        self._chunks: dict[int, tuple[int, int, int, int]] = {}
        self._sketch = Sketch()
        self._waiting: list[NDArray[np.float64]] = []
        if requirement.metric != "captured" and not (requirement.quantile or requirement.at_least or requirement.at_most):
            raise UsageError(f"{requirement.name or requirement.metric}: no share is required; accepted: at_least or quantile")

    def add(self, frame: pd.DataFrame, columns: Mapping[str, Column], begins: Sequence[int] = (0,)) -> None:
        """Counts the samples of chunks, which begin at the rows `begins`. UsageError if the table lacks a column it needs."""
        values, kept = self.evaluator.values(frame, columns), self.evaluator.kept(frame)
        chosen = kept & self.evaluator.of_class(frame)
        if not len(frame):
            return
        masks = (np.ones(len(frame), dtype=bool), kept, chosen, chosen & self.evaluator.comply(values))
        sizes = np.transpose([np.add.reduceat(mask, begins, dtype=np.int64) for mask in masks])
        firsts = frame["sample"].to_numpy()[list(begins)]
        counts = zip(firsts.tolist(), sizes.tolist(), strict=True)
        self._chunks |= {first: (rows, kept, of_class, complying) for first, (rows, kept, of_class, complying) in counts}
        values = values[chosen]
        if self.evaluator.of_metric and self.requirement.quantile is not None:
            worst = self.evaluator.bound.worst
            self._waiting.append(np.where(np.isnan(values), worst, values))
        if len(self._waiting) >= AT_ONCE:
            self._take_in()

    def _take_in(self) -> None:
        if self._waiting:
            self._sketch.add(np.concatenate(self._waiting))
            self._waiting = []

    def merge(self, other: ShareTally) -> None:
        """Counts the chunks of another tally of the same requirement; ValueError if a chunk is in both."""
        if common := self._chunks.keys() & other._chunks.keys():
            raise ValueError(f"the chunk from sample {min(common)} on is counted twice")
        self._take_in()
        other._take_in()
        self._chunks |= other._chunks
        self._sketch.merge(other._sketch)

    def record(self) -> Record:
        """All counts, for `restore`."""
        self._take_in()
        firsts = sorted(self._chunks)
        counts = np.array([self._chunks[first] for first in firsts], np.int64).reshape(-1, len(_COUNTS))
        chunks = {"first": np.array(firsts, np.int64)} | {name: counts[:, part] for part, name in enumerate(_COUNTS)}
        return Record.joined({"chunks": Record.of_numbers(chunks), "sketch": Record.of_numbers(self._sketch.arrays())})

    def restore(self, record: Record, firsts: Sequence[int]) -> None:
        """Takes over the counts of a record. firsts: the first samples of its chunks. ValueError if it contradicts itself or
        these."""
        chunks = record.part("chunks")
        rows, kept, of_class, complying = (chunks.numbers(name) for name in _COUNTS)
        if chunks.numbers("first").tolist() != list(firsts):
            raise ValueError("a requirement that counts other chunks")
        if not (np.all(complying >= 0) and np.all(of_class >= complying) and np.all(kept >= of_class) and np.all(rows >= kept)):
            raise ValueError("a requirement whose counts contradict each other")
        counts = zip(rows.tolist(), kept.tolist(), of_class.tolist(), complying.tolist(), strict=True)
        self._chunks = dict(zip(firsts, counts, strict=True))
        self._sketch = sketch_of(record.part("sketch"))
        if self._sketch.n not in (0, int(of_class.sum())):
            raise ValueError(f"a requirement with {self._sketch.n} values for {int(of_class.sum())} samples")

    def decided(self) -> bool:
        """Whether a sequential method has decided. A fixed number of samples is judged at the end only."""
        evidence = self._evidence()
        return evidence is not None and evidence.decided is not None

    def verdict(self) -> Verdict:
        """The verdict from the samples counted so far."""
        evidence = self._evidence()
        verdict = self._fixed() if evidence is None else self._sequential(evidence)
        return conclude(verdict, None) if self.requirement.is_rare else verdict

    def _fixed(self) -> Verdict:
        requirement = self.requirement
        flown, kept, n, successes = (sum(chunk[part] for chunk in self._chunks.values()) for part in range(len(_COUNTS)))
        estimate = self._design.bounds(successes, n, requirement.confidence)
        word: Word = "UNDECIDED"
        if n:
            word = "PASS" if estimate.low >= requirement.limit else "FAIL" if estimate.high < requirement.limit else "UNDECIDED"
        more = fixed_more(estimate, requirement.limit) if word == "UNDECIDED" else None
        return self._stated(word, successes, estimate, self._quantity(), more, self._under(kept, flown))

    def _under(self, kept: int, flown: int) -> Under | None:
        """The law that the requirement is judged under."""
        law = self.requirement.under
        return None if law is None else Under(law=law, kept=kept, flown=flown)

    def _quantity(self) -> Estimate | None:
        """The estimate of the required quantile from all samples."""
        quantile = self.requirement.quantile
        if not self.evaluator.of_metric or quantile is None:
            return None
        self._take_in()
        return self._design.quantile(self._sketch, quantile, 2.0 * self.requirement.confidence - 1.0)

    def _evidence(self) -> Evidence | None:
        """The evidence of a sequential method after each chunk, as far as the chunks have no gap from sample 0 on."""
        requirement, looks = self.requirement, list[tuple[int, int]]()
        if not requirement.is_sequential:
            return None
        behind, n, failures = 0, 0, 0
        for first in sorted(self._chunks):
            samples, _, of_class, complying = self._chunks[first]
            if first != behind:
                break
            behind, n, failures = behind + samples, n + of_class, failures + of_class - complying
            looks.append((n, failures))
        tested, failed = (np.array([look[part] for look in looks], dtype=np.int64) for part in (0, 1))
        limit, risk = requirement.limit, 1.0 - requirement.confidence
        if requirement.method == "sequential":
            passing, failing = log_e_pass(tested, failed, limit), log_e_fail(tested, failed, limit)
            needed = (-math.log(risk), -math.log(risk))
        else:
            passing = log_ratio(tested, failed, limit, requirement.design)
            failing, needed = -passing, (-math.log(risk), -math.log(1.0 - requirement.strength))
        over = (passing >= needed[0]) | (failing >= needed[1])
        decided = int(np.argmax(over)) if over.any() else None
        return Evidence(
            samples=tested,
            failures=failed,
            passing=passing,
            failing=failing,
            needed_pass=needed[0],
            needed_fail=needed[1],
            decided=decided,
        )

    def _sequential(self, evidence: Evidence) -> Verdict:
        at = evidence.decided if evidence.decided is not None else len(evidence.samples) - 1
        n, failures = (int(part[at]) if at >= 0 else 0 for part in (evidence.samples, evidence.failures))
        word: Word = "UNDECIDED"
        if evidence.decided is not None:
            word = "PASS" if evidence.passing[at] >= evidence.needed_pass else "FAIL"
        estimate = anytime(n, failures, self.requirement.confidence)
        more = sequential_more(self.requirement, n, failures) if word == "UNDECIDED" else None
        looked = sorted(self._chunks)[: at + 1]
        flown, kept = (sum(self._chunks[first][part] for first in looked) for part in (0, 1))
        return self._stated(word, n - failures, estimate, None, more, self._under(kept, flown), evidence)

    def _stated(
        self,
        word: Word,
        successes: int,
        estimate: Estimate,
        quantity: Estimate | None,
        more: int | None,
        under: Under | None,
        evidence: Evidence | None = None,
    ) -> Verdict:
        requirement, n = self.requirement, estimate.n
        if under is not None:
            n, more = under.flown, _flights(more, under)
        text = sentences.of_share(requirement, successes, estimate, quantity, self.evaluator.unit, under)
        outlook = f" {sentences.outlook(requirement, n, more)}" if word == "UNDECIDED" else ""
        stopped = f" {sentences.stopped(requirement, evidence)}" if evidence is not None and word != "UNDECIDED" else ""
        return Verdict(
            requirement=requirement,
            verdict=word,
            successes=successes,
            n=estimate.n,
            limit=requirement.limit,
            estimate=estimate,
            quantity=quantity,
            more=more,
            text=f"{word}: {text}{stopped}{outlook}",
            evidence=evidence,
            under=under,
        )


def _flights(more: int | None, under: Under) -> int | None:
    """The flights that are needed for `more` samples of a law; None above `sentences.MANY`."""
    if more is None or not under.kept:
        return None
    flights = math.ceil(more * under.flown / under.kept)
    return flights if flights < sentences.MANY else None


def fixed_more(estimate: Estimate, limit: float) -> int | None:
    """How many further samples would decide if the share of successes stayed the same; None above `sentences.MANY`."""
    share, n = estimate.value, estimate.n
    if not n:
        return wilks_smallest_n(limit, estimate.confidence)

    def decided(size: int) -> bool:
        if share >= limit:
            return clopper_pearson_lower(share * size, size, estimate.confidence) >= limit
        return clopper_pearson_upper(share * size, size, estimate.confidence) < limit

    return _first(lambda extra: decided(n + extra))


def sequential_more(requirement: Requirement, n: int, failures: int) -> int | None:
    """As `fixed_more`, for the e-process."""
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
    """The share of successes and its two one-sided bounds, valid at any stopping time.

    They enclose all shares against which the e-process has less evidence than 1 / (1 - confidence). Without samples they are 0
    and 1.
    """
    needed = -math.log(1.0 - confidence)

    def edge(log_e: Callable[..., NDArray[np.float64]], inside: float, outside: float) -> float:
        """The rejected share nearest to `inside`, by bisection towards `outside`; `outside` if no share is rejected."""
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
