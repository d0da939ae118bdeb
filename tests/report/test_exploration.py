"""A run whose samples are a plan: a report without intervals, and no verdict anywhere."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

import pytest

from rvjax.analysis import verdicts
from rvjax.errors import UsageError
from rvjax.report import build
from rvjax.report.run_view import open_run
from tests.program import Run as Program

PLAN = "[]\nsampler: {use: latin-hypercube}"


def test_a_plan_is_reported_and_not_judged(
    made: Callable[..., Path], rvjax: Program, tmp_path: Path, undrawn: Callable[[], AbstractContextManager[None]]
) -> None:
    """Every table and every caption without interval, confidence or band; numbers of the summary without ends; `check` says why
    there is no verdict. Kills: a section that makes its interval by itself."""
    path = made(tmp_path / "run", 200, (0.8, 0.1, 0.1), require=PLAN)
    assert verdicts.judge_folder(path) == ()
    with undrawn():
        page = build(path)
    text = (path / "report.md").read_text()
    assert "Exploration: no verdicts" in text
    assert "Exploration: no verdicts" in page.read_text()
    for word in ("interval", "onfidence", "Clopper", "Wolfowitz", " … "):
        assert word not in text.partition("Provenance and definitions")[0], word
    numbers = json.loads((path / "summary.json").read_text())["numbers"]
    assert len(numbers) > 50
    assert all(set(number) == {"value", "n", "unit"} for number in numbers.values())
    code, out, _ = rvjax("check", path)
    assert (code, "exploration: no verdicts" in out) == (0, True)
    code, out, _ = rvjax("check", path, "--json")
    assert json.loads(out)["verdicts"] == []


def test_independent_samples_keep_their_intervals(report: Path) -> None:
    """Such a run drawn independently. Kills a report that lost its intervals altogether."""
    text = (report / "report.md").read_text()
    assert len(re.findall(" … ", text)) > 50
    assert "confidence" in text
    assert "xploration" not in text


def test_a_requirement_on_a_plan_is_refused(made: Callable[..., Path], tmp_path: Path) -> None:
    """Also in a folder that no run of ours has made. Kills a folder that is judged because nobody asks how it was drawn."""
    require = "[{metric: captured, at_least: 0.5}]\nsampler: {use: sobol}"
    path = made(tmp_path / "run", 200, (0.8, 0.1, 0.1), require=require)
    for look in (verdicts.judge_folder, open_run):
        with pytest.raises(UsageError, match="exploration: no verdicts"):
            look(path)
