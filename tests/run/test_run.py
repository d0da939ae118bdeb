"""A campaign flown end to end: what is in the folder, and what does not depend on how it was flown."""

from __future__ import annotations

import hashlib
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from rvjax.analysis.verdicts import judge_folder
from rvjax.columns import CHANNELS
from rvjax.errors import FolderError, UsageError
from rvjax.execution.replay import replay
from rvjax.execution.run import run
from rvjax.report import sections
from rvjax.report.run_view import open_run
from rvjax.run_folder import Audited, RunFolder
from rvjax.simulation import tables
from rvjax.simulation.batch import LANES
from tests.progress import append_flown
from tests.short import CAMPAIGN, QUICK, SHORT

REPLAYED = (LANES - 1, 2 * LANES + 167, 3 * LANES + 49)

TRACE_COLUMNS = [
    "t_s",
    *(f"rho_{a}_m" for a in "xyz"),
    *(f"nu_{a}_m_s" for a in "xyz"),
    *(f"sigma_{a}" for a in "xyz"),
    *(f"omega_{a}_rad_s" for a in "xyz"),
    *(f"target_r_{a}_m" for a in "xyz"),
    *(f"target_v_{a}_m_s" for a in "xyz"),
    *(f"target_w_{a}_rad_s" for a in "xyz"),
    *(f"{kind}_{channel}" for kind in ("cmd", "applied", "dist", "mean") for channel in CHANNELS),
]


def table(folder: Path) -> pd.DataFrame:
    """The samples table."""
    return RunFolder.open(folder).samples().frame


def test_every_requested_sample_has_one_row_and_one_outcome(flown: Path) -> None:
    """Kills: padded lanes counted, rows dropped, a sample counted twice."""
    frame = table(flown)
    assert frame["sample"].tolist() == list(range(40))
    account = RunFolder.open(flown).account()
    assert (account.requested, account.captured, account.not_settled, account.not_finite, account.missing) == (40, 40, 0, 0, 0)


def test_table_has_units_and_meanings(flown: Path) -> None:
    columns = RunFolder.open(flown).samples().columns
    assert columns["draw.pursuer.mass_kg"].unit == "kg"
    assert columns["metric.settling_time_s"].unit == "s"
    assert columns["metric.settling_time_s"].better == "lower"
    assert all(column.description for column in columns.values())


def test_replay_reproduces_its_row_and_gives_the_contracted_trace(flown: Path) -> None:
    """Kills: another draw, another program or another step for the replay than for the run (bitwise, 81 columns)."""
    trace, columns, row = replay(flown, 17)
    assert len(trace) == 401
    own = [name for name in trace.columns if name.startswith("ctl.")]
    assert set(trace.columns) == {*TRACE_COLUMNS, *own}
    assert {"ctl.chi_fx", "ctl.mass_kg", "ctl.inertia_kgm2_xy", "ctl.alpha2_tz"} <= set(own)
    assert set(columns) == set(trace.columns)
    assert all(column.unit and column.description for column in columns.values())
    assert trace["t_s"].iloc[-1] == pytest.approx(20.0, abs=1e-12)
    assert row["sample"] == 17
    final = np.sqrt((trace[["rho_x_m", "rho_y_m", "rho_z_m"]].iloc[-1] ** 2).sum())
    assert final == pytest.approx(row["metric.final_position_error_m"], rel=1e-14)


