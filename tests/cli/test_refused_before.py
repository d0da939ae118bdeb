"""What a command refuses without a flight: `validate` says it too, with the place, and no folder stays."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rvjax.components import extras
from rvjax.components.search_methods.grid import _most_levels  # pyright: ignore[reportPrivateUsage]
from rvjax.components.search_methods.interface import Axis
from rvjax.errors import CampaignError, IncompleteError, RvjaxError, UsageError
from rvjax.execution.audit import Audit
from rvjax.run_folder.refusals import leaves_no_folder
from tests.program import Run
from tests.short import CAMPAIGN, SHORT
from tests.tuning.short import write

METHOD = "{use: cma-es, population: 6}"
CAMPAIGN_OF_TWO = """\
rvjax: 1
name: two
samples: 40
horizon: {duration_s: 10, step_s: 0.1}
target: {port_m: [5, 0, 0]}
pursuer: {mass_kg: {uniform: [90, 110]}, inertia_kgm2: {moments: 20}}
start: {rho_m: {box: 1}}
capture: {window_s: 5}
actuators: {upper: 4, lower: 3}
controller: {use: pd-plus, gains: {k_rho: {uniform: [0.04, 0.06]}}}
baselines: [{use: sliding-mode, name: other}]
"""


@pytest.fixture(autouse=True)
def grounded(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing flies."""

    def flies(*given: object, **more: object) -> None:
        raise AssertionError("a flight")

    monkeypatch.setattr("rvjax.simulation.batch.Flyer.fly", flies)
    monkeypatch.setattr("rvjax.simulation.batch.Flyer.watch", flies)


def refused_alike(rvjax: Run, command: str, path: Path, out: Path, *more: object) -> str:
    """What both `validate` and the command say; checks that no folder stays."""
    code, _, first = rvjax("validate", path, *more)
    assert code == 2, first
    code, _, second = rvjax(command, path, "--out", out, *more)
    assert code == 2, second
    assert first == second.partition("flying")[0]
    assert not out.exists()
    assert re.match(rf"{re.escape(str(path))}:\d+:\d+: ", first), first
    return first


def test_a_grid_that_is_larger_than_its_budget(tmp_path: Path, rvjax: Run) -> None:
    """Each of the two proposals is accepted. Kills: a search that is refused after its folder is made; a refusal without a place;
    a number of levels that is still too large, or smaller than it must be."""
    path = write(tmp_path, (METHOD, "{use: grid, levels: 50}"))
    said = refused_alike(rvjax, "tune", path, tmp_path / "out" / "search")
    assert not (tmp_path / "out").exists()
    assert ":22:31: tune.method.levels: a grid of 125,000 candidates (50 · 50 · 50); accepted: at most 18; use " in said
    proposed = re.search(r"use levels: (\d+) or a budget of (\d+) candidates", said)
    assert proposed
    levels, budget = map(int, proposed.groups())
    for change in (f"tune.method.levels={levels}", f"tune.budget.candidates={budget}"):
        assert rvjax("validate", path, "--set", change)[0] == 0, change
    assert rvjax("validate", path, "--set", f"tune.method.levels={levels + 1}")[0] == 2
    assert rvjax("validate", path, "--set", f"tune.budget.candidates={budget - 1}")[0] == 2


@given(smooth=st.integers(0, 6), levels=st.lists(st.integers(1, 9), max_size=3), most=st.integers(1, 10**6))
def test_the_most_levels_of_a_grid(smooth: int, levels: list[int], most: int) -> None:
    """Against counting up. Kills: a root that is rounded up, axes with levels that are left out."""
    axes = [Axis()] * smooth + [Axis(n) for n in levels]
    found = _most_levels(axes, most)
    fixed = math.prod(levels)
    assert (found == 0) == (smooth == 0 or fixed > most)
    assert not found or found**smooth * fixed <= most < (found + 1) ** smooth * fixed


