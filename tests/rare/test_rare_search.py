"""The search of rare failures on the closed loop: its probability, its replays, its resumption, and what it refuses."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import stats

from rvjax.analysis.verdicts import campaign_of
from rvjax.errors import FolderError, UsageError
from rvjax.execution import run
from rvjax.execution.draw_space import DrawSpace
from rvjax.execution.progress import Progress
from rvjax.execution.rare import regions
from rvjax.execution.rare.flights import RareFlights
from rvjax.execution.rare.search import RareSearch
from rvjax.run_folder import RunFolder, rare_record
from rvjax.run_folder.rare_record import RareRecord
from rvjax.simulation.problem import load
from rvjax.stats.rare.points import normal_points
from tests.program import Run

CAMPAIGN = """rvjax: 1
name: seldom
samples: 832
seed: 7
horizon: {duration_s: 10, step_s: 0.1}
capture: {position_m: 0.05, attitude_mrp: 0.05, window_s: 5}
target: {port_m: [5, 0, 0]}
pursuer: {mass_kg: {uniform: [95, 105]}, inertia_kgm2: {principal: [22, 20, 23]}}
start: {rho_m: {normal: [0, 0.3]}, sigma: {box: 0.01}, nu_m_s: {normal: [0, 0.01]}, omega_rad_s: {normal: [0, 0.001]}}
actuators: {upper: {force: 4, torque: 0.8}, lower: {force: 4, torque: 0.8}}
disturbances: [{use: ornstein-uhlenbeck, force_N: 0.5, torque_Nm: 0.001, time_constant_s: 10}]
controller: {use: pd-plus}
require:
  - {metric: window_position_error_m, above: 1.1, at_most: 1.0e-5, method: splitting, budget: {flights: 10000}}
"""


class Stopped(Exception):
    """Ends a search in the middle."""


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("seldom") / "seldom.yaml"
    path.write_text(CAMPAIGN)
    return path


@pytest.fixture(scope="module")
def flown(campaign: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The run, whose search is finished."""
    place = tmp_path_factory.mktemp("run") / "out"
    run.run(campaign, place, progress=False)
    return place


def record_of(place: Path) -> RareRecord:
    """The record of the first requirement."""
    record = rare_record.read(place, 1)
    assert record is not None
    return record


