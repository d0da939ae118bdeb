"""The section on safety, and a report with all four outcomes."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from scipy import stats

from rvjax.report import build
from rvjax.report.plotting import STYLE
from rvjax.report.run_view import Run, open_run
from rvjax.report.sections import other_metrics, safety
from rvjax.run_folder import Column, RunDescription, RunFolder

N, CRASHED = 400, 60
UNITS = {
    **dict.fromkeys(("hull_clearance_m", "closest_axial_m", "closest_lateral_m"), "m"),
    "collision_time_s": "s",
    "collision_speed_m_s": "m/s",
    "keep_out_violation_s": "s",
}


@pytest.fixture(scope="module")
def folder(made: Callable[..., Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The made-up run with hulls: the first CRASHED of the samples that are finite collide."""
    place = tmp_path_factory.mktemp("safety")
    old = RunFolder.open(made(place / "plain", N, (0.9, 0.07, 0.03)))
    text = old.campaign_text().replace("port_m: [5, 0, 0]", "port_m: [5, 0, 0], hull: {radius_m: 2}, keep_out: {radii_m: 4}")
    text = text.replace("mass_kg:", "hull: {box_m: 1}, mass_kg:", 1) + "corridor: {radius_m: 0.3, length_m: 8}\n"
    assert text.count("hull: ") == 2
    generator = np.random.default_rng(4)
    frame = old.samples().frame
    columns = {name: column for _, _, known in old.tables() for name, column in known.items()}
    lost = (frame["outcome"] == "not_finite").to_numpy()
    hit = ~lost & (np.cumsum(~lost) <= CRASHED)
    clearance = np.where(hit, -generator.uniform(0.0, 1.0, N), generator.uniform(0.0, 3.0, N))
    values = {
        "hull_clearance_m": clearance,
        "closest_axial_m": generator.uniform(-6.0, 0.0, N),
        "closest_lateral_m": generator.uniform(0.0, 3.0, N),
        "collision_time_s": np.where(hit, generator.uniform(10.0, 90.0, N), math.inf),
        "collision_speed_m_s": np.where(hit, generator.uniform(0.1, 0.5, N), 0.0),
        "keep_out_violation_s": np.where(np.arange(N) % 5 == 0, generator.uniform(0.0, 9.0, N), 0.0),
    }
    stays = {*values, "corridor_violation_s", "closest_approach_m"}
    for name in [str(name) for name in frame.columns if str(name).startswith("metric.")]:
        if name.removeprefix("metric.") not in stays:
            frame.loc[hit, name] = 0.0 if name == "metric.captured" else math.nan
    frame = frame.assign(**{f"metric.{name}": np.where(lost, math.nan, x) for name, x in values.items()})
    frame["outcome"] = np.where(hit, "collided", frame["outcome"])
    better = {"hull_clearance_m": "higher", "collision_time_s": "higher", "closest_axial_m": "", "closest_lateral_m": ""}
    columns |= {f"metric.{n}": Column(f"metric.{n}", unit, n, better.get(n, "lower")) for n, unit in UNITS.items()}
    description = RunDescription(
        identity=old.identity, provenance=old.provenance, campaign_text=text, samples=N + 10, name=old.name
    )
    with RunFolder.create(place / "run", description) as new:
        new.commit(0, frame, columns)
    return place / "run"


@pytest.fixture(scope="module")
def run(folder: Path) -> Iterator[Run]:
    with matplotlib.rc_context(STYLE):
        yield open_run(folder)


def test_a_report_of_all_four_outcomes_adds_up(folder: Path, undrawn: Callable[[], AbstractContextManager[None]]) -> None:
    """Kills: collided samples that are left out of the account, or counted twice."""
    with undrawn():
        build(folder)
    summary = json.loads((folder / "summary.json").read_text())
    account = summary["account"]
    assert account["collided"] == CRASHED
    assert min(account.values()) > 0
    assert sum(value for name, value in account.items() if name != "requested") == account["requested"] == N + 10
    text = re.sub(r"<[^>]*>|\s+", " ", (folder / "report.html").read_text())
    shown = r"(\d+) captured \+ (\d+) not settled \+ (\d+) collided \+ (\d+) not finite \+ (\d+) missing = (\d+) requested"
    for found in re.findall(shown, text):
        assert [int(part) for part in found][2] == CRASHED
    assert "then collided ones, by time of collision" in text
    captured = summary["numbers"]["captured.share"]["value"]
    assert captured == account["captured"] / N


def test_the_numbers_of_the_section(run: Run) -> None:
    """Against the table. Kills: the wrong tail of the clearance, an interval by another method, the speeds of all samples, a
    clearance of collided samples that counts as −∞."""
    frame = run.head
    section = safety.section(run)
    assert section is not None
    numbers = {number.name: number.estimate for number in section.numbers() if not isinstance(number.value, int)}
    low, high = stats.binomtest(CRASHED, N).proportion_ci(method="exact")
    share = numbers["collided.share"]
    assert (share.value, share.low, share.high) == pytest.approx((CRASHED / N, low, high), rel=1e-9)  # type: ignore[union-attr]
    clearance = np.sort(frame["metric.hull_clearance_m"].fillna(-math.inf))
    assert numbers["hull_clearance_m.q5"].value == clearance[math.ceil(0.05 * N) - 1]
    time = np.sort(frame["metric.keep_out_violation_s"].fillna(math.inf))
    assert numbers["keep_out_violation_s.q95"].value == time[math.ceil(0.95 * N) - 1]
    violated = np.count_nonzero(~(frame["metric.keep_out_violation_s"] == 0.0))
    assert numbers["keep_out_violation_s.some.share"].value == violated / N
    (sentence,) = [block for block in section.body if isinstance(block, str)]
    hit = frame[frame["outcome"] == "collided"]
    first, last, slow, fast, middle = map(float, re.findall(r"\d+(?:\.\d+)?", sentence)[1:])
    assert (first, last) == pytest.approx((hit["metric.collision_time_s"].min(), hit["metric.collision_time_s"].max()), rel=1e-2)
    speeds = np.sort(hit["metric.collision_speed_m_s"])
    assert (slow, middle, fast) == pytest.approx((speeds[0], speeds[CRASHED // 2 - 1], speeds[-1]), rel=1e-2)


def test_the_section_is_there_where_there_is_something_to_say(
    run: Run, report: Path, made: Callable[..., Path], tmp_path: Path
) -> None:
    """Kills: a section in every report; metrics that are shown twice or nowhere."""
    plain = open_run(made(tmp_path / "run", 60))
    assert safety.section(plain) is None
    others = {row[0].name for row in other_metrics.section(run).body[0].rows}  # type: ignore[union-attr]
    assert "corridor violation" not in others
    assert "hull clearance" not in others
    assert "Δv" in others
    assert "corridor violation" in {row[0].name for row in other_metrics.section(plain).body[0].rows}  # type: ignore[union-attr]
