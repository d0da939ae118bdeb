"""The measurement: prepared processes that fly in turn, the ratios of their times, and whether their results agree."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from statistics import median
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from rvjax.cores import cores
from rvjax.errors import IncompleteError, UsageError
from rvjax.execution.bench.workload import RVJAX, Case, Values, case, clone_folder, read, yardsticks
from rvjax.simulation import jax_config

CHUNKS_PER_CORE = 1
STEPS = 1600
COMPARED = ("final_position_error_m", "final_attitude_error_deg")
"""The end of a flight, which ways without metrics give as well."""

TOLERANCE = 1e-3
"""Largest difference that counts as agreeing, relative to the largest error of all samples. The sign switches of the Levant
differentiator turn the last digit into 1e-5 within a minute; without them ways agree to 1e-9 (tests/run/test_yardsticks.py)."""

GROWTH = (1_000, 10_000, 100_000, 1_000_000)
GROWTH_STEPS = 200

ANSWER_S = 3600.0
"""How long a process may take for a flight, compiling included."""

LOOK_S = 0.01
"""Time between two looks for the first chunk."""

Say = Callable[[str], None]


@dataclass
class Bench:
    """The result of a benchmark.

    steps_per_s, samples_per_s, compile_s: by way. ratio: time of a way over that of `rvjax`, median over the rounds of the
    ratios within a round. apart: largest difference from `rvjax` in what is compared. unavailable: ways that cannot fly here,
    and why.
    cold_s, warm_s: from the start of `rvjax run` to its first chunk. growth: speed and memory by number of samples.
    """

    machine: dict[str, Any]
    case: dict[str, Any]
    steps_per_s: dict[str, float] = field(default_factory=dict[str, float])
    samples_per_s: dict[str, float] = field(default_factory=dict[str, float])
    ratio: dict[str, float] = field(default_factory=dict[str, float])
    compile_s: dict[str, float] = field(default_factory=dict[str, float])
    apart: dict[str, float] = field(default_factory=dict[str, float])
    agree: dict[str, bool] = field(default_factory=dict[str, bool])
    unavailable: dict[str, str] = field(default_factory=dict[str, str])
    cold_s: float | None = None
    warm_s: float | None = None
    peak_memory_mb: float | None = None
    growth: list[dict[str, float]] = field(default_factory=list[dict[str, float]])


class Worker:
    """A process that flies a single way (`rvjax.execution.bench.worker`)."""

    def __init__(self, spec: Mapping[str, Any]) -> None:
        self.name, self.result = str(spec["way"]), Path(spec["result"])
        self.seconds: list[float] = []
        command = [sys.executable, "-m", "rvjax.execution.bench.worker", json.dumps(spec)]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, encoding="utf-8", env=_environment(spec)
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *raised: object) -> None:
        if self._process.poll() is None:
            self._process.kill()
        self._process.wait()

    def answer(self) -> dict[str, Any]:
        """The next document; IncompleteError where the process has ended; its stderr says why."""
        assert self._process.stdout is not None
        with _limited(self._process, self.name):
            for line in self._process.stdout:
                if line.startswith("{"):
                    return json.loads(line)
        raise IncompleteError(f"bench: the process that flies {self.name} ended with exit code {self._process.wait()}")

    def fly(self) -> float:
        """Seconds of one flight."""
        assert self._process.stdin is not None
        self._process.stdin.write("fly\n")
        self._process.stdin.flush()
        self.seconds.append(float(self.answer()["seconds"]))
        return self.seconds[-1]

    def end(self) -> float:
        """Ends the process, which writes its result first; returns its peak memory [MB]."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        return float(self.answer()["peak_memory_mb"])


@contextmanager
def _limited(process: subprocess.Popen[str], what: str) -> Iterator[None]:
    """Kills a process that does not do what is waited for inside; IncompleteError then."""
    late = threading.Event()

    def end() -> None:
        late.set()
        process.kill()

    timer = threading.Timer(ANSWER_S, end)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
    if late.is_set():
        raise IncompleteError(f"bench: the process that flies {what} has not answered for {ANSWER_S:g} s")


def measure(campaign: Path | None, rounds: int, folder: Path | None, ways: Sequence[str], growth: bool, say: Say) -> Bench:
    """Measures rvjax and every yardstick that can fly here.

    campaign: default the starter campaign. rounds: flights of every way, in turn. folder: package of yardsticks, default that of
    this clone. ways: only these beside `rvjax`; default all. growth: also time and memory for up to 10⁶ samples.

    Errors: CampaignError for the campaign; UsageError where `folder` has no yardsticks, and for an unknown way; IncompleteError
    where a process ends before it should.
    """
    jax_config.configure("float64")
    from rvjax.simulation.batch import LANES

    folder = folder or clone_folder()
    names = chosen(ways, (*RVJAX, *yardsticks(folder)))
    samples = CHUNKS_PER_CORE * cores() * LANES
    with tempfile.TemporaryDirectory() as name, ExitStack() as stack:
        place = Path(name)
        path = campaign or _starter(place)
        flown = case(path, samples, STEPS, "float64", place / "start-float64.npz")
        result = Bench(
            machine={**jax_config.settings(), "cores": cores(), "jax": version("jax"), "jaxlib": version("jaxlib")},
            case={"campaign": flown.problem.spec.name, "samples": samples, "steps": STEPS, "lanes": LANES, "rounds": rounds},
        )
        say("first chunk, cold and warm")
        result.cold_s, result.warm_s = first_chunk(path, place, 4 * LANES)
        workers: dict[str, Worker] = {}
        for way in names:
            say(f"preparing {way}")
            worker = stack.enter_context(Worker(_order(way, path, samples, place, folder)))
            answer = worker.answer()
            if "unavailable" in answer:
                result.unavailable[way] = answer["unavailable"]
            else:
                workers[way], result.compile_s[way] = worker, answer["ready"]
        for number in range(rounds):
            say(f"round {number + 1} of {rounds}")
            for worker in workers.values():
                worker.fly()
        _finish(result, samples, workers)
        _compare(result, flown, workers)
        for number in GROWTH if growth else ():
            say(f"growth: {number:,} samples")
            result.growth.append(growth_of(path, number))
    return result


