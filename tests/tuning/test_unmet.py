"""A search in which no candidate meets the requirements, and objectives without a finite value."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from rvjax.analysis.compare import compare
from rvjax.cli.tune import _exit_code
from rvjax.components.settings import setting
from rvjax.run_folder import RunFolder, tuning_record
from rvjax.run_folder.tuning_record import Kept, Missed, Searched
from rvjax.search.tuning.evaluation import Search
from rvjax.search.tuning.race import Standing
from rvjax.simulation.problem import load
from rvjax.stats.pareto import Score
from tests.program import Run
from tests.tuning.short import write

NOBODY = (
    ("position_m: 0.5", "position_m: 0.005"),
    (
        "{metric: captured, at_least: 0.5}",
        "{metric: captured, at_least: 0.5}\n  - {metric: delta_v_m_s, mean: true, below: 0.001}",
    ),
    ("candidates: 18", "candidates: 4"),
    ("samples: 64\n  race: {first: 16, hard: 4}\n  confirm: {samples: 208}", "samples: 32\n  confirm: {samples: 24}"),
)
"""No sample comes that near, so that no settling time is finite, and nobody flies with so little Δv."""


@pytest.fixture(scope="module")
def unmet(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """The campaign and the folder of its search."""
    place = tmp_path_factory.mktemp("unmet")
    return write(place, *NOBODY), place / "out"


def test_nobody_meets_the_requirements(unmet: tuple[Path, Path], rvjax: Run, bare: None) -> None:
    """Kills: exit code 0, a best campaign with the values of a candidate that meets nothing, a word as if it were good, a
    requirement that is not named, "+nan", an optimism of 0 between two infinities, a warning of the plotting library."""
    campaign, place = unmet
    code, out, err = rvjax("tune", campaign, "--out", place)
    assert code == 1, err
    words = " ".join(out.split())
    assert words.startswith("NOT MET: No candidate meets the requirements, so the original campaign is kept. ")
    assert "comes closest: captured: at least 0.5, met in 0 %, 50 points short" in words
    assert "nan" not in words
    assert "No artists" not in err
    found = tuning_record.read(place)
    assert found is not None
    table = RunFolder.open(place).samples().frame
    mean = table[table["search.candidate"] == found.closest].drop_duplicates("search.sample")["metric.delta_v_m_s"].mean()
    share, effort = found.missed
    assert (share.observed, share.limit, share.share) == (0.0, 0.5, True)
    assert (effort.observed, effort.limit, effort.unit) == (pytest.approx(mean), 0.001, "m/s")
    assert f"beyond the bound by {1000 * (mean - 0.001):.3g} mm/s" in words
    best, original = load(place / "best.yaml"), load(campaign)
    assert found.best == 0
    for name in ("controller.gains.k_rho", "controller.gains.k_nu", "controller.gains.k_sigma"):
        assert setting(best.spec, name) == setting(original.spec, name)
    assert "no candidate of the search meets the requirements" in (place / "best.yaml").read_text()
    report = (place / "report.md").read_text()
    assert report.count("No candidate meets the requirements") >= 2
    assert "nan" not in report
    code, out, _ = rvjax("tune", campaign, "--out", place, "--json")
    document = json.loads(out, parse_constant=pytest.fail)
    assert (code, document["exit_code"], document["best"], len(document["missed"])) == (1, 1, 0, 2)


def record(unmet: tuple[Path, Path], rvjax: Run, *verdicts: str, **more: Any) -> Searched:
    """The record of that search as if something else had come out."""
    campaign, place = unmet
    if not (place / "search.json").exists():
        rvjax("tune", campaign, "--out", place)
    found = tuning_record.read(place)
    assert found is not None
    assert found.confirmation is not None
    kept = [Kept(text=word, tuned=word, own="PASS", only_tuned=None, only_own=None, p_worse=None) for word in verdicts]
    objectives = [one.model_copy(update={"verdict": more.get("word", "better")}) for one in found.confirmation.objectives]
    confirmation = found.confirmation.model_copy(update={"requirements": kept, "objectives": objectives})
    missed = [Missed(text="x", observed=0.4, limit=0.5, share=True, unit="")] if more.get("missed") else []
    return found.model_copy(update={"confirmation": confirmation, "missed": missed, "best": more.get("best", 1)})


@pytest.mark.parametrize(
    ("verdicts", "more", "code"),
    [
        (("PASS", "PASS"), {}, 0),
        ((), {}, 0),
        (("PASS", "UNDECIDED"), {"best": 0}, 3),
        (("UNDECIDED", "FAIL"), {}, 1),
        (("PASS",), {"missed": True}, 1),
        (("PASS",), {"word": "worse"}, 1),
        (("PASS",), {"word": "not told apart"}, 0),
    ],
)
def test_the_exit_code_is_that_of_the_winner(
    unmet: tuple[Path, Path], rvjax: Run, verdicts: tuple[str, ...], more: dict[str, Any], code: int
) -> None:
    """Kills: 0 for a winner that fails on fresh draws or is worse than the original; UNDECIDED before FAIL."""
    assert _exit_code(record(unmet, rvjax, *verdicts, **more)) == code


def test_the_winner_meets_what_is_required_not_what_is_asked_for() -> None:
    """Candidate 2 violates more of what the order asks for, but it alone meets the requirements. Kills: "no candidate meets them"
    where another than the first in order does; an original campaign that is kept against a candidate that is in order; the first
    that flew of two that meet the requirements."""
    missed = {0: ["a"], 1: ["a"], 2: []}
    standings = {number: Standing(number, 0, 8, Score(violation, (1.0,))) for number, violation in ((0, 0.3), (1, 0.1), (2, 0.2))}
    flights = SimpleNamespace(table=lambda number, samples: number)
    judge = SimpleNamespace(goal="first", missed=lambda number: missed[number])
    tuning = SimpleNamespace(rounds=(8,))
    search = Search(cast("Any", tuning), cast("Any", flights), cast("Any", judge), print, standings=standings, best=1)
    assert search.winner() == 2
    missed[0] = []
    assert search.winner() == 2
    missed[1] = []
    assert search.winner() == 1
    missed |= {0: ["a"], 1: ["a"], 2: ["b"]}
    assert search.winner() is None


def test_compare_knows_the_defaults(tmp_path: Path, rvjax: Run, bare: None) -> None:
    """Side B writes a default and changes another key. Kills: "A has nothing" for a default; a line for the same value."""
    short = ("samples=8", "keep={worst: 0}", "horizon.duration_s=2", "tune=null", "require=[]", "capture.window_s=1", "faults=[]")
    given = {
        "a": (),
        "b": ("controller.gains.k_nu=0.2", "controller.gains.k_omega={default}", "target.orbit={semi_major_axis_km: 7000}"),
    }
    path = write(tmp_path)
    spec = load(path).spec
    default = setting(spec, "controller.gains.k_omega")
    assert isinstance(default, float)
    for name, more in given.items():
        sets = [part for one in (*short, *more) for part in ("--set", one.replace("{default}", repr(default)))]
        code, _, err = rvjax("run", path, "--out", tmp_path / name, "--quiet", *sets)
        assert code == 0, err
    lines = compare(tmp_path / "a", tmp_path / "b").differing
    assert f"controller.gains.k_nu: A has the default {setting(spec, 'controller.gains.k_nu')}, B has 0.2" in lines
    assert any(line.startswith("target.orbit.semi_major_axis_km: A has the default 6878") for line in lines)
    assert not [line for line in lines if "k_omega" in line]
    assert not [line for line in lines if "nothing" in line]
