"""The article on the study: its tables are those of the record, and the record is what the run folders say."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from ruamel.yaml import YAML

from benchmarks.study import results, stages, tables
from benchmarks.study.controllers import CAMPAIGN, entries
from benchmarks.study.page import PAGE, PLACE, written
from rvjax.campaign import load
from rvjax.columns import CHANNELS
from rvjax.components.registry import members

ROOT = Path(__file__).parents[2]
RECORD: dict[str, Any] = json.loads(results.RECORD.read_text(encoding="utf-8"))
TEXT = PAGE.read_text(encoding="utf-8")


def test_the_tables_are_those_of_the_record() -> None:
    """Kills: a record that came anew without its page, and a number that was changed by hand."""
    assert written(TEXT, RECORD) == TEXT, "run: python -m benchmarks.study.page"
    assert sorted(place[1] for place in PLACE.findall(TEXT)) == sorted(tables.TABLES)


@pytest.mark.parametrize("table", tables.TABLES)
def test_every_table_shows_its_numbers(table: str) -> None:
    """Each controller has a row in each table, and the row changes with the controller's numbers. Kills: a table of another
    controller's numbers, and a table that is not of the record."""
    names = list(RECORD["controllers"])
    turned = deepcopy(RECORD)
    turned["controllers"] = {
        name: RECORD["controllers"][other] for name, other in zip(names, [*names[1:], names[0]], strict=True)
    }
    before, after = (tables.TABLES[table](record).splitlines() for record in (RECORD, turned))
    assert len(before) == len(after) >= 2 + len(names) - (table == "paired")
    assert before[2:] != after[2:]


def test_the_study_is_what_it_says() -> None:
    """All controllers of the package, at least 10⁵ samples, the requirements of the campaign, the controllers of the list.
    Kills: a controller that is left out, a record of a shorter campaign."""
    spec, studied = load(CAMPAIGN), entries()
    assert {entry.controller["use"] for entry in studied} == set(members("controllers"))
    assert len(studied) >= 9
    assert RECORD["samples"] == spec.samples >= 100_000
    assert list(RECORD["controllers"]) == [entry.name for entry in studied]
    for entry in studied:
        of = RECORD["controllers"][entry.name]
        assert list(of["requirements"]) == [requirement.id for requirement in spec.require]
        assert set(of["search"]["gains"]) == {*entry.parameters, *entry.tied}
        account = of["account"]
        assert sum(of["classes"].values()) == RECORD["samples"] == account["requested"]
        assert of["classes"]["captured"] == account["captured"]
        assert of["classes"]["collided"] == account["collided"]


def test_the_searches_have_the_campaigns_requirements() -> None:
    """All but that on collisions, which a few thousand samples cannot judge. Kills: a search under other requirements."""
    judged = {json.dumps(stage, sort_keys=True) for stage in stages.searched()}
    given = YAML(typ="safe").load(CAMPAIGN.read_text(encoding="utf-8"))["require"]
    campaigns = [{key: value for key, value in each.items() if key != "id"} for each in given if each["id"] != "collision"]
    assert [each["metric"] for each in stages.searched()] == [
        "hull_clearance_m",
        "keep_out_violation_s",
        "corridor_violation_s",
        "captured",
    ]
    assert stages.searched()[0]["above"] == 0.5
    assert judged == {json.dumps(each, sort_keys=True) for each in campaigns}


def _table() -> pd.DataFrame:
    """Eight flights, one in each class and three captured; those with a stuck valve are the first five."""
    outcomes = ["collided", "not_finite", "not_settled", "not_settled", "not_settled", "captured", "captured", "captured"]
    columns = {f"draw.faults.{kind}.schedule.failing": [1.0] * 5 + [0.0] * 3 for kind in results.KINDS}
    columns["draw.faults.lag.schedule.failing"] = [0.0, 0, 0, 0, 0, 2, 1, 1]
    return pd.DataFrame(
        {
            "outcome": outcomes,
            "metric.window_position_error_m": [np.nan, np.nan, 9.0, 0.2, 0.01, 0.01, 0.01, 0.01],
            "metric.keep_out_violation_s": [5.0, np.nan, 1.0, 0, 0, 2.0, 0, 0],
            "metric.corridor_violation_s": [5.0, np.nan, 0.0, 0, 0, 0, 0, 0],
            "metric.delta_v_m_s": [np.nan, np.nan, 2.0, 2, 2, 1.0, 3.0, 2.0],
            **columns,
        }
    )


def test_a_flight_is_in_one_class() -> None:
    """By hand. Kills: a captured or collided flight counted as one that left the corridor, position and attitude exchanged."""
    counted = results.failure_classes(_table())
    assert counted == {
        "collided": 1, "not finite": 1, "left the corridor": 1, "position": 1, "attitude only": 1, "captured": 3
    }  # fmt: skip


def test_failures_are_split_by_kind_of_fault() -> None:
    """By hand, and a Clopper-Pearson bound in closed form: 1 − 0.025^(1/3) for 0 of 3. Kills: with and without exchanged."""
    by_kind = results.failures_by_kind(_table())
    stuck, lag = by_kind["stuck"], by_kind["lag"]
    assert (stuck["with"]["count"], stuck["with"]["n"], stuck["without"]["count"], stuck["without"]["n"]) == (5, 5, 0, 3)
    assert (lag["with"]["count"], lag["with"]["n"], lag["without"]["count"], lag["without"]["n"]) == (0, 3, 5, 5)
    assert stuck["without"]["high"] == pytest.approx(1 - 0.025 ** (1 / 3), rel=1e-12)