def chosen(ways: Sequence[str], known: Sequence[str]) -> list[str]:
    """`rvjax`, which all are compared with, and these ways, in the order in which they are known; all without a choice."""
    unknown = [way for way in ways if way not in known]
    if unknown:
        raise UsageError(f"--way: {', '.join(unknown)}: no such way to fly; accepted: {', '.join(known)}")
    return [way for way in known if not ways or way in ("rvjax", *ways)]


def _order(way: str, campaign: Path, samples: int, place: Path, yardsticks_folder: Path | None) -> dict[str, Any]:
    """What a worker process gets: see `rvjax.execution.bench.worker`."""
    precision = RVJAX[way].precision if way in RVJAX else "float64"
    return {
        "way": way,
        "campaign": str(campaign),
        "samples": samples,
        "steps": STEPS,
        "precision": precision,
        "start": str(place / f"start-{precision}.npz"),
        "result": str(place / f"{way}.npz"),
        "yardsticks": str(yardsticks_folder),
    }


def _finish(result: Bench, samples: int, workers: Mapping[str, Worker]) -> None:
    """Ends the workers; their speeds, and the ratios within each round."""
    for way, worker in workers.items():
        peak = worker.end()
        if way == "rvjax":
            result.peak_memory_mb = peak
        result.steps_per_s[way] = samples * STEPS / median(worker.seconds)
        result.samples_per_s[way] = samples / median(worker.seconds)
        result.ratio[way] = median(b / a for a, b in zip(workers["rvjax"].seconds, worker.seconds, strict=True))


def _starter(place: Path) -> Path:
    path = place / "starter.yaml"
    path.write_text(files("rvjax.cli").joinpath("starter.yaml").read_text(encoding="utf-8"), encoding="utf-8")
    return path


def _environment(spec: Mapping[str, Any]) -> dict[str, str]:
    """rvjax makes its settings in XLA_FLAGS; a yardstick flies without them."""
    environment = dict(os.environ)
    if spec["way"] not in RVJAX:
        environment.pop("XLA_FLAGS", None)
    return environment


def _compare(result: Bench, flown: Case, workers: Mapping[str, Worker]) -> None:
    """The distance of the results of each way from those of `rvjax`."""
    names = {name: 0.0 for metric in flown.problem.metrics for name in metric.columns}
    ours: Values | None = None
    for way, worker in workers.items():
        values: Values = read(worker.result, names) if way in RVJAX else flown.values(read(worker.result, flown.carry))
        ours = ours or values
        result.apart[way] = max(apart(values[name], ours[name]) for name in COMPARED)
        result.agree[way] = result.apart[way] <= TOLERANCE


def apart(values: NDArray[np.float64], reference: NDArray[np.float64]) -> float:
    """max |vᵢ − rᵢ| / max |rᵢ|; NaN counts as infinitely far."""
    largest = float(np.max(np.abs(values - reference)) / np.max(np.abs(reference)))
    return largest if np.isfinite(largest) else float("inf")


def first_chunk(campaign: Path, place: Path, samples: int) -> tuple[float, float]:
    """Seconds from the start of `rvjax run` to its first chunk in the folder, with empty caches and with filled ones."""

    def once(name: str) -> float:
        command = [sys.executable, "-m", "rvjax", "run", str(campaign), "--out", str(place / name), "--samples", str(samples)]
        cache = {"XDG_CACHE_HOME": str(place / "cache"), "HOME": str(place)}
        started = time.perf_counter()
        with (
            subprocess.Popen(
                [*command, "--quiet"], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, encoding="utf-8", env=os.environ | cache
            ) as run,
            _limited(run, "the first chunk"),
        ):
            while run.poll() is None:
                if any((place / name / "samples").glob("*.parquet")):
                    spent = time.perf_counter() - started
                    run.terminate()
                    return spent
                time.sleep(LOOK_S)
            assert run.stderr is not None
            said = run.stderr.read()
        raise IncompleteError(f"bench: `{' '.join(command)}` ended with exit code {run.returncode} and no chunk: {said}")

    return once("cold"), once("warm")


def growth_of(campaign: Path, samples: int) -> dict[str, float]:
    """Speed (draws included) and memory for a number of samples."""
    spec = {"campaign": str(campaign), "samples": samples, "steps": GROWTH_STEPS, "precision": "float64"}
    command = [sys.executable, "-m", "rvjax.execution.bench.scaling", json.dumps(spec)]
    try:
        done = subprocess.run(command, stdout=subprocess.PIPE, encoding="utf-8", check=True, timeout=ANSWER_S)
    except subprocess.CalledProcessError as error:
        raise IncompleteError(
            f"bench: the process that flies {samples:,} samples ended with exit code {error.returncode}"
        ) from error
    except subprocess.TimeoutExpired as error:
        raise IncompleteError(f"bench: the process that flies {samples:,} samples has not ended in {ANSWER_S:g} s") from error
    answer = json.loads(done.stdout.splitlines()[-1])
    return {
        "samples": samples,
        "steps_per_s": answer["steps"] / answer["seconds"],
        "peak_memory_mb": answer["peak_memory_mb"],
    }
