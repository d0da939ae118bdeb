"""A run against a baseline: the same bits never fail, what is worse does, and only the same draws are compared."""

from __future__ import annotations

import itertools
import json
import re
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from rvjax.analysis import baseline as against
from rvjax.analysis.run_totals import worst_first
from rvjax.analysis.worst_samples import worst_samples
from rvjax.campaign import Requirement
from rvjax.errors import UsageError
from rvjax.report.ci import github
from rvjax.run_folder import RunFolder
from tests.ci.altered import after
from tests.program import Run
from tests.short import CAMPAIGN


@pytest.fixture(scope="module")
def baseline(before: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Of that run."""
    path = tmp_path_factory.mktemp("baseline") / "b.json"
    against.write(before, path)
    return path


def found(folder: Path, baseline: Path) -> dict[str, against.BaselineComparison]:
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


def test_a_flight_that_collides_is_worse_in_everything(before: Path, baseline: Path, tmp_path: Path) -> None:
    """Though its metrics are the same numbers. Kills: a collision that fails no metric."""
    words = np.where(np.arange(200) < 160, "collided", RunFolder.open(before).samples().frame["outcome"])
    comparisons = found(after(before, tmp_path / "run", lambda frame: {"outcome": words}), baseline)
    finite = int(np.isfinite(RunFolder.open(before).samples().frame["metric.delta_v_m_s"][:160]).sum())
    assert comparisons["delta_v_m_s"].worse == finite
    assert comparisons["delta_v_m_s"].significant


def test_other_draws_are_refused(before: Path, baseline: Path, tmp_path: Path) -> None:
    """Kills: comparing sample by sample what has nothing to do with each other; damaged files that end in a traceback."""
    run = after(before, tmp_path / "run", lambda frame: {"draw.pursuer.mass_kg": frame["draw.pursuer.mass_kg"] + 1e-3})
    with pytest.raises(UsageError, match=r"its draws of pursuer\.mass_kg differ from the run"):
        against.against(run, baseline)
    document = json.loads(baseline.read_text())
    marks = {name: told[:100] for name, told in document["requirements"].items()}
    shorter = {name: {**told, "values": told["values"][:100]} for name, told in document["metrics"].items()}
    for change, words in (
        ({"samples": 100, "requirements": marks, "metrics": shorter}, "it has 100 samples, the run has 200"),
        ({"format": 9}, "format 9"),
        ({"metrics": {}}, "its metrics differ from the run: "),
        ({"draws": 3}, "not a baseline"),
    ):
        (tmp_path / "b.json").write_text(json.dumps(document | change))
        with pytest.raises(UsageError, match=words):
            against.against(before, tmp_path / "b.json")
    (tmp_path / "b.json").write_text("{")
    with pytest.raises(UsageError, match="not a baseline"):
        against.against(before, tmp_path / "b.json")


CAPTURED, VALUES = ("requirements", "1. captured: at least 0.98"), ("metrics", "delta_v_m_s", "values")
MASS, EFFORT = ("draws", "pursuer.mass_kg"), VALUES[:2]
GONE = object()
EDITS: dict[str, tuple[tuple[str | int, ...], object, str]] = {
    "two digits": (CAPTURED, "11", "2 samples; accepted: 200"),
    "letters": (CAPTURED, "x" * 200, "accepted: a text of 0 and 1"),
    "a number": (CAPTURED, 3, "3; accepted: a text"),
    "no mapping": (EFFORT, 5, "5; accepted: a mapping"),
    "a text": ((*VALUES, 3), "a", '"a"; accepted: a finite number'),
    "NaN": ((*VALUES, 4), float("nan"), "NaN; accepted: a finite number"),
    "true": ((*VALUES, 5), True, "true; accepted: a finite number"),
    "too few": (VALUES, [1.0] * 199, "199 samples; accepted: 200"),
    "better": ((*EFFORT, "better"), "less", "'lower' or 'higher'"),
    "a unit": ((*EFFORT, "unit"), "m/s", "unknown key"),
    "a text of four": ((*MASS, 0), "a", '"a"; accepted: a finite number'),
    "infinite": ((*MASS, 2), float("inf"), "Infinity; accepted: a finite number"),
    "three of four": ((*MASS, 3), GONE, "3 numbers; accepted: 4 or 0"),
    "samples as text": (("samples",), "200", '"200"; accepted: a whole number'),
    "no sample": (("samples",), 0, "0; accepted: input should be greater than or equal to 1"),
    "half a sample": (("samples",), 200.5, "200.5; accepted: a whole number"),
    "null": (("campaign",), None, "null; accepted: a text"),
    "unknown key": (("extra",), 1, "unknown key"),
    "missing key": (("draws",), GONE, "missing"),
    "format as text": (("format",), "1", '"1"; accepted: input should be 1'),
}
"""What somebody has done to a baseline: the place, the new value, and the words that the refusal has of it."""


def edited(document: Any, edit: str) -> str:
    """Edits a baseline; returns the place in the words of a refusal, with the start of what the refusal says there."""
    place, value, words = EDITS[edit]
    for step in place[:-1]:
        document = document[step]
    if value is GONE:
        del document[place[-1]]
    else:
        document[place[-1]] = value
    shown = place[:-1] if edit == "three of four" else place
    return f"{'.'.join(map(str, shown))}: .*{re.escape(words)}"


@pytest.mark.parametrize("edit", EDITS)
def test_an_edited_baseline_is_refused_with_its_place(
    before: Path, baseline: Path, tmp_path: Path, rvjax: Run, edit: str
) -> None:
    """As after a conflict that was resolved by hand. Kills: a field that is read without a check of its type, its range or its
    finiteness; an unknown key that is ignored; a traceback; a JUnit XML file without the error."""
    document = json.loads(baseline.read_text())
    words = edited(document, edit)
    (tmp_path / "b.json").write_text(json.dumps(document))
    code, _, err = rvjax("check", before, "--against", tmp_path / "b.json", "--junit-xml", tmp_path / "j.xml")
    assert code == 2
    assert "not a baseline" in err
    assert re.search(words, " ".join(err.split())), err
    assert "Traceback" not in err
    assert any(case.find("error") is not None for case in ElementTree.parse(tmp_path / "j.xml").iter("testcase"))


def test_every_mistake_of_a_baseline_is_listed(before: Path, baseline: Path, tmp_path: Path) -> None:
    """Kills: the first mistake only; a merge that leaves a key twice, of which the last silently wins; bytes that are no text."""
    document = json.loads(baseline.read_text())
    words = [edited(document, name) for name in ("two digits", "unknown key", "better", "a text")]
    path = tmp_path / "b.json"
    path.write_text(json.dumps(document))
    with pytest.raises(UsageError) as caught:
        against.against(before, path)
    missed = [word for word in words if not re.search(word, str(caught.value))]
    assert missed == words[:1], "lengths are looked at where all fields are right"
    path.write_text('{"format": 1, "samples": 200, "samples": 200}')
    with pytest.raises(UsageError, match="key 'samples' stands twice"):
        against.against(before, path)
    path.write_bytes(b"\xff\xfe{}")
    with pytest.raises(UsageError, match="not a baseline"):
        against.against(before, path)
    path.write_text("[1]")
    with pytest.raises(UsageError, match=r"the file: \[1\]; accepted: a mapping"):
        against.against(before, path)


def test_worse_than_the_baseline_is_told_everywhere(
    before: Path, baseline: Path, tmp_path: Path, rvjax: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Kills: a job that fails while its JUnit XML is green and nothing is annotated; a baseline that is written before it is
    compared with, and so never worse."""
    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(tmp_path / "summary.md"))
    run = after(before, tmp_path / "run", lambda frame: {"metric.delta_v_m_s": frame["metric.delta_v_m_s"] * 1.1})
    mine = shutil.copy(baseline, tmp_path / "b.json")
    told = ("--junit-xml", tmp_path / "j.xml")
    code, out, _ = rvjax("check", run, "--against", mine, "--write-baseline", mine, *told)
    assert code == 1
    where = re.escape(github.relative(str(run / "campaign.yaml")))
    assert re.search(rf"^::error file={where},line=\d+,col=1,title=worse than the baseline%3A delta_v_m_s::", out, re.MULTILINE)
    cases = {case.get("name"): case for case in ElementTree.parse(tmp_path / "j.xml").iter("testcase")}
    failed = [
        name for name, case in cases.items() if case.find("failure") is not None and "baseline" in str(case.get("classname"))
    ]
    assert failed == ["delta_v_m_s"]
    assert "❌ WORSE" in (tmp_path / "summary.md").read_text()
    _, out, _ = rvjax("check", run, "--against", mine, *told)
    assert "worse than the baseline" not in out
    assert sum(case.find("failure") is not None for case in ElementTree.parse(tmp_path / "j.xml").iter("testcase")) < len(cases)
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(tmp_path / "none" / "summary.md"))
    code, _, err = rvjax("check", run, *told)
    assert code != 4
    assert "no job summary" in err


