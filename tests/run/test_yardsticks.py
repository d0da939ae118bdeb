"""The benchmark compares like with like: every yardstick flies the same samples to the same end."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path
from typing import Any

import jax
import numpy as np
import pytest

from benchmarks import YARDSTICKS
from rvjax.errors import IncompleteError, UsageError
from rvjax.execution.bench import measurement, own_flight, workload
from rvjax.execution.bench.workload import Case, UnavailableError, Values, case, clone_folder, read, save, yardsticks
from rvjax.simulation.batch import LANES
from rvjax.simulation.problem import load
from tests.short import CAMPAIGN

FAST_MATH = ("simd_c",)
STATE_ONLY = ("diffrax",)
ADAPTIVE, PD_PLUS = "{use: saturated-adaptive, derivative: none}", "{use: pd-plus}"
CONTROLLERS = {"plain_vmap": PD_PLUS, "diffrax": PD_PLUS}
"""Of the yardsticks that call the functions of the product, the controller that compiles soonest. All others translate these
functions, and fly the controller with most of them."""

HURRIED = """
import runpy, sys, time
clock = time.perf_counter
time.perf_counter = lambda: 20 * clock()
sys.argv = sys.argv[1:]
runpy.run_module(sys.argv[0], run_name="__main__")
"""
"""Runs a module with a clock that goes 20 times as fast."""


@pytest.fixture(scope="module")
def smooth(tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest) -> Case:
    """Without the Levant differentiator, whose sign switches no two compilers repeat; faults at once. Half a second, with
    `--long` two and a half."""
    steps = 50 if request.config.getoption("--long") else 10
    place = tmp_path_factory.mktemp("case")
    text = CAMPAIGN.read_text().replace("{use: saturated-adaptive}", request.param)
    file = place / "smooth.yaml"
    file.write_text(text.replace("onset_s: {uniform: [30, 150]}", "onset_s: {uniform: [0.1, 0.4]}"))
    return case(file, LANES, steps, "float64", place / "start.npz")


@pytest.fixture(scope="module")
def quick(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The campaign whose programs compile soonest."""
    file = tmp_path_factory.mktemp("quick") / "quick.yaml"
    text = re.sub(r"(disturbances|faults):\n(  .*\n)+", r"\1: []\n", CAMPAIGN.read_text())
    file.write_text(text.replace("{use: saturated-adaptive}", "{use: pd-plus}"))
    assert (load(file).loop.faults, load(file).loop.disturbances) == ((), ())
    return file


@pytest.fixture(scope="module")
def ours(smooth: Case) -> Values:
    """What the product makes of it."""
    return own_flight.prepare(smooth)()


@pytest.mark.parametrize(
    ("name", "smooth"), [(name, CONTROLLERS.get(name, ADAPTIVE)) for name in YARDSTICKS], ids=YARDSTICKS, indirect=["smooth"]
)
def test_every_yardstick_flies_to_the_same_end(name: str, smooth: Case, ours: Values) -> None:
    """All metrics to 1e-9. Kills: a primitive translated wrongly, a step too many, drawn numbers in another order."""
    module = yardsticks(clone_folder())[name]
    try:
        found = smooth.values(module.prepare(smooth)())
    except UnavailableError as error:
        pytest.skip(str(error))
    assert found.keys() == ours.keys()
    for metric, values in found.items():
        if name in STATE_ONLY and not metric.startswith("final_"):
            continue
        tolerance = 1e-6 if name in FAST_MATH else 1e-9
        np.testing.assert_allclose(values, ours[metric], rtol=tolerance, atol=1e-12, err_msg=metric)


@pytest.mark.parametrize("smooth", [ADAPTIVE], indirect=True)
def test_numbers_come_back_as_they_went(smooth: Case, tmp_path: Path) -> None:
    """Kills: leaves in another order."""
    save(tmp_path / "x.npz", smooth.carry)
    again = read(tmp_path / "x.npz", smooth.carry)
    assert all(np.array_equal(a, b) for a, b in zip(jax.tree.leaves(again), jax.tree.leaves(smooth.carry), strict=True))