def test_failures_are_split_by_channel() -> None:
    """By hand: fx is weak in flights 0, 2 and 6; in 0 and 6 its driver restarts as well, and 0 collides. Kills: a channel that is
    weak without a fault (flight 3 has no onset), the limit turned round, collisions of other flights counted."""
    table = _table()
    for channel in CHANNELS:
        table[f"draw.faults.effectiveness.onset_s.{channel}"] = np.inf
        table[f"draw.faults.effectiveness.remaining.{channel}"] = 0.3
        table[f"draw.faults.dropout.onset_s.{channel}"] = np.inf
    table["draw.faults.effectiveness.onset_s.fx"] = [40.0, 40, 40, np.inf, 40, 40, 40, 40]
    table["draw.faults.effectiveness.remaining.fx"] = [0.3, 0.9, 0.39, 0.2, 0.9, 0.41, 0.2, 0.9]
    table["draw.faults.dropout.onset_s.fx"] = [50.0, 50, np.inf, 50, 50, 50, 50, np.inf]
    came = results.failures_by_channel(table)
    assert (came["weak"]["fx"]["count"], came["weak"]["fx"]["n"], came["weak"]["tz"]["n"]) == (2, 3, 0)
    assert came["braking"] == {"flights": 2, "collided": 1, "of": 1}


def test_pairs_are_counted_and_tested() -> None:
    """McNemar's exact test by the binomial sum: 1 against 3 of 4. Kills: sides exchanged, a one-sided test."""
    here, there = _table(), _table()
    here["outcome"] = ["captured", "x", "x", "x", "captured", "captured", "captured", "captured"]
    there["outcome"] = ["x", "captured", "captured", "captured", "captured", "captured", "captured", "captured"]
    came = results.against(here, there)
    assert (came["only"], came["other"], came["both"]) == (1, 3, 4)
    assert came["p"] == pytest.approx(2 * sum(math.comb(4, k) for k in (0, 1)) / 2**4)


def test_fuel_is_compared_over_flights_that_both_capture() -> None:
    """40 pairs that differ by 1 … 40, and 40 that only one of both captures, which differ by 1000. The ends of the interval are
    the 14th and the 27th: P(B ≤ 13) = 0.0192 and P(B ≤ 14) = 0.0403 of 40 fair coins. Kills: the other flights counted, an
    interval of another coverage."""
    n = 40
    other = pd.DataFrame({"outcome": ["captured"] * 2 * n, "metric.delta_v_m_s": np.zeros(2 * n)})
    outcomes = ["captured"] * n + ["not_settled"] * n
    this = pd.DataFrame({"outcome": outcomes, "metric.delta_v_m_s": [*range(n, 0, -1), *[1000.0] * n]})
    assert results.against(this, other)["delta_v"] == {"value": 20.5, "low": 14.0, "high": 27.0}


@pytest.mark.parametrize(
    ("value", "shown"), [(0.99996, "99.996"), (1.0, "100"), (0.0, "0"), (0.5, "50.00"), (0.99, "99.00"), (1e-7, "0.00001")]
)
def test_a_share_is_never_rounded_to_all_or_none(value: float, shown: str) -> None:
    """Kills: 100 % for a controller that lost a flight, and 0 for one that lost few."""
    assert tables.percent(value) == shown


def _studied(out: Path, *more: str) -> None:
    sizes = ("--samples", "416", "--candidates", "3", "--confirmed", "416", "--flights", "10000", "--ordinary", "416")
    places = ("--out", str(out), "--record", str(out / "results.json"), "--pictures", str(out))
    subprocess.run([sys.executable, "-m", "benchmarks.study", *sizes, *places, *more], check=True, cwd=ROOT)


def test_a_small_study_runs_to_its_record(tmp_path: Path) -> None:
    """Two controllers, 416 samples. Numbers of the record are counted again from the samples tables. Kills: a folder of another
    controller, gains of another search, a table of another order of samples."""
    text = (ROOT / "benchmarks" / "study" / "controllers.yaml").read_text(encoding="utf-8")
    small = tmp_path / "controllers.yaml"
    small.write_text("pd-plus:\n" + text.split("pd-plus:\n")[1], encoding="utf-8")
    _studied(tmp_path, "--controllers", str(small))
    record = json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))
    assert list(record["controllers"]) == ["pd-plus", "lqr-kalman"]
    runs = {"pd-plus": tmp_path / "flights", "lqr-kalman": tmp_path / "flights" / "baselines" / "lqr-kalman"}
    flown = {name: pd.concat(map(pd.read_parquet, (run / "samples").iterdir())) for name, run in runs.items()}
    for name, table in flown.items():
        of = record["controllers"][name]
        assert of["account"]["captured"] == (table.outcome == "captured").sum() == of["classes"]["captured"]
        low, high = np.quantile(table["metric.delta_v_m_s"].fillna(np.inf), [0.47, 0.53])
        assert low <= of["numbers"]["delta_v_m_s.q50"]["value"] <= high
        given = (runs[name] / "manifest.json").read_text(encoding="utf-8")
        candidates = pd.read_csv(tmp_path / "searches" / name / "candidates.csv").set_index("candidate")
        row = candidates.loc[[of["search"]["candidate"]]].iloc[-1]
        for gain, value in of["search"]["gains"].items():
            assert value == row[f"controller.gains.{gain}"]
            assert json.dumps(json.dumps({gain: value}))[2:-2] in given
    one, other = (table.set_index("sample").outcome.sort_index() == "captured" for table in flown.values())
    assert record["controllers"]["lqr-kalman"]["against"]["only"] == (other & ~one).sum()
    assert (tmp_path / "study-cost.svg").stat().st_size > 10_000
    before = (tmp_path / "results.json").read_bytes()
    _studied(tmp_path, "--controllers", str(small), "--stage", "fly", "--stage", "record")
    assert (tmp_path / "results.json").read_bytes() == before
