"""What the sections make of a run: the order of the worst, fault severity, and that no metric is left out."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import matplotlib
import numpy as np
import pandas as pd
import pytest

from rvjax.results import Column, RunFolder
from rvjax.sections import SECTIONS
from rvjax.sections.opened import OVERLAID, Run, open_run
from rvjax.sections.page import Number, Section, Table
from rvjax.sections.plot import STYLE
from rvjax.sections.tables import quantiles
from rvjax.totals import Totals, worst_first


@pytest.fixture(scope="module")
def run(made: Callable[..., Path], tmp_path_factory: pytest.TempPathFactory) -> Run:
    return open_run(made(tmp_path_factory.mktemp("run") / "run", 200, (0.8, 0.1, 0.1)))


@pytest.fixture(scope="module")
def sections(run: Run) -> Iterator[list[Section]]:
    with matplotlib.rc_context(STYLE):
        yield [section(run) for section in SECTIONS]


def test_worst_samples_come_first(run: Run) -> None:
    """Mutations killed: a class out of order, a sign lost in one of the keys, NaN sorted last."""
    rows = run.head.iloc[worst_first(run.head, run.totals.columns)]
    assert list(rows["sample"][:10]) == list(run.totals.worst["sample"])
    assert sorted(rows["sample"]) == list(range(200))
    assert list(rows["outcome"]) == ["not_finite"] * 20 + ["not_settled"] * 20 + ["captured"] * 160
    assert rows["outcome_time_s"].iloc[:20].is_monotonic_increasing
    assert rows["metric.window_position_error_m"].iloc[20:40].is_monotonic_decreasing
    assert rows["metric.settling_time_s"].iloc[40:].is_monotonic_decreasing


def test_only_the_worst_flights_are_read(made: Callable[..., Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Five of those that are kept, the worst first. Kills: every kept flight read, one that is not among the worst drawn."""
    path = made(tmp_path / "run", 60)
    order = open_run(path).totals.worst["sample"].tolist()
    with RunFolder.open(path) as folder:
        trace = folder.trace(order[0])
        mild = next(sample for sample in range(60) if sample not in order)
        for sample in (mild, *order[3:]):
            folder.write_trace(sample, trace, {name: Column(name, "", "made up") for name in trace})
    read: list[int] = []
    monkeypatch.setattr(RunFolder, "trace", lambda _, sample: read.append(sample) or trace)
    assert list(open_run(path).traces) == read == order[:OVERLAID]


def test_severity_is_what_the_faults_have_taken_by_the_end(run: Run) -> None:
    """Mutations killed: a sum instead of a product over faults, and a fault after the end of the flight that counts."""
    second = run.head.copy()
    second["draw.faults.late.remaining.fx"] = 0.5
    second["draw.faults.late.onset_s.fx"] = np.where(second["sample"] < 100, 10.0, 300.0)
    severity = _with(run, second).severity("fx")
    first = run.head["draw.faults.effectiveness.remaining.fx"].to_numpy()
    assert severity is not None
    assert severity == pytest.approx(1 - first * np.where(np.arange(200) < 100, 0.5, 1.0))
    assert _with(run, run.head.drop(columns=run.head.filter(like="remaining").columns)).severity("fx") is None


def _with(run: Run, frame: pd.DataFrame) -> Run:
    """The run with other samples."""
    totals = Totals()
    totals.add(0, frame, run.totals.columns)
    return replace(run, totals=totals, head=totals.head)


def test_quantiles_look_at_the_bad_side(run: Run) -> None:
    """Mutation killed: the upper quantile of a metric where higher is better. 20 of 200 are not finite: -inf there."""
    (row,) = quantiles(run, "", ["closest_approach_m"]).rows
    values = [cell.estimate.value for cell in row if isinstance(cell, Number)]
    assert values == sorted(values, reverse=True)
    assert values[1:] == [-np.inf] * 3
    (row,) = quantiles(run, "", ["settling_time_s"]).rows
    values = [cell.estimate.value for cell in row if isinstance(cell, Number)]
    assert values == sorted(values)
    assert values[1:] == [np.inf] * 3


def test_every_metric_is_shown(run: Run, sections: list[Section]) -> None:
    """Mutation killed: a metric that no section shows."""
    shown = {number.name for section in sections for number in section.numbers()}
    hidden = [name for name in run.metrics(".*") if not any(key.startswith(f"{name}.") for key in shown)]
    assert hidden == []


def test_sections_are_well_formed(sections: list[Section]) -> None:
    """Keys, names of numbers and of figures are unique and plain; every row fits its head; every text is a sentence."""
    keys = [section.key for section in sections]
    figures = [drawing.name for section in sections for drawing in section.drawings]
    numbers = [number for section in sections for number in section.numbers()]
    assert len(set(keys)) == len(keys)
    assert len(set(figures)) == len(figures)
    assert all(re.fullmatch(r"[a-z]+(-[a-z]+)*", name) for name in keys + figures)
    values: dict[str, Number] = {}
    assert all(values.setdefault(number.name, number) == number for number in numbers)
    for section in sections:
        assert section.lead.endswith(".")
        for block in section.body:
            if isinstance(block, Table):
                assert block.caption.endswith(".")
                assert all(len(row) == len(block.head) for row in block.rows)