def test_a_lost_sample_is_far_from_everything() -> None:
    """Kills: NaN that counts as agreeing."""
    assert measurement.apart(np.array([1.0, np.nan]), np.array([1.0, 2.0])) == float("inf")
    assert measurement.apart(np.array([1.0, 2.5]), np.array([1.0, 2.0])) == 0.25


def test_a_folder_without_yardsticks_is_a_mistake(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="no yardsticks"):
        yardsticks(tmp_path)
    assert yardsticks(None) == {}


def test_ways_can_be_chosen() -> None:
    """Kills: an unknown way that is left out in silence; a table without the way that all are compared with."""
    known = ["rvjax", "rvjax_xla", "simd_c", "numpy"]
    assert measurement.chosen(["numpy", "rvjax_xla"], known) == ["rvjax", "rvjax_xla", "numpy"]
    assert measurement.chosen([], known) == known
    with pytest.raises(UsageError, match=r"--way: simd: no such way to fly; accepted: rvjax, rvjax_xla, simd_c, numpy"):
        measurement.chosen(["numpy", "simd"], known)


def test_an_installed_package_finds_them_in_a_clone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """From a folder inside the clone. Kills: looking beside the package only; taking any folder of that name."""
    monkeypatch.setattr(workload, "__file__", str(tmp_path / "site-packages/rvjax/execution/bench/workload.py"))
    clone = tmp_path / "clone"
    for name in ("pyproject.toml", "benchmarks/__init__.py", "campaigns/x.yaml"):
        (clone / name).parent.mkdir(parents=True, exist_ok=True)
        (clone / name).touch()
    monkeypatch.chdir(clone / "campaigns")
    assert clone_folder() is None
    (clone / "rvjax").mkdir()
    (clone / "rvjax/__init__.py").touch()
    assert clone_folder() == clone / "benchmarks"


def test_a_process_stands_ready_flies_and_hands_over(quick: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """The protocol, with the product on one thread; and a process that ends early is named, not waited for."""
    spec = {
        "way": "rvjax_one_device",
        "campaign": str(quick),
        "samples": LANES,
        "steps": 5,
        "precision": "float64",
        "start": str(tmp_path / "start.npz"),
        "result": str(tmp_path / "result.npz"),
        "yardsticks": str(clone_folder()),
    }
    with measurement.Worker(spec) as worker:
        assert worker.answer()["ready"] > 0.0
        assert worker.fly() > 0.0
        assert worker.end() > 100.0
    flown = case(quick, LANES, 5, "float64", tmp_path / "start.npz")
    names = {name: 0.0 for metric in flown.problem.metrics for name in metric.columns}
    found, again = read(tmp_path / "result.npz", names), own_flight.prepare(flown)()
    assert all(np.array_equal(found[name], again[name]) for name in names)
    with measurement.Worker(spec | {"way": "no-such-way"}) as broken, pytest.raises(IncompleteError, match="no-such-way"):
        broken.answer()
    assert "KeyError" in capfd.readouterr().err


def test_the_first_chunk_is_seen_and_the_run_is_ended(quick: Path, tmp_path: Path) -> None:
    """Kills: waiting for a line that no longer comes; a failure without the words of the command."""
    cold, warm = measurement.first_chunk(quick, tmp_path, LANES)
    assert cold > 0.0 < warm
    quick.with_name("broken.yaml").write_text("seed: x\n")
    with pytest.raises(IncompleteError, match=r"exit code 2 and no chunk: .*broken\.yaml"):
        measurement.first_chunk(quick.with_name("broken.yaml"), tmp_path / "broken", LANES)


def test_growth_flies_what_it_says(quick: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two chunks for 500 samples, again and again; kills a stream that drops chunks or counts pads twice. The process has a
    clock that goes faster, so that it does not fly for seconds."""

    def hurried(command: list[str], **more: Any) -> subprocess.CompletedProcess[str]:
        return run([command[0], "-c", HURRIED, *command[2:]], **more)

    run = subprocess.run
    monkeypatch.setattr(measurement.subprocess, "run", hurried)
    found = measurement.growth_of(quick, 500)
    assert found["samples"] == 500
    assert found["steps_per_s"] > 0.0
    assert found["peak_memory_mb"] > 50.0
