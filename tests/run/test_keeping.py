"""Which flights a run keeps, flown again after the pass."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from rvjax.execution.replay import replay
from rvjax.execution.run import run
from rvjax.run_folder import RunFolder
from tests.progress import append_flown
from tests.short import CAMPAIGN, QUICK, SHORT

SAMPLES = 60
GROUP = 20
"""Flights that are traced together here, so that few samples are several groups."""

SOME = [
    *SHORT,
    f"samples={SAMPLES}",
    "horizon={duration_s: 20, step_s: 0.2}",
    QUICK,
    "capture={position_m: 18, attitude_mrp: 1, window_s: 5}",
]
"""Not every sample is captured; few steps, since of most samples every one is kept."""


def kept(folder: Path) -> list[int]:
    """The samples whose flights are kept; all files are intact."""
    opened = RunFolder.open(folder)
    opened.verify()
    return opened.trace_samples()


@pytest.mark.usefixtures("bare")
def test_each_way_to_keep_and_from_one_to_another(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """All with one folder, in which nothing but the kept flights is flown again. Kills: a policy that does nothing, one sample
    off, flights of an older policy that stay, more than one group of flights mixed up, a flight kept under another number."""
    monkeypatch.setattr("rvjax.execution.run.TRACED", GROUP)
    folder = tmp_path / "run"
    run(CAMPAIGN, folder, [*SOME, "keep={worst: 0, failed: true}"])
    frame = RunFolder.open(folder).samples().frame
    failed = frame.loc[frame["outcome"] != "captured", "sample"].tolist()
    assert 5 < len(failed) < SAMPLES / 2
    assert kept(folder) == failed
    before = {path.name: path.read_bytes() for path in (folder / "traces").iterdir()}

    flown: list[int] = []
    run(CAMPAIGN, folder, [*SOME, "keep={all: true}"], progress=append_flown(flown))
    assert kept(folder) == list(range(SAMPLES))
    assert SAMPLES - len(before) > GROUP, "several groups"
    assert {name: (folder / "traces" / name).read_bytes() for name in before} == before
    opened = RunFolder.open(folder)
    for sample in (37, SAMPLES - 1):
        again, _, row = replay(folder, sample)
        pd.testing.assert_frame_equal(opened.trace(sample), again, check_exact=True)
        last = opened.trace(sample).iloc[-1]
        error = np.sqrt(sum(last[f"rho_{axis}_m"] ** 2 for axis in "xyz"))
        assert error == pytest.approx(row["metric.final_position_error_m"], rel=1e-14)

    run(CAMPAIGN, folder, [*SOME, "keep={worst: 0, percentiles: true}"], progress=append_flown(flown))
    settling = frame["metric.settling_time_s"].fillna(np.inf).to_numpy()
    order = np.argsort(settling, kind="stable")
    assert kept(folder) == sorted({int(order[int(np.ceil(q * SAMPLES)) - 1]) for q in (0.05, 0.25, 0.5, 0.75, 0.95)})

    run(CAMPAIGN, folder, SOME, progress=append_flown(flown))
    window = frame["metric.window_position_error_m"]
    worst = frame.assign(window=window)[frame["outcome"] == "not_settled"].sort_values("window", ascending=False)["sample"][:10]
    assert kept(folder) == sorted(worst)
    assert flown == []


@pytest.mark.usefixtures("bare")
@pytest.mark.parametrize(("steps", "times"), [(600, 601), (1201, 402)])
def test_a_kept_flight_has_at_most_601_rows(tmp_path: Path, steps: int, times: int) -> None:
    """Every n-th step and the last, as the documents promise; a replay has every step. Kills: a long flight kept step by step,
    a trace that ends before the flight does, a row count that is off."""
    step = 0.05
    horizon = f"horizon={{duration_s: {steps * step:.2f}, step_s: {step}}}"
    run(CAMPAIGN, tmp_path / "run", [*SHORT, QUICK, "samples=4", horizon, "keep={worst: 1}"])
    opened = RunFolder.open(tmp_path / "run")
    (sample,) = opened.trace_samples()
    kept_times = opened.trace(sample)["t_s"].to_numpy()
    apart = -(-steps // 600)
    assert len(kept_times) == times <= 601
    np.testing.assert_allclose(kept_times, [*np.arange(0, steps, apart) * step, steps * step], atol=1e-9)
    assert len(replay(tmp_path / "run", sample)[0]) == steps + 1
