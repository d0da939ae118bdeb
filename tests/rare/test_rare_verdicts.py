"""What may be called a verdict on a rare failure: each basis, its word, its exit code and its sentence."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from rvjax.analysis.verdicts import exit_code, judge
from rvjax.analysis.verdicts.rare import conclude
from rvjax.analysis.verdicts.verdict import Verdict
from rvjax.campaign import Requirement
from rvjax.cli._output import verdict_documents
from rvjax.report.ci import junit
from rvjax.run_folder.rare_record import RareRecord
from rvjax.stats.sampling_design import Independent


def counted(allowed: float, failing: int, n: int, **keys: Any) -> Verdict:
    """The verdict from ordinary flights alone."""
    form = {"metric": "miss_m", "above": 1.0, "at_most": allowed, "method": "splitting"}
    requirement = Requirement.model_validate({**form, **keys})
    miss = np.where(np.arange(n) < failing, 2.0, 0.5)
    frame = pd.DataFrame({"sample": np.arange(n), "outcome": "captured", "metric.miss_m": miss})
    return judge(requirement, frame, Independent())


def record(p: float, refusals: tuple[str, ...] = (), spread: float = 0.2) -> RareRecord:
    """Twenty replicates around p."""
    values = p * (1.0 + spread * np.linspace(-1.5, 1.5, 20))
    return RareRecord(
        requirement=1,
        condition="not miss_m above 1",
        method="splitting",
        seed=1,
        dimension=3,
        chains=26,
        states=10,
        reached=True,
        learning=1000,
        flights=100_000,
        replicates=values.tolist(),
        levels=[],
        ordinary=1000,
        failing=0,
        weights=None,
        refusals=list(refusals),
        regions=[],
    )


@pytest.mark.parametrize(
    ("verdict", "searched", "word", "basis", "code", "words"),
    [
        (counted(1e-2, 0, 1000), record(1e-3), "PASS", "counted", 0, "The ordinary flights prove it."),
        (counted(1e-2, 0, 1000), None, "PASS", "counted", 0, "(proved)"),
        (counted(1e-6, 0, 1000), record(1e-5), "FAIL", "proved", 1, "The lower bound proves the failure."),
        (counted(1e-6, 0, 1000), record(1e-5, ("weights",)), "FAIL", "proved", 1, "proves the failure"),
        (counted(1e-6, 3, 1000), None, "FAIL", "proved", 1, "proves the failure"),
        (counted(1e-6, 0, 1000), record(1e-7), "UNDECIDED", "conditional", 3, "so an estimate is no proof"),
        (counted(1e-6, 0, 1000), record(1.02e-6), "UNDECIDED", "conditional", 3, "so an estimate is no proof"),
        (counted(1e-6, 0, 1000, accept="proof"), record(1e-7), "UNDECIDED", "conditional", 3, "no proof"),
        (counted(1e-6, 0, 1000, accept="estimate"), record(1e-7), "PASS", "accepted", 0, "Nothing is proved"),
        (counted(1e-6, 0, 1000, accept="estimate"), record(1.12e-6), "FAIL", "accepted", 1, "Nothing is proved"),
        (counted(1e-6, 0, 1000, accept="estimate"), record(1e-6), "UNDECIDED", "conditional", 3, "no proof"),
        (counted(1e-6, 0, 1000, accept="estimate"), record(0.98e-6), "UNDECIDED", "conditional", 3, "no proof"),
        (counted(1e-6, 0, 1000, accept="estimate"), record(1e-7, ("no",)), "UNDECIDED", "refused", 3, "refused: no."),
        (counted(1e-6, 0, 1000), None, "UNDECIDED", "missing", 3, "has not been flown"),
    ],
)
def test_what_a_verdict_rests_on(
    verdict: Verdict, searched: RareRecord | None, word: str, basis: str, code: int, words: str
) -> None:
    """Word, basis, exit code and sentence of every rule; the same in JSON and in JUnit. Kills: an estimate that passes unasked, a
    refused estimate that decides, a proof that a refusal hides."""
    came = conclude(verdict, searched)
    assert came.rare is not None
    assert (came.verdict, came.rare.basis) == (word, basis)
    assert exit_code([came]) == code
    assert came.text.startswith(f"{word}: ")
    assert words in came.text
    (document,) = verdict_documents([came])
    assert (document["verdict"], document["rare"]["basis"]) == (word, basis)
    (case,) = junit.of_verdicts([came])
    assert case.word == word
    assert words in case.text
    assert {"basis", "failure_allowed", "failure_proved_low", "failure_proved_high"} <= case.properties.keys()


def test_the_bounds_are_those_that_are_stated() -> None:
    """PASS at risk α by Clopper-Pearson; FAIL at α/2 each by counting and by the e-value. Kills: α twice, bounds of two sides."""
    came = conclude(counted(1e-6, 1, 5000), record(1e-4)).rare
    assert came is not None
    assert came.proved_high == pytest.approx(stats.beta.ppf(0.95, 2, 4999), rel=1e-9)
    assert came.proved_low >= stats.beta.ppf(0.025, 1, 5000) * (1 - 1e-9)
    alone = conclude(counted(1e-6, 1, 5000), None).rare
    assert alone is not None
    assert alone.proved_low == pytest.approx(stats.beta.ppf(0.025, 1, 5000), rel=1e-9)


def test_errors_of_the_verdict_of_counting_are_rare() -> None:
    """Exactly, at n = 400 and p = p₁ = 1 %: P(PASS) ≤ 5 % and P(FAIL) ≤ 2.5 % over all numbers of failures. Kills: FAIL at α."""
    n, p = 400, 0.01
    words = [conclude(counted(p, failing, n), None).verdict for failing in range(30)]
    chance = stats.binom.pmf(np.arange(30), n, p)
    assert sum(c for c, word in zip(chance, words, strict=True) if word == "PASS") <= 0.05
    assert sum(c for c, word in zip(chance, words, strict=True) if word == "FAIL") <= 0.025
    assert {"PASS", "FAIL", "UNDECIDED"} == set(words)
