"""Searches: what every one of them promises to whoever tells it."""

from __future__ import annotations

import subprocess
import sys
import warnings
from dataclasses import replace

import numpy as np
import pytest

from rvjax.components import extras, manual
from rvjax.components.registry import component, members
from rvjax.components.search_methods.interface import Axis, Spent, Task, Values, snapped
from tests.program import Run
from tests.tuning.problems import (
    MIXED,
    Answers,
    Outcome,
    cube,
    searched,
    sphere,
)

ALL = tuple(members("searches"))
SEEDED = tuple(name for name in ALL if name != "grid")
FIRST_IS_START = tuple(name for name in SEEDED if name != "cma-es")
AXES = (*MIXED, Axis(levels=1), Axis(levels=2))
SAID: dict[str, dict[str, object]] = {
    "grid": {"levels": 3, "batch": 7},
    "random": {"batch": 8},
    "sobol": {"batch": 8},
    "cma-es": {"population": 8},
    "tpe": {"batch": 6},
    "nsga": {"population": 8},
    "gradient": {"starts": 5},
}
"""Parameters with which each search proposes several batches."""


def waves(x: Values) -> Outcome:
    """A function of two objectives and of no interest; each axis matters."""
    k = np.arange(1, x.shape[1] + 1)
    value = np.sin(3.0 * k * x).sum(axis=1)
    return Outcome(np.stack([value, -value], axis=1), None, 3.0 * k * np.cos(3.0 * k * x))


@pytest.mark.parametrize("axes", [(Axis(),), (Axis(levels=4),), (Axis(levels=3, ordered=False),), (Axis(levels=1),), AXES])
@pytest.mark.parametrize("name", ALL)
def test_points_are_in_the_cube_and_on_levels(name: str, axes: tuple[Axis, ...]) -> None:
    """Kills: a point between levels or outside, an axis too few, one axis that breaks a method."""
    for start in (None, np.array([(0.5 / axis.levels) if axis.levels else 0.9 for axis in axes])):
        answers = searched(name, waves, Task(axes, 2, start, objectives=2), batches=5, **SAID[name])
        assert answers.proposed
        for points in answers.proposed:
            assert points.ndim == 2
            assert points.shape[1] == len(axes)
            assert points.dtype == np.float64
            assert np.array_equal(points, snapped(axes, points))


@pytest.mark.parametrize("name", ALL)
def test_the_same_seed_goes_the_same_way(name: str) -> None:
    """And another one another way, but for the grid, with what other code draws in between. Kills: NumPy's global stream, a seed
    that is not used."""
    runs: list[Values] = []
    for seed in (7, 7, 8):
        np.random.random(seed)
        task = Task(AXES, seed, objectives=2)
        runs.append(searched(name, waves, task, batches=6, **SAID[name]).all)
    assert np.array_equal(runs[0], runs[1])
    assert np.array_equal(runs[0], runs[2]) == (name == "grid")


@pytest.mark.parametrize("name", ALL)
def test_a_search_that_is_stopped_went_the_same_way_until_then(name: str) -> None:
    """`Spent` comes out as it is, at the first batch and later. Kills: a search that swallows it, that asks again after it, or
    that plans by the end of its budget."""
    task, method = Task(AXES, 3, objectives=2), component("searches", name)
    whole = searched(name, waves, task, batches=5, **SAID[name]).proposed
    for k in range(4):
        answers = Answers(waves, batches=k)
        with pytest.raises(Spent):
            method.build(method.parameters.model_validate(SAID[name]))(task, answers)
        assert len(answers.proposed) == k
        assert all(np.array_equal(*pair) for pair in zip(answers.proposed, whole[:k], strict=True))


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("value", [0.0, np.inf])
def test_objectives_without_a_difference(name: str, value: float) -> None:
    """All equal, or none that can be said. Kills: ∞ − ∞, a sum of weights of 0, a search that goes no further."""

    def same(x: Values) -> Outcome:
        return Outcome(np.full((len(x), 2), value), None, np.full(x.shape, value and np.nan))

    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        answers = searched(name, same, Task(AXES, 1, objectives=2), batches=12, **SAID[name])
    assert len(answers.proposed) == (1 if name == "gradient" else 12)