def counted(campaign: Path, samples: int) -> tuple[int, int]:
    """How many of as many ordinary flights fail, by flying them and comparing the column with the limit."""
    problem = load(campaign)
    space = DrawSpace(problem, problem.spec.require[0])
    rng, failing = np.random.default_rng(1), 0
    for _ in range(samples // 416):
        z = rng.standard_normal((416, len(space.coordinates)))
        frame = space.fly_chunk(z, rng.integers(2**40, size=416)).frame
        failing += int(np.sum(frame["metric.window_position_error_m"] > 1.1))
    return failing, samples // 416 * 416


def test_the_probability_is_that_of_counting(campaign: Path, flown: Path) -> None:
    """The mean of the replicates against 8,320 flights at other numbers: each interval misses with probability 1e-4.
    Kills: noise that all flights share, margins of another sign."""
    failing, samples = counted(campaign, 8_320)
    low, high = stats.binomtest(failing, samples).proportion_ci(1 - 1e-4, method="exact")
    values = np.array(record_of(flown).replicates)
    half = stats.t.isf(0.5e-4, len(values) - 1) * values.std(ddof=1) / np.sqrt(len(values))
    assert low <= values.mean() + half
    assert values.mean() - half <= high


def test_the_record_says_what_was_flown(flown: Path) -> None:
    """Flights, replicates and levels belong together. Kills: flights that are not counted, levels in another order."""
    record = record_of(flown)
    levels = len(record.levels) - 1
    assert record.flights - record.learning == len(record.replicates) * record.chains * (10 + 9 * levels)
    assert len(record.replicates) >= 20
    assert [level.level for level in record.levels] == sorted((level.level for level in record.levels), reverse=True)
    assert record.levels[-1].level == 0.0
    assert record.levels[-1].split.value == pytest.approx(np.mean(record.replicates), rel=1e-12)
    assert record.ordinary == 832
    assert all(level.agrees for level in record.levels)
    assert record.refusals == []


def test_a_failing_flight_flies_again(flown: Path, tmp_path: Path) -> None:
    """The exported campaign gives the margins of the record bit for bit, with the noise that the flights had. Kills: the noise of
    sample k for that of the flight, numbers that are rounded in the file."""
    record = record_of(flown)
    place = run.run(flown / "rare-1" / rare_record.FAILING, tmp_path / "again", progress=False)
    frame = RunFolder.open(place).samples().frame
    limit = 1.1
    margins = (limit - frame["metric.window_position_error_m"].to_numpy()) / limit
    assert margins.tolist() == [region.margin for region in record.regions]
    assert all(margin <= 0.0 for margin in margins)
    for name, value in record.regions[0].draws.items():
        assert frame[f"draw.{name}"].iloc[0] == value


def test_a_search_that_was_stopped_is_resumed(campaign: Path, flown: Path, tmp_path: Path) -> None:
    """Stopped in the first pass and in the second, and resumed: the record is that of the undisturbed search, byte for byte.
    Kills: a resumed search with other numbers, chunks that are counted twice."""
    out = tmp_path / "out"

    def stop_at(flights: int) -> Any:
        def on_progress(progress: Progress) -> None:
            if progress.phase == "rare failures" and progress.done >= flights:
                raise Stopped

        return on_progress

    for flights in (1500, 6000):
        with pytest.raises(Stopped):
            run.run(campaign, out, progress=stop_at(flights))
        assert rare_record.read(out, 1) is None
        assert RunFolder.open(out / "rare-1").chunks.total > 0
    run.run(campaign, out, progress=False)
    name = rare_record.NAME
    assert (out / "rare-1" / name).read_bytes() == (flown / "rare-1" / name).read_bytes()


@pytest.mark.parametrize(("passes", "groups"), [("", 1), ("20 estimates", 2)])
def test_a_budget_of_minutes_ends_between_groups(flown: Path, tmp_path: Path, passes: str, groups: int) -> None:
    """A clock that passes the limit as soon as a note begins with `passes`: at once, and there are twenty replicates all the
    same; after the first group, and there is a second. Kills: a search without twenty replicates, one that goes on."""
    (tmp_path / "seldom.yaml").write_text(CAMPAIGN.replace("{flights: 10000}", "{minutes: 1}"))
    problem, now = load(tmp_path / "seldom.yaml"), [0.0]

    def on_progress(progress: Progress) -> None:
        if progress.note.startswith(passes):
            now[0] = 61.0

    shutil.copytree(flown, tmp_path / "out", ignore=shutil.ignore_patterns("rare-1"))
    search = RareSearch(problem, 1, RunFolder.open(tmp_path / "out"), on_progress, clock=lambda: now[0])
    assert len(search.run({}).replicates) == 20 * groups


def test_the_report_shows_the_record(flown: Path) -> None:
    """Estimate, levels, regions and commands of the section are those of the record. Kills: a section without its search,
    levels or regions of another number."""
    record, text = record_of(flown), (flown / "report.md").read_text()
    section = text[text.index("Rare failures\n") :]
    section = section[: section.index("\n## ")]
    assert f"{record.flights:,}, of these {record.learning:,} to learn the levels" in section
    for level in record.levels[:-1]:
        row = next(line for line in section.splitlines() if line.startswith(f"| {level.level:.4g}"))
        assert f"{level.count:,} of 832" in row
        assert row.endswith("| agree |")
    for number, region in enumerate(record.regions, 1):
        assert f"| {number} | {100 * region.share:.0f} % ({region.points:,}) |" in section
        assert f"--sample {region.sample}`" in section
    assert "rare-1/failing.yaml" in section
    assert (flown / "figures" / "rare-1.svg").exists()


def test_parts_near_each_other_are_one_region() -> None:
    """A chain of means 3 σ apart is one region, a mean 5 σ away another, in any order. Kills: each part for itself, all parts in
    one."""
    means = np.array([[0.0, 0.0], [11.0, 0.0], [3.0, 0.0], [6.0, 0.0]])
    came = regions.merged(means).tolist()
    assert came[0] == came[2] == came[3] != came[1]


def test_chunks_of_other_points_are_refused(campaign: Path, flown: Path) -> None:
    """A folder whose chunks are of other points than the search asks for. Kills: margins that are taken for those of other
    flights."""
    problem = load(campaign)
    space = DrawSpace(problem, problem.spec.require[0])
    points = normal_points(np.random.default_rng(99), 416, len(space.coordinates))
    folder = RunFolder.open(flown / "rare-1")
    with pytest.raises(FolderError, match="of other points than this search asks for"):
        RareFlights(space, folder, lambda flights: None, lambda: None).margin(points)


def test_importance_sampling_agrees(campaign: Path, flown: Path, tmp_path: Path) -> None:
    """Both methods within their errors at risk 1e-4 each; the coordinates that are tilted are those of the start. Kills: weights
    of another law, blocks that are not means."""
    out = run.run(campaign, tmp_path / "out", ["require.0.method=importance"], progress=False)
    assert isinstance(out, Path)
    record = record_of(out)
    assert record.weights is not None
    assert {name.rpartition(".")[0] for name in record.weights.coordinates} <= {"start.rho_m", "start.nu_m_s"}
    ours, theirs = np.array(record.weights.blocks), np.array(record_of(flown).replicates)
    half = [stats.t.isf(0.5e-4, len(x) - 1) * x.std(ddof=1) / np.sqrt(len(x)) for x in (ours, theirs)]
    assert abs(ours.mean() - theirs.mean()) <= sum(half)


def test_verdicts_of_the_folder(flown: Path, rvjax: Run, tmp_path: Path) -> None:
    """check DIR: FAIL, exit code 1, and the same words in the terminal, in JSON and in JUnit. Kills: a verdict without the
    search."""
    junit = tmp_path / "junit.xml"
    code, told, _ = rvjax("check", flown, "--json", "--junit-xml", junit)
    (verdict,) = json.loads(told)["verdicts"]
    assert code == 1
    assert verdict["verdict"] == "FAIL"
    assert verdict["rare"]["basis"] == "proved"
    assert verdict["rare"]["proved_low"] > 1e-5
    assert "Estimate by splitting" in verdict["text"]
    assert "(proved)" in verdict["text"]
    xml = junit.read_text()
    assert 'name="basis" value="proved"' in xml
    assert 'name="failure_proved_low"' in xml
    assert verdict["text"] in xml
    _, told, _ = rvjax("check", flown)
    assert " ".join(told.split()).count("The lower bound proves the failure.") == 1


def test_a_record_that_was_edited_is_refused(flown: Path, rvjax: Run) -> None:
    """Kills: a record that is believed without its checksum."""
    path = flown / "rare-1" / rare_record.NAME
    before = path.read_bytes()
    try:
        path.write_bytes(before.replace(b'"ordinary": 832', b'"ordinary": 833'))
        code, _, said = rvjax("check", flown)
    finally:
        path.write_bytes(before)
    assert code == 5
    assert "damaged or edited" in said


def test_the_folder_of_a_search_has_no_verdicts(flown: Path, rvjax: Run) -> None:
    """Kills: flights of a search that are counted like samples."""
    code, _, said = rvjax("check", flown / "rare-1")
    assert code == 2
    assert "the folder of a search of rare failures" in said


def test_rare_takes_a_requirement_by_its_number(campaign: Path, flown: Path, rvjax: Run) -> None:
    """`rvjax rare` on the finished folder prints levels and regions; another number is refused, with its place. Kills: a command
    that searches again, a number from 0."""
    code, told, _ = rvjax("rare", campaign, "--out", flown, "--quiet")
    assert code == 1
    assert "ordinary flights" in told
    assert "the nearest failing flight of each region" in told
    code, _, said = rvjax("rare", campaign, "--requirement", 2)
    assert code == 2
    assert "there is no requirement 2" in said
    assert "seldom.yaml:13" in said


def test_a_margin_without_an_order_is_refused(campaign: Path, rvjax: Run, tmp_path: Path) -> None:
    """All flights have the same saturation: exit code 2 with the place of the metric. Kills: an endless first pass, a trace
    back."""
    sets = "require=[{metric: saturation_duty, channel: any, above: 0.9, at_most: 1.0e-5, method: splitting}]"
    code, _, said = rvjax("run", campaign, "--set", sets, "--set", "start.rho_m=0", "--out", tmp_path / "out", "--quiet")
    assert code == 2
    assert "leads nowhere" in said
    assert "accepted: a metric that comes gradually nearer to its bound" in said


def test_without_draws_there_is_nothing_to_search(tmp_path: Path, rvjax: Run) -> None:
    """Kills: a search of no dimension."""
    path = tmp_path / "fixed.yaml"
    lines = [line for line in CAMPAIGN.splitlines() if not line.startswith(("pursuer", "start", "disturbances"))]
    body = (
        "pursuer: {mass_kg: 100, inertia_kgm2: {principal: [22, 20, 23]}}\nstart: {rho_m: 1, sigma: 0, nu_m_s: 0, omega_rad_s: 0}"
    )
    path.write_text("\n".join([*lines, body, ""]))
    code, _, said = rvjax("validate", path)
    assert code == 2
    assert "nothing is drawn, so method splitting has nothing to search" in said


def test_margins_have_the_sign_of_the_verdict(campaign: Path) -> None:
    """A flight at its bound complies or not as the requirement says, and lost flights are the deeper the earlier they were lost.
    Kills: 0 as a failure where it complies, all lost flights at one depth."""
    problem = load(campaign)
    space = DrawSpace(problem, problem.spec.require[0])
    frame = space.fly_chunk(np.zeros((4, len(space.coordinates)))).frame.iloc[:4].copy()
    frame["metric.window_position_error_m"] = [1.1, np.nextafter(1.1, 2.0), np.nan, np.nan]
    frame["outcome"] = ["captured", "not_settled", "collided", "not_finite"]
    frame["outcome_time_s"] = [1.0, 10.0, 2.5, 10.0]
    margins = space.failure_margins(frame)
    assert 0.0 < margins[0] < 1e-300
    assert -1e-10 < margins[1] <= 0.0
    assert margins[2:].tolist() == [-1.75, -1.0]


def test_a_search_needs_its_run(flown: Path) -> None:
    """The identity of a search is that of its run and more: another run refuses it. Kills: a search of another campaign."""
    identity = RunFolder.open(flown / "rare-1").identity
    assert RunFolder.open(flown).identity.items() <= identity.items()
    with pytest.raises(UsageError, match=r"accepted: .*out$"):
        campaign_of(RunFolder.open(flown / "rare-1"))
