"""The report of 12,000 samples, more than a sketch knows exactly, against NumPy on the whole table."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy.stats import spearmanr

from rvjax.analysis import verdicts
from rvjax.analysis.accumulator import RunAccumulator
from rvjax.analysis.run_totals import HEAD
from rvjax.errors import FolderError
from rvjax.report import build, plotting, write
from rvjax.report.run_view import assemble_run
from rvjax.run_folder import RunFolder
from rvjax.stats import dkw_band, quantile_interval
from rvjax.stats.quantile_sketch import EXACT, RELATIVE_ERROR, Sketch
from rvjax.stats.sampling_design import Independent

SAMPLES = 12_000
FIRST = HEAD * 256
"""Samples in the first chunks of a made-up run."""

Make = Callable[..., Path]
Within = Callable[[], AbstractContextManager[None]]


@pytest.fixture(scope="module")
def folder(made: Make, tmp_path_factory: pytest.TempPathFactory, svg_only: Within) -> Path:
    """A built report of 12,000 samples in 47 chunks."""
    path = made(tmp_path_factory.mktemp("run") / "large", SAMPLES, (0.9, 0.06, 0.04))
    with svg_only():
        build(path)
    return path


@pytest.fixture(scope="module")
def table(folder: Path) -> pd.DataFrame:
    return RunFolder.open(folder).samples().frame


@pytest.fixture(scope="module")
def summary(folder: Path) -> dict[str, Any]:
    return json.loads((folder / "summary.json").read_text())


def value(number: float | None, worst: float) -> float:
    """null stands for infinity."""
    return worst if number is None else number


def test_quantiles_are_those_of_the_table(folder: Path, table: pd.DataFrame, summary: dict[str, Any]) -> None:
    """Each within the stated error, in an interval that holds the exact one, equal to it in the tails.

    Kills: quantiles of the first samples, NaN that is dropped, a rank off by one in the tail, a narrowed interval.
    """
    columns = RunFolder.open(folder).samples().columns
    numbers = summary["numbers"]
    names = [key for key in numbers if re.fullmatch(r".*\.q\d+", key) and f"metric.{key.rpartition('.')[0]}" in table]
    assert len(names) > 120
    for key in names:
        name, _, level = key.rpartition(".q")
        worst = -math.inf if columns[f"metric.{name}"].better == "higher" else math.inf
        truth = quantile_interval(table[f"metric.{name}"].to_numpy(), float(level) / 100, 0.95, worst=worst)
        found, low, high = (value(numbers[key][part], worst) for part in ("value", "low", "high"))
        assert numbers[key]["n"] == SAMPLES
        assert low <= truth.low <= truth.high <= high, key
        assert found == truth.value or abs(found - truth.value) <= RELATIVE_ERROR * abs(truth.value), key
        if float(level) / 100 * SAMPLES > SAMPLES - EXACT:
            assert (found, low, high) == (truth.value, truth.low, truth.high), key


def test_shares_and_the_account_are_exact(table: pd.DataFrame, summary: dict[str, Any]) -> None:
    """Kills: a share of the first samples, buckets counted for numbers, > for >= at the runaway."""
    lost = (table["outcome"] == "not_finite").to_numpy()
    events = {
        "captured.share": (table["outcome"] == "captured"),
        "not_settled.share": (table["outcome"] == "not_settled"),
        "not_finite.share": lost,
        "settling_time_s.never.share": lost | np.isinf(table["metric.settling_time_s"]),
        "fault_recovery_s.never.share": lost,
        "peak_chi.runaway.share": lost | (table["metric.peak_chi"] >= 10),
    }
    for key, holds in events.items():
        assert summary["numbers"][key]["value"] == np.count_nonzero(holds) / SAMPLES, key
        assert summary["numbers"][key]["n"] == SAMPLES
    assert summary["account"]["captured"] == (table["outcome"] == "captured").sum()
    assert summary["account"]["not_finite"] == lost.sum()
    assert sum(summary["account"].values()) == 2 * SAMPLES


def test_verdicts_are_those_of_the_table(folder: Path, table: pd.DataFrame, summary: dict[str, Any]) -> None:
    """Kills: successes counted in buckets, a requirement that is folded into another's."""
    required = verdicts.campaign_of(RunFolder.open(folder)).require
    whole = verdicts.judge_all(required, RunFolder.open(folder).samples(), Independent())
    assert verdicts.judge_folder(folder) == whole
    assert [verdict["text"] for verdict in summary["requirements"]] == [verdict.text for verdict in whole]
    times, duty = (table[f"metric.{name}"].to_numpy() for name in ("settling_time_s", "saturation_duty.any"))
    captured = np.count_nonzero(table["outcome"] == "captured")
    assert [verdict.successes for verdict in whole] == [captured, np.count_nonzero(times < 150), np.count_nonzero(duty < 0.2)]


