"""A tuning from its campaign to its folder: what flew, what it found, and that nothing of it depends on how it came about."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import time
from collections import OrderedDict
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rvjax.campaign.overrides import value_at
from rvjax.campaign.source import read
from rvjax.components.search_methods import sobol
from rvjax.errors import FolderError
from rvjax.run_folder import RunFolder, tuning_record
from rvjax.run_folder.tuning_record import Searched
from rvjax.search.tuning import tune as tuning
from rvjax.simulation.batch import LANES, Flyer
from rvjax.simulation.draws import Draws
from rvjax.simulation.engines import choice
from rvjax.simulation.engines.llvm import engine
from rvjax.simulation.problem import load
from tests.program import Run
from tests.tuning.short import write

KEPT = ("search.json", "candidates.csv", "best.yaml", "report.md")


@pytest.fixture(scope="module", autouse=True)
def _bare() -> Iterator[None]:
    """Reports of the two runs without sections: they are looked at elsewhere."""
    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.setattr("rvjax.report.sections.SECTIONS", ())
        yield


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write(tmp_path_factory.mktemp("campaign"))


@pytest.fixture(scope="module")
def compiles() -> list[int]:
    return []


@pytest.fixture(scope="module")
def tuned(campaign: Path, tmp_path_factory: pytest.TempPathFactory, compiles: list[int]) -> tuple[Path, Searched]:
    """The undisturbed tuning; counts the programs that are compiled before it is confirmed."""
    with pytest.MonkeyPatch.context() as monkeypatch:

        class Counted(engine.Function):
            def __init__(self, *arguments: Any) -> None:
                compiles.append(1)
                super().__init__(*arguments)

        def told(line: str) -> None:
            if line.startswith("confirming"):
                compiles.append(-len(compiles))

        monkeypatch.setattr(engine, "Function", Counted)
        fresh = OrderedDict[Any, choice.Choice]()
        monkeypatch.setattr(choice, "_choices", fresh)
        made = tuning.tune(campaign, tmp_path_factory.mktemp("tuned") / "out", on_message=told)
    choice._choices.update(fresh)  # the other tests fly the same programs
    return made


def test_a_sweep_is_compiled_once(tuned: tuple[Path, Searched], compiles: list[int]) -> None:
    """Kills: a program for each candidate, for each round or each number of samples."""
    _, found = tuned
    assert found.cost.programs == 1
    assert compiles[:4] == [1, 1, 1, -3]  # begin, advance, finish
    assert len(found.rows) == 19


def test_a_candidate_flies_as_its_campaign_does(tuned: tuple[Path, Searched], campaign: Path) -> None:
    """Bit for bit, whatever lanes it flew in. Kills: draws that differ between candidates, values that are not those that are
    written, lanes that are mixed up, a score of other samples."""
    place, found = tuned
    folder = RunFolder.open(place)
    flights = folder.samples().frame
    seed = found.seed
    assert seed == 6
    for one in (found.row[found.best], found.rows[0], found.rows[-1]):
        sets = [f"{name}={value}" for name, value in one.values.items() if "." in name]
        problem = load(campaign, [*sets, f"seed={seed}"])
        _, drawn = Draws.of(problem, np.arange(LANES))
        alone = Flyer.of(problem).fly(drawn, problem.spec.horizon.steps, problem.spec.horizon.steps)
        own = flights[flights["search.candidate"] == one.candidate].drop_duplicates("search.sample")
        assert {*range(one.samples)} <= {*own["search.sample"]}
        expected = alone.values["settling_time_s"][own["search.sample"].to_numpy()]
        np.testing.assert_array_equal(own["metric.settling_time_s"].to_numpy(), expected)
        first = np.sort(alone.values["settling_time_s"][: one.samples])
        assert one.objectives == [first[int(np.ceil(0.8 * one.samples - 1e-9)) - 1]]


def test_the_winner_is_the_best_of_those_that_flew_everything(tuned: tuple[Path, Searched]) -> None:
    """Kills: a winner that left a race, one that misses a requirement while another does not, the last for the best."""
    _, found = tuned
    whole = [row for row in found.rows if not row.left]
    assert all(row.samples == 64 for row in whole)
    assert found.best == min(whole, key=lambda row: (row.violation, row.score, row.candidate)).candidate
    assert found.best != 0
    left = [row for row in found.rows if row.left]
    assert {row.left for row in left} <= {"test", "halving", "budget"}
    assert sum(found.cost.by_test) + sum(found.cost.by_halving) == len(left)
    assert found.cost.begun[0] == 18
    assert found.cost.flights < 0.7 * found.cost.full


def test_the_best_campaign_is_confirmed_on_draws_that_the_search_has_not_seen(
    tuned: tuple[Path, Searched], campaign: Path
) -> None:
    """Kills: a confirmation on the draws of the search, on other draws for either side, of other values than those written."""
    place, found = tuned
    best = load(place / "best.yaml")
    assert best.spec.tune is None
    assert best.spec.seed == 5
    assert best.spec.name == "short-tuning-tuned"
    for name, value in found.row[found.best].values.items():
        if "." in name:
            assert value_at(read(place / "best.yaml").value, name) == (True, value)
    new, old = (RunFolder.open(place / name) for name in ("tuned", "own"))
    assert new.identity["campaign"] == best.fingerprint
    assert old.identity["campaign"] == load(campaign).fingerprint
    a, b = new.samples().frame, old.samples().frame
    assert len(a) == len(b) == 208
    np.testing.assert_array_equal(a["draw.pursuer.mass_kg"], b["draw.pursuer.mass_kg"])
    search = load(campaign, ["seed=6"])
    assert not np.isin(Draws.of(search, np.arange(64))[0].values["pursuer.mass_kg"], a["draw.pursuer.mass_kg"]).any()
    confirmation = found.confirmation
    assert confirmation is not None
    (one,) = confirmation.objectives
    rank = int(np.ceil(0.8 * 208 - 1e-9)) - 1
    assert (one.tuned, one.own) == tuple(np.sort(frame["metric.settling_time_s"])[rank] for frame in (a, b))
    assert one.searched == found.row[found.best].objectives[0]
    assert one.optimism == pytest.approx(one.tuned - one.searched)
    assert one.verdict == "better"
    assert one.difference.high < 0.0
    (kept,) = confirmation.requirements
    captured = [frame["outcome"].to_numpy() == "captured" for frame in (a, b)]
    assert kept.only_tuned == int(np.sum(captured[0] & ~captured[1]))
    assert kept.only_own == int(np.sum(captured[1] & ~captured[0]))


@pytest.mark.parametrize("after", [3, 0, 7])
def test_one_that_is_stopped_and_begun_again_ends_alike(
    tuned: tuple[Path, Searched], campaign: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, after: int, full: bool
) -> None:
    """Kills: a search that goes another way after a stop, chunks that fly again, a state of the method that is lost."""
    if after != 3 and not full:
        pytest.skip("one stop is enough by default: --long")
    place, _ = tuned
    taken: list[int] = []
    take = RunFolder.take

    def stopping(self: RunFolder, file: Any) -> None:
        if len(taken) == after:
            raise KeyboardInterrupt
        taken.append(file.entry.number)
        take(self, file)

    monkeypatch.setattr(RunFolder, "take", stopping)
    with pytest.raises(KeyboardInterrupt):
        tuning.tune(campaign, tmp_path / "out")
    assert not (tmp_path / "out" / "search.json").exists()

    flown: list[int] = []

    def noting(self: RunFolder, file: Any) -> None:
        if self.path == tmp_path / "out":
            flown.append(file.entry.number)
        take(self, file)

    monkeypatch.setattr(RunFolder, "take", noting)
    for name in (tuning_record.TUNED, tuning_record.ORIGINAL):  # what stops and goes on is tested with the runs
        shutil.copytree(place / name, tmp_path / "out" / name)
    again, _ = tuning.tune(campaign, tmp_path / "out")
    assert sorted(taken + flown) == list(range(len(taken) + len(flown)))
    for name in KEPT:
        assert (again / name).read_bytes() == (place / name).read_bytes(), name


def test_a_finished_one_flies_nothing_again(
    tuned: tuple[Path, Searched], campaign: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Kills: a second search in the same folder."""
    place, found = tuned
    before = {name: (place / name).read_bytes() for name in KEPT}
    monkeypatch.setattr(Flyer, "fly", None)
    monkeypatch.setattr("rvjax.execution.run._keep_traces", lambda *given: None)
    assert tuning.tune(campaign, place)[1] == found
    assert {name: (place / name).read_bytes() for name in KEPT} == before