def test_replay_compares_the_flight_with_the_row(flown: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: a replay that only claims to have checked. One metric of the repeated flight is changed in its last bit."""
    honest = tables.samples_table

    def changed(*args: object) -> tuple[pd.DataFrame, object]:
        frame, columns = honest(*args)
        frame["metric.delta_v_m_s"] = np.nextafter(frame["metric.delta_v_m_s"], np.inf)
        return frame, columns

    monkeypatch.setattr(tables, "samples_table", changed)
    with pytest.raises(FolderError, match=r"metric\.delta_v_m_s"):
        replay(flown, 17, every=100)


def test_replay_of_a_sample_that_is_not_there(flown: Path) -> None:
    with pytest.raises(UsageError, match="no sample 40; accepted: 0 to 39"):
        replay(flown, 40)


def test_worst_traces_are_kept_and_thinned(flown: Path) -> None:
    folder = RunFolder.open(flown)
    traces = {sample: folder.trace(sample) for sample in folder.trace_samples()}
    assert len(traces) == 10
    assert all(len(trace) == 401 for trace in traces.values())


@pytest.mark.usefixtures("bare")
def test_more_samples_leave_the_first_ones_as_they_are(tmp_path: Path, figure: Callable[[str], None]) -> None:
    """Kills: draws that depend on the number of samples, a chunk flown twice with another result, pads in the table."""
    first, then = 2 * LANES + 168, 3 * LANES + 50
    quick = [*SHORT, QUICK, "require=[]", "keep={worst: 0}"]
    fewer = table(run(CAMPAIGN, tmp_path / "run", [*quick, f"samples={first}"]))
    flown: list[int] = []
    more = table(run(CAMPAIGN, tmp_path / "run", [*quick, f"samples={then}"], progress=append_flown(flown)))
    assert len(more) == then
    assert flown[0] == 2 * LANES, "whole chunks are there, the one that was cut is flown with those that are new"
    pd.testing.assert_frame_equal(more.iloc[:first], fewer, check_exact=True)
    again: list[int] = []
    run(CAMPAIGN, tmp_path / "run", [*quick, f"samples={then}"], progress=append_flown(again))
    assert again == []
    for sample in REPLAYED:
        replay(tmp_path / "run", sample, every=100)  # compares every metric with the row
    figure(f"extension: {first} samples, then {then}: the first {first} rows bit-equal, only the last two chunks flown")
    figure(f"replay: {len(REPLAYED)} samples of any chunk, alone at the same lanes: every metric bit-equal to the row")


@pytest.mark.usefixtures("bare")
def test_the_verdict_is_on_the_requirements_given_last(flown: Path, tmp_path: Path) -> None:
    """Kills: verdicts on the requirements of the first run. Nothing is flown again; the ten traces stay the same bytes."""
    copy = tmp_path / "copy"
    shutil.copytree(flown, copy)
    before = {path.name: path.read_bytes() for path in (copy / "traces").iterdir()}
    flights: list[int] = []
    required = "require=[{metric: captured, at_least: 0.5}]"
    run(CAMPAIGN, copy, [*SHORT, required], progress=append_flown(flights))
    assert flights == []
    assert [verdict.verdict for verdict in judge_folder(copy)] == ["PASS"]
    assert judge_folder(flown)[0].verdict == "UNDECIDED"
    assert {path.name: path.read_bytes() for path in (copy / "traces").iterdir()} == before


@pytest.mark.usefixtures("bare")
def test_kept_traces_are_those_of_the_worst_samples(tmp_path: Path) -> None:
    """A folder that grows from 5 to 60 samples. Kills: traces of samples that are no longer among the worst; a trace whose bits
    depend on the samples it is flown beside."""
    hard = "capture={position_m: 18, attitude_mrp: 1, window_s: 5}"  # no ties among the worst
    few = [*SHORT, QUICK, hard, "require=[]", "keep={worst: 3}"]
    run(CAMPAIGN, tmp_path / "run", [*few, "samples=5"])
    folder = RunFolder.open(tmp_path / "run")
    first = {sample: folder.trace(sample) for sample in folder.trace_samples()}
    run(CAMPAIGN, tmp_path / "run", [*few, "samples=60"])
    kept = set(RunFolder.open(tmp_path / "run").trace_samples())
    assert kept == set(open_run(tmp_path / "run").totals.worst["sample"][:3])
    assert kept != set(first)
    for sample in list(first)[:1]:
        again, _, _ = replay(tmp_path / "run", sample)
        pd.testing.assert_frame_equal(again, first[sample], check_exact=True)


def test_the_audit_is_kept_and_renewed_where_something_is_flown(
    flown: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Kills: a proof that nobody can look up afterwards; one of earlier flights that is taken for one of those flown since."""
    monkeypatch.setattr(sections, "SECTIONS", (sections.provenance.section,))
    kept = RunFolder.open(flown).audit
    assert kept is not None
    draws = [name for name in table(flown) if name.startswith("draw.")]
    assert kept.read_back == len(draws)
    assert kept.dispersions == len(kept.moved) > 50
    assert f"{kept.dispersions} dispersions were audited" in (flown / "report.md").read_text()
    again = tmp_path / "again"
    shutil.copytree(flown, again)
    older = Audited(dispersions=1, read_back=1, acting=0, idle={"faults": 1}, moved={})
    with RunFolder.open(again) as folder:
        folder.keep_audit(older)
    run(CAMPAIGN, again, SHORT)
    assert RunFolder.open(again).audit == older  # nothing was flown
    assert "as audit.allow permits: faults." in (again / "report.html").read_text()
    next((again / "samples").glob("00000-*")).unlink()
    run(CAMPAIGN, again, SHORT)
    assert RunFolder.open(again).audit == kept


def test_another_seed_is_another_run(flown: Path) -> None:
    """Kills: a folder resumed under another identity."""
    before = hashlib.sha256((flown / "manifest.json").read_bytes()).hexdigest()
    with pytest.raises(FolderError, match="seed"):
        run(CAMPAIGN, flown, [*SHORT, "seed=2"])
    assert hashlib.sha256((flown / "manifest.json").read_bytes()).hexdigest() == before


@pytest.mark.usefixtures("bare")
def test_a_sample_that_is_lost_disturbs_no_other(flown: Path, tmp_path: Path) -> None:
    """A gain that is absurd in a third of the samples: those are not finite, one row each; every other row keeps its bits.

    Kills: lanes that share numbers, a NaN that is dropped or counted as settled, a mean over the chunk inside the loop.
    """
    absurd = "controller.gains.k3={choice: {values: [8, 1.0e+80], weights: [2, 1]}}"  # 8 is the default
    folder = run(CAMPAIGN, tmp_path / "run", [*SHORT, absurd, "keep={worst: 0}"])
    frame, plain = table(folder), table(flown)
    lost = frame["draw.controller.gains.k3"] > 8
    assert 3 <= lost.sum() <= 30
    assert (frame["outcome"][lost] == "not_finite").all()
    assert (frame["outcome_time_s"][lost] <= 20.0).all()
    assert (frame["metric.captured"][lost] == 0.0).all()
    assert frame.loc[lost, "metric.final_position_error_m"].isna().all()
    pd.testing.assert_frame_equal(frame.loc[~lost, plain.columns], plain[~lost], check_exact=True)
    account = RunFolder.open(folder).account()
    assert account.not_finite == lost.sum()
    assert account.captured == (~lost).sum()


@pytest.mark.usefixtures("bare")
def test_a_finished_run_flies_again_what_has_been_damaged_since(flown: Path, tmp_path: Path) -> None:
    """One bit of a chunk, whose name and size are as before. Kills: setting it aside without flying it, a report of the rest."""
    copy = tmp_path / "copy"
    shutil.copytree(flown, copy)
    (chunk,) = (copy / "samples").iterdir()
    good = chunk.read_bytes()
    chunk.write_bytes(bytes([good[0] ^ 1]) + good[1:])
    run(CAMPAIGN, copy, SHORT)
    assert chunk.read_bytes() == good
    assert RunFolder.open(copy).account().missing == 0
    RunFolder.open(copy).verify()