def test_what_cannot_be_compared_is_an_error_in_every_output(
    before: Path, baseline: Path, tmp_path: Path, rvjax: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Kills: a flight of minutes for a baseline that is not there; JUnit XML of an earlier run behind a mistake."""
    report = tmp_path / "j.xml"
    run = after(before, tmp_path / "run", lambda frame: {"draw.pursuer.mass_kg": frame["draw.pursuer.mass_kg"] + 1e-3})
    code, *_ = rvjax("check", run, "--against", baseline, "--junit-xml", report)
    kinds = [
        [part.tag for part in case if part.tag in ("failure", "error")] for case in ElementTree.parse(report).iter("testcase")
    ]
    assert code == 2
    assert len(kinds) == 4
    assert kinds[3] == ["error"]
    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    monkeypatch.setattr("rvjax.execution.run.run", lambda *given, **named: pytest.fail("flown"))
    code, out, _ = rvjax("check", CAMPAIGN, "--against", tmp_path / "none.json", "--junit-xml", report)
    assert code == 2
    assert re.search(r"^::error title=rvjax::.*none\.json%?: not a baseline", out, re.MULTILINE), out
    (case,) = ElementTree.parse(report).iter("testcase")
    assert case.find("error") is not None
    code, _, err = rvjax("check", CAMPAIGN, "--junit-xml", tmp_path)
    assert (code, "this is a folder" in err) == (2, True)
    (tmp_path / "bad.yaml").write_text("rvjax: 1\n")
    monkeypatch.undo()
    code, *_ = rvjax("check", tmp_path / "bad.yaml", "--junit-xml", report)
    assert "samples: missing" in report.read_text()


def test_the_worst_sample_of_a_requirement(made: Callable[..., Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By pandas, over four chunks. Kills: the report's order for every requirement, the best for the worst, the worst of
    the last chunk only, a class that is not kept to, or that is another requirement's."""
    folder = RunFolder.open(made(tmp_path / "run", 900, (0.97, 0.02, 0.01), kept=0))
    assert len(folder.chunks) == 4
    monkeypatch.setattr("rvjax.run_folder.folder.neighbours", lambda chunks: ([one] for one in chunks))
    frame = folder.samples().frame.set_index("sample")
    lost = frame.index[frame["outcome"] == "not_finite"]
    mass, fuel = frame["draw.pursuer.mass_kg"], frame["metric.delta_v_m_s"]

    def on_fuel(where: Mapping[str, float], **said: object) -> Requirement:
        given = {"metric": "delta_v_m_s", "where": {"pursuer.mass_kg": where}, **said}
        return Requirement(**given)  # pyright: ignore

    edges = sorted([*mass[lost], 0.0, 1e3])
    low, high = max(itertools.pairwise(edges), key=lambda pair: ((mass > pair[0]) & (mass < pair[1])).sum())
    sound = {"at_least": low + 1e-9, "below": high}
    kept = fuel[(mass > low) & (mass < high)]
    assert len(kept) > 100
    assert {int(kept.idxmax()) // 256, int(kept.idxmin()) // 256}.isdisjoint({3})
    expected = (
        (on_fuel(sound, below=1.0, at_least=0.5), kept.idxmax()),
        (on_fuel(sound, above=1.0, at_least=0.5), kept.idxmin()),
        (on_fuel(sound, above=1.0, at_most=0.5), kept.idxmax()),
        (on_fuel({"at_least": 0.0}, above=1.0, at_least=0.5), lost[0]),
        (on_fuel({"at_least": 1e6}, below=1.0, at_least=0.5), None),
        (Requirement(metric="captured", at_least=0.9), worst_first(frame.reset_index(), folder.columns())[0]),
    )
    assert worst_samples(folder, [one for one, _ in expected]) == [sample for _, sample in expected]
