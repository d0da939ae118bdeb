"""Flights whose arithmetic breaks on purpose: each is counted, as a failure, and no other flight notices."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from rvjax import report
from rvjax.analysis.verdicts import judge_folder
from rvjax.components import registry
from rvjax.execution.audit import Audit
from rvjax.execution.run import run
from rvjax.report import sections
from rvjax.report.sections import captured as captured_section
from rvjax.run_folder import RunFolder
from rvjax.simulation.batch import LANES
from tests.short import CAMPAIGN

CHUNKS = {False: {0.0: 8, 1e-3: 8, 0.01: 4, 0.5: 2, 1.0: 2}, True: {0.0: 50, 1e-4: 50, 0.01: 10, 0.5: 5, 1.0: 3}}
"""Chunks to fly, by the share that breaks, by whether the suite runs in its full numbers; the last chunk is cut."""

DURATION, STEP = 4.0, 0.1
REPORTED = 0.5
"""Of this share the report is made as well."""

SECTIONS = {False: (captured_section.section,), True: sections.SECTIONS}
"""Of that report: by default those whose numbers are looked at."""

SETS = (
    f"horizon={{duration_s: {DURATION}, step_s: {STEP}}}",
    "controller={use: pd-plus}",
    "faults=[]",
    "keep={worst: 1}",
    "capture={position_m: 16, attitude_mrp: 1, window_s: 1}",
    "require=[{metric: captured, at_least: 0.5}, {metric: final_position_error_m, below: 100, at_least: 0.5}]",
)


@pytest.fixture(autouse=True)
def _breaking(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """As if an installed package brought the disturbance."""
    entry = EntryPoint("breaking", "tests.reliability.breaking:COMPONENT", "rvjax.disturbances")
    found = registry.entry_points
    monkeypatch.setattr(registry, "entry_points", lambda group: [entry] if group == entry.group else found(group=group))
    registry.members.cache_clear()
    yield
    registry.members.cache_clear()


def flown(path: Path, share: float, chunks: int) -> Path:
    """The run with a share of its flights broken, each at a random step but the last two, in one of the three ways."""
    breaking = (
        f"disturbances=[{{use: breaking, share: {share}, lot: {{uniform: [0, 1]}}, "
        f"onset_s: {{uniform: [0, {DURATION - 2 * STEP}]}}, kind: {{choice: [0, 1, 2]}}}}]"
    )
    return run(CAMPAIGN, path, [*SETS, breaking, f"samples={chunks * LANES - 37}"])


def test_broken_flights_are_counted_and_disturb_no_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, full: bool, figure: Callable[[str], None]
) -> None:
    """Kills: a broken sample left out of a share, counted as captured or as not settled, taken for one that was never flown; a
    NaN that spreads to other lanes; infinities that pass for numbers; an overflow that is a large number in the table.
    """
    monkeypatch.setattr(sections, "SECTIONS", ())
    unproved = Audit(0, 0, (), {}, {})  # where all flights break, most dispersions do nothing
    monkeypatch.setattr("rvjax.execution.run.prove", lambda problem, flyer, baseline: unproved)
    counts: list[str] = []
    unbroken = pd.DataFrame()
    for share, chunks in CHUNKS[full].items():
        path = flown(tmp_path / f"{share}", share, chunks)
        frame = RunFolder.open(path).samples().frame
        unbroken = unbroken if share else frame
        sound, n = unbroken[: len(frame)], len(frame)
        draws = [name for name in sound if name.startswith("draw.")]
        metrics = [name for name in sound if name.startswith("metric.") and name != "metric.captured"]
        captured = sound["outcome"].to_numpy() == "captured"
        assert 0.2 < captured.mean() < 0.8
        lost = frame["draw.disturbances.breaking.lot"].to_numpy() < share
        assert (lost.any(), lost.all()) == (share > 0, share == 1)
        pd.testing.assert_frame_equal(frame[draws], sound[draws], check_exact=True)
        assert ((frame["outcome"] == "not_finite").to_numpy() == lost).all()
        late = (frame["outcome_time_s"] - frame["draw.disturbances.breaking.onset_s"]).to_numpy()[lost]
        assert (late > -1e-9).all()
        kind = frame["draw.disturbances.breaking.kind"].to_numpy()[lost].astype(int)
        assert (late < STEP * np.where(kind < 2, 1, 2) + 1e-9).all()
        assert frame.loc[lost, metrics].isna().all(axis=None)
        assert (frame.loc[lost, "metric.captured"] == 0.0).all()
        pd.testing.assert_frame_equal(frame[~lost], sound[~lost], check_exact=True)
        account = RunFolder.open(path).account()
        ends = (account.captured, account.not_settled, account.not_finite, account.missing)
        assert ends == ((captured & ~lost).sum(), (~captured & ~lost).sum(), lost.sum(), 0)
        for verdict, successes in zip(judge_folder(path), ((captured & ~lost).sum(), (~lost).sum()), strict=True):
            assert (verdict.n, verdict.successes) == (n, successes)
        if share == REPORTED:
            monkeypatch.setattr(sections, "SECTIONS", SECTIONS[full])
            report.build(path)
            monkeypatch.setattr(sections, "SECTIONS", ())
            summary = json.loads((path / "summary.json").read_text())
            assert summary["account"] == vars(account)
            success = summary["numbers"]["captured.share"]
            assert (success["value"], success["n"]) == ((captured & ~lost).sum() / n, n)
        kinds = np.bincount(kind, minlength=3)
        counts.append(f"p = {share:g}: {lost.sum()} of {n} ({kinds[0]} NaN, {kinds[1]} infinite, {kinds[2]} overflows)")
    figure(f"forced failures: {'; '.join(counts)}; counts exact, success over all samples, every other row bit-identical")