@pytest.mark.parametrize("name", ["tpe", "nsga"])
def test_a_method_without_its_package(name: str, tmp_path: Path, rvjax: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: a package that is missed once the folder is made; a traceback."""
    monkeypatch.setattr(extras, "find_spec", lambda package: None)
    said = refused_alike(rvjax, "tune", write(tmp_path, (METHOD, f"{{use: {name}}}")), tmp_path / "out")
    assert (
        f":22:17: tune.method.use: the method {name} needs optuna>=5.0 (not installed); accepted: pip install 'rvjax[tune]'"
        in said
    )


@pytest.mark.parametrize(
    ("section", "place"),
    [
        ("correlate: [{variables: [controller.gains.k_rho, pursuer.mass_kg], rank: [[1, 0.5], [0.5, 1]]}]", "12:26"),
        ("require: [{metric: captured, at_least: 0.5, where: {controller.gains.k_rho: {below: 0.05}}}]", "12:53"),
        ("epistemic: [controller.gains]", "12:13"),
    ],
    ids=["correlated", "class", "epistemic"],
)
def test_a_campaign_that_does_not_fit_its_baseline(section: str, place: str, tmp_path: Path, rvjax: Run) -> None:
    """The baseline has no such draw. Kills: a refusal once the campaign itself has flown."""
    path = tmp_path / "two.yaml"
    path.write_text(CAMPAIGN_OF_TWO + section + "\n")
    assert rvjax("validate", path, "--set", "baselines=[]")[0] == 0
    said = refused_alike(rvjax, "run", path, tmp_path / "out")
    assert said.startswith(f"{path}:{place}: ")
    assert re.search(r"with the baseline other: .*controller\.gains", said)


def test_a_draw_of_a_baseline_that_does_nothing(tmp_path: Path, rvjax: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: an audit of a baseline after the flights of the campaign; `validate --audit` of the controller alone."""
    path = tmp_path / "two.yaml"
    path.write_text(
        CAMPAIGN_OF_TWO.replace("name: other}", "name: other, gains: {k_rho: {uniform: [0.04, 0.05]}}}").replace(
            "sliding-mode", "pd-plus"
        )
    )

    def audit(problem: Any, flyer: object) -> Audit:
        return Audit(1, 1, (), {"controller.gains.k_rho": 9} if problem.spec.controller.name == "other" else {}, {})

    monkeypatch.setattr("rvjax.execution.audit.audit", audit)
    for arguments in (("run", path, "--out", tmp_path / "out"), ("validate", "--audit", path)):
        code, _, said = rvjax(*arguments)
        assert code == 2, said
        assert "controller.gains.k_rho does nothing" in said
        assert not (tmp_path / "out").exists()


def test_a_draw_that_does_nothing_ends_a_tuning_before_its_search(
    tmp_path: Path, rvjax: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Kills: an audit in the confirmation alone, after every flight of the search; a folder that stays."""
    monkeypatch.setattr("rvjax.execution.audit.audit", lambda *given: Audit(1, 1, (), {"pursuer.mass_kg": 9}, {}))
    code, _, said = rvjax("tune", write(tmp_path), "--out", tmp_path / "out")
    assert code == 2
    assert ":7:20: pursuer.mass_kg: pursuer.mass_kg does nothing" in said
    assert not (tmp_path / "out").exists()


def test_a_run_that_its_audit_refuses_leaves_no_folder(tmp_path: Path, rvjax: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: a folder without a flight; an empty folder of the user that is removed as well."""
    monkeypatch.setattr("rvjax.execution.audit.audit", lambda *given: Audit(1, 1, (), {"pursuer.mass_kg": 9}, {}))
    sets = [word for value in SHORT for word in ("--set", value)]
    mine = tmp_path / "mine"
    mine.mkdir()
    for out in (tmp_path / "a" / "b", mine):
        assert rvjax("run", CAMPAIGN, "--out", out, *sets)[0] == 2
    assert list(tmp_path.rglob("*")) == [mine]


@pytest.mark.parametrize(
    ("error", "stays"), [(UsageError("no"), False), (CampaignError([]), False), (IncompleteError("no"), True)]
)
def test_what_stays_of_a_folder(error: RvjaxError, stays: bool, tmp_path: Path) -> None:
    """Kills: a folder with flights that is removed, one that can be resumed that is removed, folders above that stay empty."""

    def made(place: Path, *names: str) -> None:
        with leaves_no_folder(place):
            for name in names:
                (place / name).parent.mkdir(parents=True, exist_ok=True)
                (place / name).write_text("x")
            raise error

    def fails(place: Path, *names: str) -> None:
        with pytest.raises(type(error)):
            made(place, *names)

    fails(tmp_path / "a" / "b", "manifest.json", "inputs/x.csv")
    assert (tmp_path / "a").exists() == stays
    fails(tmp_path / "c", "manifest.json", "samples/00000-abc.parquet")
    assert (tmp_path / "c" / "samples" / "00000-abc.parquet").exists()
    (tmp_path / "d").mkdir()
    (tmp_path / "d" / "notes.txt").write_text("mine")
    fails(tmp_path / "d", "manifest.json")
    assert (tmp_path / "d" / "notes.txt").exists()


@pytest.mark.parametrize(
    "arguments",
    [
        lambda campaign, path: ("worst", campaign, "--out", path),
        lambda campaign, path: ("run", campaign, "--junit-xml", path),
        lambda campaign, path: ("check", campaign, "--junit-xml", path),
        lambda campaign, path: ("check", campaign, "--write-baseline", path),
        lambda campaign, path: ("replay", path.parents[1], "--sample", 0, "--out", path),
    ],
    ids=["worst", "run", "check", "baseline", "replay"],
)
def test_a_file_that_cannot_be_written(
    arguments: Callable[[Path, Path], tuple[object, ...]], tmp_path: Path, rvjax: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Kills: hours of flights whose result has no place."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("")
    target = tmp_path / "file" / "x.csv"
    code, _, said = rvjax(*arguments(write(tmp_path), target))
    assert code == 2, said
    assert "cannot be written" in said
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "tuning.yaml"]


@pytest.mark.parametrize(
    ("change", "words"),
    [({"samples": 40}, "it has 40 samples, the run has 416"), ({"requirements": {"1. x": "1"}}, "its requirements differ")],
)
def test_a_baseline_of_another_campaign(
    change: dict[str, Any], words: str, tmp_path: Path, rvjax: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Kills: a difference that shows in the campaign and that is told after its flights."""
    monkeypatch.chdir(tmp_path)
    document = {"format": 1, "campaign": "x", "samples": 416, "draws": {}, "requirements": {}, "metrics": {}} | change
    if "requirements" in change:
        document["requirements"] = {"1. x": "1" * 416}
    (tmp_path / "b.json").write_text(json.dumps(document))
    code, _, said = rvjax("check", write(tmp_path), "--against", "b.json")
    assert code == 2
    assert f"b.json: {words}" in said
    assert not (tmp_path / "reports").exists()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ((), ":13:1: require: there is no requirement 2; accepted: 1 to 1"),
        (
            ("require=[{metric: captured, at_least: 0.5}, {metric: delta_v_m_s, mean: true, below: 9}]",),
            "require.1: requirement 2 is on a mean, which no single flight meets; accepted: --requirement 1",
        ),
    ],
    ids=["none", "mean"],
)
def test_a_requirement_without_a_worst_case(change: tuple[str, ...], words: str, tmp_path: Path, rvjax: Run) -> None:
    """Kills: a refusal without a place."""
    sets = [word for value in change for word in ("--set", value)]
    code, _, said = rvjax("worst", write(tmp_path), "--requirement", 2, *sets)
    assert code == 2
    assert words in said


def test_two_domains_of_a_worst_case(tmp_path: Path, rvjax: Run) -> None:
    """Kills: a refusal after the campaign is loaded and compiled."""
    code, _, said = rvjax("worst", write(tmp_path), "--radius", 1, "--box", 1)
    assert (code, said) == (2, "--radius and --box together; accepted: --radius or --box\n")