def test_what_looks_at_single_samples_says_how_many(folder: Path, table: pd.DataFrame, summary: dict[str, Any]) -> None:
    """Kills: an n of all samples beside a number of the first ones, a caption that claims all."""
    correlations = {key: number for key, number in summary["numbers"].items() if key.startswith("correlation.")}
    assert correlations
    assert {number["n"] for number in correlations.values()} == {FIRST}
    bins = [summary["numbers"][f"saturation_duty.fx.bin{place}.q95"]["n"] for place in range(1, 6)]
    assert sum(bins) == FIRST
    text = (folder / "report.md").read_text()
    assert text.count("Of the first 6,400 samples.") == 5  # severity: 2; worst; which draws: figure, settling
    assert "read from sketches" in text
    assert "relative error of up to 0.05\u00a0%" in text
    first = table.iloc[:FIRST].fillna({"metric.settling_time_s": math.inf})
    distance = np.linalg.norm(first[[f"draw.start.rho_m.{axis}" for axis in "xyz"]], axis=1)
    truth = spearmanr(distance, first["metric.settling_time_s"]).statistic
    assert correlations["correlation.settling_time_s.|start.rho_m|"]["value"] == pytest.approx(truth)


def test_a_drawn_distribution_goes_through_the_order_statistics(table: pd.DataFrame) -> None:
    """Up to the last finite one. Kills: shares of the points drawn instead of all, a band for fewer samples, one rank off."""
    x = table["metric.peak_chi"].fillna(math.inf).to_numpy()
    _, (axis,) = plotting.axes(1, 1, 3.0)
    plotting.distribution(axis, Sketch(x), plotting.BLUE, "x", dkw_band(x.size, 0.95))
    steps = np.asarray(axis.lines[0].get_xydata())[::2]
    finite, n = np.sort(x[np.isfinite(x)]), x.size
    assert len(steps) <= 200
    assert steps[0].tolist() == [finite[0], 0.0]
    assert axis.lines[1].get_xdata()[0] == finite[-1]
    assert axis.lines[1].get_ydata()[0] == finite.size / n
    for place, share in np.asarray(axis.lines[0].get_xydata())[1::2]:
        rank = round(share * n) - 1
        assert share * n == pytest.approx(rank + 1)
        assert abs(place - finite[rank]) <= RELATIVE_ERROR * finite[rank]
    band = axis.collections[0].get_paths()[0].vertices
    assert band[:, 1].min() == 0.0
    middle = np.abs(np.asarray(axis.lines[0].get_ydata()) - 0.5).argmin()
    place, share = np.asarray(axis.lines[0].get_xydata())[middle]
    assert np.isclose(band, [place, share + dkw_band(n, 0.95)]).all(axis=1).any()


def test_worst_samples_and_onsets_are_those_of_all(folder: Path, table: pd.DataFrame) -> None:
    """Kills: the worst of the first samples, onsets of the first ones. 480 are not finite: the earliest lead."""
    lost = table[table["outcome"] == "not_finite"].sort_values(["outcome_time_s", "sample"])
    assert lost["sample"].iloc[:10].max() >= FIRST
    text = (folder / "report.md").read_text()
    shown = re.findall(r"^\| (\d+) \| \*\*not\\?_finite\*\*", text, re.MULTILINE)
    assert [int(sample) for sample in shown] == lost["sample"].iloc[:10].tolist()
    fold = RunAccumulator([], Independent())
    for part in RunFolder.open(folder).tables():
        fold.add(*part)
    onsets = table.filter(regex=r"draw\.faults\..*onset").to_numpy()
    campaign = verdicts.campaign_of(RunFolder.open(folder))
    assert assemble_run(RunFolder.open(folder), fold, campaign).onsets() == (onsets.min(), onsets.max())


def test_chunks_in_any_order_give_the_same_bytes(folder: Path, svg_only: Within) -> None:
    """From a fold that was made elsewhere, too. Kills: a report that depends on what came first, or reads samples again."""

    def contents() -> dict[str, bytes]:
        made = [*folder.glob("report.*"), *folder.glob("figures/*"), folder / "summary.json"]
        return {path.name: path.read_bytes() for path in made}

    before, here = contents(), RunFolder.open(folder)
    campaign = verdicts.campaign_of(here)
    fold = RunAccumulator(campaign.require, Independent(), campaign.keep)
    for number, frame, columns in reversed(list(here.tables())):
        fold.add(number, frame, columns)
    aside = folder / "samples"
    aside.rename(folder / "aside")
    try:
        with svg_only():
            write(here, assemble_run(here, fold, campaign))
        with pytest.raises(FolderError, match="missing"):
            build(folder)
    finally:
        (folder / "aside").rename(aside)
    assert contents() == before


def test_the_summary_has_the_keys_of_a_small_run(report: Path, summary: dict[str, Any]) -> None:
    """Apart from the draws that go with the result. Kills: a number that only large runs have, or lack."""
    keys = [
        {key for key in numbers if not key.startswith(("correlation.", "which-draws."))}
        for numbers in (summary["numbers"], json.loads((report / "summary.json").read_text())["numbers"])
    ]
    assert keys[0] == keys[1]
