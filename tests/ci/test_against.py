"""A run against a baseline: the same bits never fail, what is worse does, and only the same draws are compared."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from rvjax import against
from rvjax.errors import UsageError
from rvjax.results import RunFolder

Change = Callable[[pd.DataFrame], Mapping[str, object]]


@pytest.fixture(scope="module")
def before(made: Callable[..., Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two hundred samples."""
    return made(tmp_path_factory.mktemp("before") / "run", 200, (0.9, 0.08, 0.02), kept=0)


@pytest.fixture(scope="module")
def baseline(before: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Of that run."""
    path = tmp_path_factory.mktemp("baseline") / "b.json"
    against.write(before, path)
    return path


def after(before: Path, place: Path, change: Change) -> Path:
    """The same run with other columns."""
    old = RunFolder.open(before)
    shutil.rmtree(place, ignore_errors=True)
    with RunFolder.create(place, old.identity, old.provenance, old.campaign_text(), old.requested, old.name) as folder:
        for chunk, frame, columns in old.tables():
            folder.commit(chunk, frame.assign(**change(frame)), columns)
    return place


def found(folder: Path, baseline: Path) -> dict[str, against.Comparison]:
    """The comparisons by what they are of."""
    return {one.what: one for one in against.against(folder, baseline)}


def test_the_same_run_is_no_worse_in_anything(before: Path, baseline: Path) -> None:
    """Kills: p below 1 without a difference; a metric or a requirement that is not compared."""
    same = found(before, baseline)
    assert {(one.worse, one.better, one.p) for one in same.values()} == {(0, 0, 1.0)}
    assert {"settling_time_s", "window_position_error_m", "delta_v_m_s"} <= same.keys()
    assert sum(name[0].isdigit() for name in same) == 3


def test_last_digits_do_not_count(before: Path, baseline: Path, tmp_path: Path) -> None:
    """As of another compiler. Kills: a sign test on any difference, which 200 equal signs would fail."""
    run = after(before, tmp_path / "run", lambda frame: {"metric.delta_v_m_s": frame["metric.delta_v_m_s"] * 1.004})
    assert found(run, baseline)["delta_v_m_s"].p == 1.0


@pytest.mark.parametrize(("share", "fails"), [(0.4, False), (0.55, False), (0.9, True)])
def test_a_metric_is_worse_where_it_is_in_most_samples(
    before: Path, baseline: Path, tmp_path: Path, share: float, fails: bool
) -> None:
    """One per cent up in a share of the samples, and the p-value by SciPy, corrected by hand. Kills: two-sided tests, better for
    worse, a missing correction, lost samples that count as ties for good."""

    def rise(frame: pd.DataFrame) -> Mapping[str, object]:
        return {"metric.delta_v_m_s": frame["metric.delta_v_m_s"] * np.where(np.arange(200) < 200 * share, 1.01, 0.9)}

    comparisons = found(after(before, tmp_path / "run", rise), baseline)
    one = comparisons["delta_v_m_s"]
    lost = int(RunFolder.open(before).samples().frame["metric.delta_v_m_s"].isna().sum())
    assert lost == 4
    assert one.worse + one.better == 200 - lost
    p = stats.binomtest(one.worse, 200, 0.5, alternative="greater").pvalue
    assert one.p == pytest.approx(min(1.0, len(comparisons) * p))
    assert one.significant == fails


def test_a_requirement_is_worse_where_samples_no_longer_comply(before: Path, baseline: Path, tmp_path: Path) -> None:
    """Thirty that were captured are not; one the other way. Kills: counting all samples instead of those that changed."""
    frame = RunFolder.open(before).samples().frame
    captured = np.flatnonzero(frame["outcome"] == "captured")
    words = frame["outcome"].to_numpy().copy()
    words[captured[:30]] = "not_settled"
    words[np.flatnonzero(frame["outcome"] == "not_settled")[0]] = "captured"
    comparisons = found(after(before, tmp_path / "run", lambda frame: {"outcome": words}), baseline)
    one = next(comparison for name, comparison in comparisons.items() if name.startswith("1. captured"))
    assert (one.worse, one.better) == (30, 1)
    p = stats.binomtest(30, 31, 0.5, alternative="greater").pvalue
    assert one.p == pytest.approx(len(comparisons) * p, rel=1e-6)
    assert one.significant


def test_other_draws_are_refused(before: Path, baseline: Path, tmp_path: Path) -> None:
    """Kills: comparing sample by sample what has nothing to do with each other; damaged files that end in a traceback."""
    run = after(before, tmp_path / "run", lambda frame: {"draw.pursuer.mass_kg": frame["draw.pursuer.mass_kg"] + 1e-3})
    with pytest.raises(UsageError, match=r"other draws of pursuer\.mass_kg than the run"):
        against.against(run, baseline)
    document = json.loads(baseline.read_text())
    for change, words in (
        ({"samples": 100}, "of 100 samples, the run has 200"),
        ({"format": 9}, "format 9"),
        ({"metrics": {}}, "other metrics than the run: "),
        ({"draws": 3}, "no baseline"),
    ):
        (tmp_path / "b.json").write_text(json.dumps(document | change))
        with pytest.raises(UsageError, match=words):
            against.against(before, tmp_path / "b.json")
    (tmp_path / "b.json").write_text("{")
    with pytest.raises(UsageError, match="no baseline"):
        against.against(before, tmp_path / "b.json")