def test_the_seed_decides(tuned: tuple[Path, Searched], campaign: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: a search that has no seed; another search in a folder that has one."""
    place, found = tuned
    monkeypatch.setattr(tuning, "_confirmed", lambda *given: given[4])
    monkeypatch.setattr("rvjax.report.tuning_report.write", lambda *given: None)
    with pytest.raises(FolderError, match="belongs to another run"):
        tuning.tune(campaign, place, ["tune.seed=77"])
    folder, other = tuning.tune(campaign, tmp_path / "out", ["tune.seed=77", "tune.budget.candidates=6"])
    assert other.seed == 77
    assert [row.values for row in other.rows[1:]] != [row.values for row in found.rows[1:7]]
    assert folder != place
    assert tuning_record.read(place) == found


def test_the_report_is_made_again_from_the_folder(tuned: tuple[Path, Searched], rvjax: Run, tmp_path: Path) -> None:
    """Kills: a report that needs the search; one that is drawn of what was changed."""
    place, _ = tuned
    copy = tmp_path / "copy"
    shutil.copytree(place, copy)
    page = (copy / "report.html").read_bytes()
    for name in ("report.html", "report.md"):
        (copy / name).unlink()
    code, _, said = rvjax("report", copy)
    assert code == 0, said
    assert (copy / "report.html").read_bytes() == page
    text = (copy / "search.json").read_text()
    (copy / "search.json").write_text(text.replace('"best": ', '"best": 1'))
    code, _, said = rvjax("report", copy)
    assert code == 5
    assert "search.json" in said


def test_the_program_tells_what_was_found(tuned: tuple[Path, Searched], campaign: Path, rvjax: Run) -> None:
    """Kills: a document beside the texts; an exit code of a verdict."""
    place, found = tuned
    code, told, said = rvjax("tune", campaign, "--out", place, "--json")
    document = json.loads(told)
    assert (code, document["best"], document["folder"]) == (0, found.best, str(place))
    code, told, said = rvjax("tune", campaign, "--out", place)
    assert code == 0
    assert told.startswith(
        f"BETTER: Candidate {found.best} on fresh draws passes captured: at least 0.5 (the original campaign fails). "
    )
    assert f"best campaign: {place / 'best.yaml'}" in told
    assert "18 of 18 candidates" in said
    bad = campaign.parent / "bad.yaml"
    bad.write_text(campaign.read_text().replace("{log: [0.02, 0.5]}", "{log: [0, 0.5]}"))
    code, _, said = rvjax("tune", bad)
    assert code == 2
    assert "bad.yaml:17:35: tune.parameters.controller.gains.k_rho.log: the range 0 to 0.5 is not above 0" in said


def test_nothing_is_judged_on_the_flights_of_a_search(tuned: tuple[Path, Searched], rvjax: Run) -> None:
    """Kills: a verdict on the flights of many candidates; a replay of a flight by its number in the search."""
    place, _ = tuned
    for arguments in (("check", place), ("replay", place, "--sample", 3), ("compare", place, place / "own")):
        code, _, said = rvjax(*arguments)
        assert code == 2, arguments
        assert f"{place}: the folder of a search" in said
        assert f"accepted: {place / 'tuned'}, {place / 'own'}" in said


METHODS = {
    "gradient": ("method: {use: cma-es, population: 6}", "method: {use: gradient, starts: 2}"),
    "tpe": ("method: {use: cma-es, population: 6}", "method: {use: tpe, batch: 6}"),
    "nsga": (
        "  objective: {metric: settling_time_s, quantile: 0.8}\n  method: {use: cma-es, population: 6}",
        "  objective: [{metric: settling_time_s, quantile: 0.8}, {metric: delta_v_m_s, mean: true}]\n"
        "  goal: pareto\n  method: {use: nsga, population: 6}",
    ),
    "grid": ("method: {use: cma-es, population: 6}", "method: {use: grid, levels: 2}"),
    "sobol": ("method: {use: cma-es, population: 6}", "method: {use: sobol}"),
    "random": ("budget: {candidates: 18}", "method: {use: random, batch: 9}\n  budget: {flights: 500, candidates: 18}"),
}


@pytest.mark.parametrize("name", METHODS)
def test_every_method_flies_the_closed_loop(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, full: bool) -> None:
    """What is found is no worse than the campaign as it is, within the budget. Kills: a method that is told nothing, that has the
    wrong sign, that flies beyond its budget; a front with a point that another one beats in both."""
    if name not in ("tpe", "nsga") and not full:
        pytest.skip("by default two that need what they are told: --long")
    monkeypatch.setattr(tuning, "_confirmed", lambda *given: given[4])
    monkeypatch.setattr("rvjax.report.tuning_report.write", lambda *given: None)
    changes = [METHODS[name]]
    if name == "random":
        changes.insert(0, ("  method: {use: cma-es, population: 6}\n", ""))
    _, found = tuning.tune(write(tmp_path, *changes), tmp_path / "out")
    assert found.cost.programs == 1
    assert len(found.rows) <= 19
    whole = [row for row in found.rows if not row.left]
    if name == "nsga":
        front = [found.row[one].score for one in found.front]
        beaten = [(a, b) for a in front for b in front if a != b and all(x <= y for x, y in zip(a, b, strict=True))]
        assert front
        assert not beaten
        assert found.best in found.front
        return
    best, own = found.row[found.best], found.rows[0]
    assert (best.violation, best.score) < (own.violation, own.score)
    assert best == min(whole, key=lambda row: (row.violation, row.score, row.candidate))
    if name == "random":
        assert found.cost.flights <= 500


def test_one_that_is_killed_ends_alike(tuned: tuple[Path, Searched], campaign: Path, tmp_path: Path, full: bool) -> None:
    """The program itself, by SIGKILL in the middle of its search. Kills: a state that only a clean end writes."""
    if not full:
        pytest.skip("the stop in this process is enough by default: --long")
    place, _ = tuned
    command = [sys.executable, "-m", "rvjax", "tune", str(campaign), "--out", str(tmp_path / "out"), "--quiet"]
    process = subprocess.Popen(command)
    while not len(list((tmp_path / "out" / "samples").glob("*.parquet"))) >= 3:
        assert process.poll() is None
        time.sleep(0.01)
    process.kill()
    process.wait()
    subprocess.run(command, check=True)
    for name in KEPT:
        assert (tmp_path / "out" / name).read_bytes() == (place / name).read_bytes(), name


def test_a_search_of_few_values_ends(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Four combinations for a method that never ends by itself. Kills: a search that proposes what is known for ever."""
    monkeypatch.setattr(tuning, "_confirmed", lambda *given: given[4])
    monkeypatch.setattr("rvjax.report.tuning_report.write", lambda *given: None)
    text = "    controller.gains.k_rho: {choice: [0.05, 0.2]}\n    controller.gains.k_nu: {choice: [0.5, 1]}\n"
    begin, _, rest = write(tmp_path).read_text().partition("  parameters:\n")
    path = tmp_path / "few.yaml"
    path.write_text(f"{begin}  parameters:\n{text}{rest[rest.index('  objective') :]}")
    _, found = tuning.tune(path, tmp_path / "out")
    assert {tuple(row.values.values()) for row in found.rows[1:]} == {(a, b) for a in (0.05, 0.2) for b in (0.5, 1)}


def test_flights_of_other_values_are_never_taken(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A folder whose search would now propose something else, as after another version of a package. Kills: flights that count
    for a candidate with other gains."""
    monkeypatch.setattr(tuning, "_confirmed", lambda *given: given[4])
    monkeypatch.setattr("rvjax.report.tuning_report.write", lambda *given: None)
    path = write(tmp_path, METHODS["sobol"])
    tuning.tune(path, tmp_path / "out")
    made = sobol.COMPONENT.build

    def shifted(parameters: Any) -> Any:
        search = made(parameters)
        return lambda task, evaluate: search(task, lambda points: evaluate(np.clip(points + 0.01, 0.0, 1.0)))

    monkeypatch.setattr(sobol, "COMPONENT", replace(sobol.COMPONENT, build=shifted))
    with pytest.raises(FolderError, match="chunk 1 is of other candidates than this search asks for"):
        tuning.tune(path, tmp_path / "out")
