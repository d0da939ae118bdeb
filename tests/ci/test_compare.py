"""`rvjax compare`: two runs on the same draws, pair by pair."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from rvjax.analysis.compare import compare
from rvjax.errors import UsageError
from rvjax.run_folder import RunFolder
from tests.ci.altered import Change, after
from tests.program import Run


def lost(before: Path, count: int) -> Change:
    """So many of the captured samples are not captured any more."""
    captured = np.flatnonzero(RunFolder.open(before).samples().frame["outcome"] == "captured")[:count]

    def change(frame: pd.DataFrame) -> Mapping[str, object]:
        words = frame["outcome"].to_numpy().copy()
        words[captured] = "not_settled"
        return {"outcome": words}

    return change


def test_a_run_beside_itself(before: Path) -> None:
    """Kills: p below 1 without a difference, PASS without a margin, a shift of nothing."""
    found = compare(before, before)
    assert {(one.verdict, one.p_exact, one.word) for one in found.changes} == {("UNDECIDED", 1.0, "no difference shown")}
    assert found.apart == 0
    assert all(one.shift.value == 0.0 or one.a == one.b == np.inf for one in found.shifts)
    wide = compare(before, before, margin=0.05)
    assert {one.verdict for one in wide.changes} == {"PASS"}


def test_a_run_that_collides(before: Path, tmp_path: Path) -> None:
    """150 of 200 flights collide with the numbers that they had. Kills: a collision that is no outcome, or has numbers."""

    def change(frame: pd.DataFrame) -> Mapping[str, object]:
        return {"outcome": np.where(np.arange(200) < 150, "collided", frame["outcome"])}

    one = compare(before, after(before, tmp_path / "run", change))
    assert one.changes[0].verdict == "FAIL"
    assert "collided" in {case.outcome_b for case in one.discordant}
    assert {shift.b for shift in one.shifts if shift.metric == "delta_v_m_s"} == {np.inf}


@pytest.mark.parametrize(("count", "plain", "with_margin"), [(3, "UNDECIDED", "PASS"), (30, "FAIL", "FAIL")])
def test_captures_lost(before: Path, tmp_path: Path, count: int, plain: str, with_margin: str) -> None:
    """McNemar by SciPy. Kills: A and B swapped, all samples in the place of those that differ, a margin of the other sign."""
    run = after(before, tmp_path / "run", lost(before, count))
    one = compare(before, run).changes[0]
    assert one.name == "captured"
    assert (one.pairs.only_a, one.pairs.only_b) == (count, 0)
    assert one.p_exact == pytest.approx(stats.binomtest(0, count, 0.5).pvalue)
    assert one.difference.value == pytest.approx(-count / 200)
    assert one.verdict == plain
    assert compare(before, run, margin=0.05).changes[0].verdict == with_margin
    back = compare(run, before).changes[0]
    assert back.word == ("better" if count == 30 else "no difference shown")
    listed = compare(before, run, shown=2)
    assert (listed.apart, len(listed.discordant)) == (count, 2)
    assert listed.discordant[0].lost[0] == "captured"


def test_a_margin_is_missed_as_seldom_as_promised() -> None:
    """P(PASS) where the share is smaller by just the margin, summed over all that 30 pairs can do. Kills: a two-sided test's
    limit for a one-sided one, the margin added on the wrong side."""
    from rvjax.stats import Pairs, noninferiority_exact

    n, margin, wrong = 30, 0.1, 0.0
    for only_a in range(n + 1):
        for only_b in range(n + 1 - only_a):
            p = stats.multinomial.pmf([only_a, only_b, n - only_a - only_b], n, [0.15, 0.05, 0.8])
            if p > 1e-12 and noninferiority_exact(Pairs(n - only_a - only_b, only_b, only_a, 0), margin) <= 0.05:
                wrong += p
    assert 0.03 < wrong <= 0.05


def test_fail_is_as_rare_where_b_alone_never_succeeds() -> None:
    """P(FAIL) at a difference of just the margin, 300 pairs of which 1 % comply with A alone, none with B alone, where the score
    test by itself is wrong too often. Kills: the score test for the exact test."""
    from rvjax.analysis.compare import _p_worse
    from rvjax.stats import Pairs

    n, margin = 300, 0.01
    chances = [stats.binom.pmf(k, n, margin) for k in range(40)]
    wrong = sum(p for k, p in enumerate(chances) if _p_worse(Pairs(n - k, k, 0, 0), margin) <= 0.05)
    assert 0.01 < wrong <= 0.05


def test_other_draws_and_other_sizes_are_refused(before: Path, tmp_path: Path, made: Callable[..., Path]) -> None:
    """Kills: comparing samples that have nothing to do with each other."""
    run = after(before, tmp_path / "run", lambda frame: {"draw.pursuer.mass_kg": np.nextafter(frame["draw.pursuer.mass_kg"], 0)})
    with pytest.raises(UsageError, match=r"not on the same draws: draw\.pursuer\.mass_kg \(sample 0: "):
        compare(before, run)
    fewer = made(tmp_path / "fewer", 100, kept=0)
    with pytest.raises(UsageError, match="accepted: the same number, or --common to compare the first 100"):
        compare(before, fewer)
    for wrong in ({"margin": -0.1}, {"confidence": 1.0}, {"quantiles": [("delta_v_m_s", 1.0)]}, {"quantiles": [("x", 0.5)]}):
        with pytest.raises(UsageError, match="accepted: "):
            compare(before, before, **wrong)  # pyright: ignore


def test_the_command(before: Path, tmp_path: Path, rvjax: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: exit codes mixed up, a command that does not say how to fly a sample again, a table that does not fit."""
    run = after(before, tmp_path / "run", lost(before, 30))
    assert rvjax("compare", before, before, "--margin", 0.05)[0] == 0
    assert rvjax("compare", before, before)[0] == 3
    code, out, _ = rvjax("compare", before, run, "--metric", "delta_v_m_s:0.9")
    assert code == 1
    assert f"rvjax replay {run} --sample " in out
    assert "delta_v_m_s, 90 %" in out
    assert "30 samples tell A from B" in out
    code, out, _ = rvjax("compare", before, run, "--json")
    assert code == 1
    assert json.loads(out)["changes"][0]["pairs"] == [150, 30, 0, 20]
    code, _, err = rvjax("compare", before)
    assert code == 2
    assert "give two run folders" in err
    code, _, err = rvjax("compare", before, "--baseline", "x")
    assert code == 2
    assert "this run has no baselines" in err
    assert rvjax("compare", before, before, "--metric", "x")[0] == 2
    monkeypatch.setenv("COLUMNS", "60")
    assert max(map(len, rvjax("compare", before, before)[1].splitlines()[6:])) <= 60