@pytest.mark.parametrize("name", ALL)
def test_some_objectives_that_cannot_be_said(name: str) -> None:
    """Of a third of the points: +∞, without a gradient. Kills: the worst value as a number to calculate with."""

    def holes(x: Values) -> Outcome:
        objectives, _, gradient = waves(x)
        assert gradient is not None
        lost = x[:, 0] > 0.66
        return Outcome(np.where(lost[:, None], np.inf, objectives), None, np.where(lost[:, None], np.nan, gradient))

    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        answers = searched(name, holes, Task(AXES, 1, objectives=2), batches=12, **SAID[name])
    assert np.isfinite(np.concatenate(answers.objectives)).any()


@pytest.mark.parametrize("name", FIRST_IS_START)
def test_the_start_comes_first(name: str) -> None:
    """Kills: a start that is left out, or that stands beside the points of the batch instead of among them."""
    start = snapped(AXES, np.array([[0.123, 0.4, 0.9, 0.5, 0.9]]))[0]
    sizes = [len(searched(name, waves, replace(Task(AXES, 1), start=s), batches=1, **SAID[name]).all) for s in (None, start)]
    assert sizes[0] == sizes[1]
    points = searched(name, waves, Task(AXES, 1, start), batches=1, **SAID[name]).all
    assert np.array_equal(points[0], start)
    assert not (points[1:] == start).all(axis=1).any()


@pytest.mark.parametrize("name", ["random", "sobol"])
@pytest.mark.parametrize("start", [None, np.array([0.1, 0.2])])
def test_there_are_as_many_points_as_candidates(name: str, start: Values | None) -> None:
    """All at once, or in batches of which the last is short. Kills: one more for the start, a last batch that is full."""
    task = cube(2, 1, start=start, candidates=21)
    assert [len(part) for part in searched(name, sphere, task).proposed] == [21]
    assert [len(part) for part in searched(name, sphere, task, batch=8).proposed] == [8, 8, 5]
    assert len(searched(name, sphere, cube(2, 1, start=start), batches=3).all) == 3 * 64


def test_what_methods_need() -> None:
    """Kills: gradients that nobody calculates, a front that is a point."""
    assert [name for name in ALL if component("searches", name).gradient] == ["gradient"]
    assert [name for name in ALL if component("searches", name).several] == ["nsga"]


@pytest.mark.parametrize("name", ALL)
def test_every_search_has_a_page(name: str) -> None:
    """Kills: a parameter without a meaning, a page without a source."""
    page = manual.page("searches", name)
    assert page.summary.endswith((".", ",")) or page.summary.count("=")
    assert page.rows
    assert all(row[3] for row in page.rows)
    assert any(str(year) in page.text for year in range(1935, 2030))


def test_searches_are_listed_and_explained(rvjax: Run) -> None:
    """Kills: a family that the program does not know."""
    code, out, _ = rvjax("explain", "cma-es")
    assert code == 0
    assert "sigma" in out
    code, out, _ = rvjax("list")
    assert code == 0
    assert "rvjax.components.search_methods.tpe" in out


# Optuna


@pytest.mark.parametrize("name", ["tpe", "nsga"])
def test_optuna_may_be_missing(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: an import where the search is loaded, a package that nobody misses."""
    method = component("searches", name)
    assert not list(method.problems(method.parameters(), cube(2, 0).axes, 20))
    monkeypatch.setattr(extras, "find_spec", lambda package: None)
    (problem,) = method.problems(method.parameters(), cube(2, 0).axes, 20)
    assert problem.message == f"the method {name} needs optuna>=5.0 (not installed)"
    assert problem.accepted == "accepted: pip install 'rvjax[tune]'"


@pytest.mark.parametrize("name", ["tpe", "nsga"])
def test_optuna_says_nothing_and_is_left_as_it_was(name: str, capfd: pytest.CaptureFixture[str]) -> None:
    """Kills: messages and warnings of a search, a verbosity that stays, also while points are evaluated."""
    import optuna

    before, seen = optuna.logging.get_verbosity(), set[int]()

    def watched(x: Values) -> Outcome:
        seen.add(optuna.logging.get_verbosity())
        return sphere(x)

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        searched(name, watched, cube(2, 0), batches=3, **SAID[name])
    assert seen == {before, optuna.logging.get_verbosity()} == {before}
    assert capfd.readouterr() == ("", "")


def test_optuna_is_imported_by_a_search_that_runs() -> None:
    """Kills: a program that loads it to list what there is."""
    code = (
        "import sys, rvjax.components.search_methods.tpe, rvjax.components.search_methods.nsga; sys.exit('optuna' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
