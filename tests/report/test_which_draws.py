"""`rvjax drivers` and the section of the report, on a folder whose results depend on known draws."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy.stats import spearmanr

from rvjax.analysis import drivers
from rvjax.analysis.drivers import Result
from rvjax.columns import Column
from rvjax.report.blocks import Table
from rvjax.report.run_view import open_run
from rvjax.report.sections import which_draws
from rvjax.stats import clopper_pearson, holm
from rvjax.stats.sampling_design import Exploration, Independent, Observed
from tests.once import made_once
from tests.program import Run


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, made: Callable[..., Path]) -> Path:
    """900 made-up samples: the settling time is 2.2 |start.rho_m| + 20 (1 − remaining.fx) and noise; 27 are lost, at random."""
    return made_once(tmp_path_factory, "which-draws", lambda path: made(path, 900, kept=0))


def frame_of(n: int = 400) -> tuple[pd.DataFrame, dict[str, Column]]:
    """A draw that decides a metric and the failures, one that does nothing; a tenth of the flights is lost where it is large."""
    source = np.random.Generator(np.random.Philox(key=1))
    x, other = source.random(n), source.random(n)
    lost = x > 0.9
    frame = pd.DataFrame(
        {
            "sample": np.arange(n),
            "outcome": np.where(lost, "not_finite", "captured"),
            "draw.a": x,
            "draw.b": other,
            "draw.same": 1.0,
            "draw.pursuer.rejected": np.arange(n),
            "metric.best": np.where(lost, np.nan, (x - 0.45) ** 2),
            "metric.noise": source.standard_normal(n),
        }
    )
    columns = {name: Column(name, "m", "", "lower") for name in frame.columns if name.startswith("metric.")}
    return frame, columns


def test_every_form_is_seen_and_lost_flights_count() -> None:
    """Kills: a correlation in place of ξ (the metric is even in x), lost flights dropped from ξ or kept in S, a draw that
    does not vary or a count of rejections taken for a draw."""
    frame, columns = frame_of()
    drawn = drivers.varied(frame)
    assert list(drawn) == ["a", "b"]
    results = [*drivers.failures(frame, ()), *drivers.metrics(frame, columns)]
    found = drivers.drivers(drawn, results, Independent())
    for name in (drivers.NOT_CAPTURED, "best"):
        assert [pair.draw for pair in found.clear(name)] == ["a"]
    assert not found.clear("noise")
    best = next(pair for pair in found.of("best") if pair.draw == "a")
    assert best.left_out == pytest.approx(float(np.mean(frame["outcome"] == "not_finite")))
    assert best.share is not None
    assert best.share.n == int(np.sum(frame["outcome"] == "captured"))
    assert best.share.value > 0.95


def test_p_values_are_holms_for_all_pairs() -> None:
    """Kills: Holm for each result by itself, or none."""
    frame, columns = frame_of()
    results = [*drivers.failures(frame, ()), *drivers.metrics(frame, columns)]
    found = drivers.drivers(drivers.varied(frame), results, Independent())
    assert len(found.pairs) == 6
    assert [pair.p_holm for pair in found.pairs] == pytest.approx(holm([pair.p or 0.0 for pair in found.pairs]).tolist())
    assert [pair.p for pair in found.pairs] == sorted(pair.p or 0.0 for pair in found.pairs)


def test_an_exploration_has_no_p() -> None:
    """Kills: a test or an interval from samples that are not independent."""
    frame, columns = frame_of()
    found = drivers.drivers(drivers.varied(frame), drivers.metrics(frame, columns), Exploration())
    assert {pair.p for pair in found.pairs} == {pair.p_holm for pair in found.pairs} == {None}
    assert all(isinstance(pair.share, Observed) for pair in found.pairs)
    assert not found.clear("best")
    part = drivers.failing_classes(frame["draw.a"].to_numpy(), np.ones(400), Exploration(), 0.95)[0]
    assert (part.share.low, part.share.high) == (0.0, 1.0)


def test_an_index_that_a_flight_decides_is_not_shown() -> None:
    """Kills: the index of a metric whose variance is that of a single flight."""
    y = np.random.Generator(np.random.Philox(key=2)).standard_normal(400)
    x = np.random.Generator(np.random.Philox(key=3)).random(400)
    (even,) = drivers.drivers({"x": x}, [Result("y", y)], Independent()).pairs
    (wild,) = drivers.drivers({"x": x}, [Result("y", np.append(y[1:], 1e4))], Independent()).pairs
    assert even.share is not None
    assert wild.share is None


def test_the_command_finds_the_known_drivers(folder: Path, rvjax: Run) -> None:
    """Kills: draws of another table, the wrong sign of a tail, classes that do not add up."""
    code, told, _ = rvjax("drivers", folder, "--result", "settling_time_s", "--result", "failures", "--json")
    assert code == 0
    document = json.loads(told)
    clear = [p["draw"] for p in document["pairs"] if p["result"] == "settling_time_s" and p["p_holm"] <= 0.05]
    assert clear[0] == "|start.rho_m|"
    assert {"pursuer.mass_kg", "start.sigma.x"}.isdisjoint(clear)
    assert document["samples"] == 900
    for table in document["failing"]:
        assert sum(part["share"]["n"] for part in table["classes"]) == 900
    parts: list[Any] = document["failing"][0]["classes"]
    one = parts[0]["share"]
    exact = clopper_pearson(round(one["value"] * one["n"]), one["n"], 1 - 0.05 / len(parts))
    assert (one["low"], one["high"]) == (exact.low, exact.high)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--result", "settling_tme_s"), "--result settling_tme_s: no metric of this run; did you mean settling_time_s"),
        (("--draw", "pursuer.mas_kg"), "--draw pursuer.mas_kg: no draw of this run that varies; did you mean pursuer.mass_kg"),
    ],
)
def test_names_that_are_not_there(folder: Path, rvjax: Run, arguments: tuple[str, ...], said: str) -> None:
    """Kills: an unknown name that gives an empty table."""
    code, _, told = rvjax("drivers", folder, *arguments)
    assert code == 2
    assert said in told


def test_few_samples_are_refused(tmp_path: Path, made: Callable[..., Path], rvjax: Run) -> None:
    """Kills: an asymptotic law for a handful of samples."""
    code, _, told = rvjax("drivers", made(tmp_path / "few", 20, kept=0))
    assert code == 2
    assert "20 samples; accepted: a run of 30 or more" in told


def test_the_section_says_the_same(folder: Path) -> None:
    """Kills: a section about another result, intervals of one class each, a lead that counts pairs."""
    run = open_run(folder)
    section = which_draws.section(run)
    assert section is not None
    assert "|start.rho_m| the most clearly, for the settling time" in section.lead
    names = {number.name for number in section.numbers()}
    assert "which-draws.settling_time_s.|start.rho_m|.share" in names
    assert all(math.isfinite(number.estimate.value) for number in section.numbers())


def test_rank_correlations_stand_beside_xi(folder: Path) -> None:
    """Spearman's by SciPy. Kills: a correlation of another result or draw, a draw whose correlation is clear left out."""
    run = open_run(folder)
    section = which_draws.section(run)
    assert section is not None
    known = {number.name: number.estimate.value for number in section.numbers()}
    distance = np.linalg.norm([run.draw_of_head(f"start.rho_m.{axis}") for axis in "xyz"], axis=0)
    for result in ("settling_time_s", "window_position_error_m"):
        values = run.metric_of_head(result)
        named = {name for name in known if name.startswith(f"correlation.{result}.")}
        assert result != "settling_time_s" or f"correlation.{result}.|start.rho_m|" in named
        for name in named:
            path = name.removeprefix(f"correlation.{result}.")
            x = distance if path == "|start.rho_m|" else run.draw_of_head(path)
            assert known[name] == pytest.approx(spearmanr(x, values).statistic)
    (picture,) = section.drawings
    assert "|start.rho_m|" in [label.get_text() for label in picture.figure.axes[0].get_yticklabels()]


def test_an_exploration_has_correlations_only(folder: Path) -> None:
    """Kills: p-values in the report of a plan."""
    run = open_run(folder)
    section = which_draws.section(type(run)(**{**vars(run), "design": Exploration()}))
    assert section is not None
    (table,) = (block for block in section.body if isinstance(block, Table))
    assert table.head == ("draw", "settling time", "window position error")
    assert "confidence" not in table.caption
