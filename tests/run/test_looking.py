"""When a run may be judged: once by a fixed number of samples, after every chunk by a sequential method."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from rvjax.analysis.verdicts import judge_folder
from rvjax.errors import UsageError
from rvjax.execution.progress import Progress
from rvjax.execution.run import run
from rvjax.run_folder import RunFolder
from rvjax.simulation.batch import LANES
from tests.progress import append_flown
from tests.short import CAMPAIGN, SHORT

QUICK = (
    *SHORT,
    "controller={use: pd-plus}",
    "keep={worst: 0}",
    "audit={allow: [pursuer, actuators, faults, disturbances, start]}",
)
SEQUENTIAL = "require=[{metric: captured, at_least: 0.95, method: sequential}]"
FIXED = "require=[{metric: captured, at_least: 0.99}]"
HARD = "capture={position_m: 17, attitude_mrp: 1, window_s: 5}"
"""About half of the samples are captured."""

pytestmark = pytest.mark.usefixtures("bare")


def test_flying_stops_once_all_is_decided(tmp_path: Path) -> None:
    """10,000 are asked for, one chunk is enough; the same command again flies nothing and says the same, and so does the folder.

    Kills: flying on, a folder that counts as incomplete, a verdict that changes when it is asked for again.
    """
    folder, given = tmp_path / "run", (*QUICK, SEQUENTIAL, "samples=10000")
    run(CAMPAIGN, folder, given, until_decided=True)
    opened = RunFolder.open(folder)
    assert LANES <= opened.requested < 5 * LANES
    assert opened.account().missing == 0
    (verdict,) = judge_folder(folder)
    assert (verdict.verdict, verdict.n, verdict.successes) == ("PASS", LANES, LANES)
    assert verdict.evidence is not None
    assert verdict.evidence.decided == 0
    flown: list[int] = []
    run(CAMPAIGN, folder, given, progress=append_flown(flown), until_decided=True)
    assert flown == []
    assert judge_folder(folder)[0].text == verdict.text


def test_what_was_decided_stays_decided(tmp_path: Path) -> None:
    """With twice the samples. Kills: a verdict from all samples, as if none had been looked at before."""
    folder = tmp_path / "run"
    run(CAMPAIGN, folder, (*QUICK, SEQUENTIAL, "samples=416"))
    first = judge_folder(folder)[0]
    run(CAMPAIGN, folder, (*QUICK, SEQUENTIAL, "samples=1000"))
    second = judge_folder(folder)[0]
    assert (second.verdict, second.n, second.text) == ("PASS", LANES, first.text)
    assert second.evidence is not None
    assert second.evidence.samples.tolist() == [LANES, 2 * LANES, 1000]


def test_failing_is_decided_as_well(tmp_path: Path) -> None:
    """Kills: evidence for PASS only, which would fly on to the end."""
    folder = run(CAMPAIGN, tmp_path / "run", (*QUICK, HARD, SEQUENTIAL, "samples=10000"), until_decided=True)
    (verdict,) = judge_folder(folder)
    assert (verdict.verdict, verdict.n) == ("FAIL", LANES)
    assert verdict.high_bound < 0.95


def test_one_fixed_requirement_needs_all_samples(tmp_path: Path) -> None:
    """Kills: stopping by the sequential one, which would leave the other one judged at a number that the data chose."""
    both = "require=[{metric: captured, at_least: 0.95, method: sequential}, {metric: captured, at_least: 0.99}]"
    folder = run(CAMPAIGN, tmp_path / "run", (*QUICK, both, "samples=900"), until_decided=True)
    assert RunFolder.open(folder).requested == 900
    assert [verdict.n for verdict in judge_folder(folder)] == [LANES, 900]


def test_a_second_look_at_more_samples_is_refused(tmp_path: Path) -> None:
    """By a fixed number of samples; without the requirement, or with a sequential one, more may be flown. Kills: peeking."""
    folder = tmp_path / "run"
    run(CAMPAIGN, folder, (*QUICK, FIXED, "samples=40"))
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    with pytest.raises(UsageError, match="judged at 40 samples, now 300 are asked for"):
        run(CAMPAIGN, folder, (*QUICK, FIXED, "samples=300"))
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before
    run(CAMPAIGN, folder, (*QUICK, "require=[]", "samples=300"))
    assert RunFolder.open(folder).requested == 300


def test_a_run_that_was_cut_short_has_not_been_looked_at(tmp_path: Path) -> None:
    """Kills: refusing to resume a run that was interrupted and asked for fewer samples."""

    def stop(progress: Progress) -> None:
        if progress.done:
            raise KeyboardInterrupt

    folder = tmp_path / "run"
    with pytest.raises(KeyboardInterrupt):
        run(CAMPAIGN, folder, (*QUICK, FIXED, "samples=1000"), progress=stop)
    run(CAMPAIGN, folder, (*QUICK, FIXED, "samples=1300"))
    assert judge_folder(folder)[0].n == 1300


def test_a_class_is_judged_by_its_own_samples(tmp_path: Path) -> None:
    """Kills: counting all samples, or those of the class among the first only."""
    where = "where: {pursuer.mass_kg: {below: 90}}"
    required = f"require=[{{metric: captured, at_least: 0.1, {where}}}, {{metric: captured, at_least: 0.1}}]"
    folder = run(CAMPAIGN, tmp_path / "run", (*QUICK, HARD, required, "samples=900"))
    light, everybody = judge_folder(folder)
    frame = RunFolder.open(folder).samples().frame
    chosen = frame["draw.pursuer.mass_kg"].to_numpy() < 90
    assert 100 < chosen.sum() < 400
    captured = (frame["outcome"] == "captured").to_numpy()
    assert (light.n, light.successes) == (chosen.sum(), captured[chosen].sum())
    assert (everybody.n, everybody.successes) == (900, np.count_nonzero(captured))
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["account"]["captured"] == captured.sum()
