"""Verdicts: every requirement is tested: PASS, FAIL or UNDECIDED. PASS and FAIL each have a stated maximum risk of being wrong.

Most forms count the samples that comply and compare their share p with a limit p0:

    captured at least p0                success: the outcome is captured
    X below v at least p0               success: X < v
    X below v at most p1                success: not (X < v),  p0 = 1 - p1
    q-quantile of X below v             success: X < v,  p0 = q
    q-quantile of X above v             success: X > v,  p0 = 1 - q

fixed       PASS iff the Clopper-Pearson lower bound of p is >= p0, FAIL iff the upper bound is < p0: each of the two is wrong
            with probability <= 1 - confidence, for every n and every p. Judged once, when all samples are flown.
sequential  e-processes against p <= p0 and against p >= p0, looked at after every chunk: the same promise at any stopping time.
sprt        likelihood ratio of a better share p1 against p0. PASS is wrong (p <= p0) with probability <= 1 - confidence, FAIL
            says that p is below p1 and is wrong with probability <= 1 - power.

The mean of a metric is judged by empirical-Bernstein bounds if its range is stated, otherwise by an approximate interval; the
sentence says so. Only independent draws from the same law are judged: the functions take an `Independent` design. A sample that
is not finite, or whose metric is NaN, never complies. A campaign passes iff all its requirements pass, which needs no correction
of the confidence. Methods and sources: `rvjax.stats`.
"""

from rvjax.analysis.verdicts.folders import account_and_verdicts, campaign_of, judge_folder
from rvjax.analysis.verdicts.tally import Tallies, Unjudged, judge, judge_all, tallies
from rvjax.analysis.verdicts.verdict import Evidence, Verdict, exit_code, exit_code_of

__all__ = [
    "Evidence",
    "Tallies",
    "Unjudged",
    "Verdict",
    "account_and_verdicts",
    "campaign_of",
    "exit_code",
    "exit_code_of",
    "judge",
    "judge_all",
    "judge_folder",
    "tallies",
]
