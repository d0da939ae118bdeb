"""The engine `llvm` against `xla` on campaigns with other components: `python -m benchmarks.engines [--rounds N] [--float32]`.

Both fly the same chunks on a thread per core, in turn; the ratio is the median over the rounds of the speeds within a round. The
last row compares a law on arrays with the same law on vectors, both with `llvm`.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from rvjax.cores import cores
from rvjax.simulation import jax_config
from rvjax.simulation.batch import LANES
from rvjax.simulation.draws import Draws
from rvjax.simulation.engines.choice import engine_of
from rvjax.simulation.problem import load

FOLDER = Path(__file__).parents[1] / "campaigns"
STEPS: Mapping[str, int] = {
    "docking-faulted.yaml": 1200,
    "disturbances.yaml": 1000,
    "navigation.yaml": 1000,
    "thrusters.yaml": 100,
}
"""Campaign → steps of a flight."""

CHUNKS_PER_CORE = 2


class Way:
    """Chunks of a campaign in flight with an engine."""

    def __init__(self, campaign: Path, engine: str, steps: int) -> None:
        problem = load(campaign, [f"engine={engine}"])
        numbers = [Draws.of(problem, np.arange(i * LANES, (i + 1) * LANES))[1] for i in range(CHUNKS_PER_CORE * cores())]
        started = time.perf_counter()
        made = engine_of(problem)
        made.begin(numbers[0], steps=10**9).advance(0, 1)
        self.compile_s, self.steps, self.flown = time.perf_counter() - started, steps, 0
        self.chunks: list[Any] = [made.begin(drawn) for drawn in numbers]
        self.speeds: list[float] = []

    def fly(self) -> None:
        """Another stretch of every chunk."""
        first, started = self.flown, time.perf_counter()
        with ThreadPoolExecutor(cores()) as threads:
            list(threads.map(lambda chunk: chunk.advance(first, first + self.steps), self.chunks))
        self.flown += self.steps
        self.speeds.append(len(self.chunks) * LANES * self.steps / (time.perf_counter() - started))


def table(title: str, ways: tuple[Way, Way], rounds: int) -> None:
    """Flies two ways in turn and prints a row."""
    for _ in range(rounds):
        for way in ways:
            way.fly()
    first, second = ways
    ratio = median(a / b for a, b in zip(first.speeds, second.speeds, strict=True))
    speeds = f"{median(first.speeds) / 1e6:9.2f} {median(second.speeds) / 1e6:9.2f}"
    print(f"{title:36s} {speeds} {ratio:6.2f} {first.compile_s:8.1f} s {second.compile_s:6.1f} s", flush=True)


def main() -> None:
    """Prints the table."""
    from tests.user_code.mistakes import LAW
    from tests.user_code.test_user_flights import VECTORS
    from tests.user_code.test_user_mistakes import project

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--float32", action="store_true")
    given = parser.parse_args()
    jax_config.configure("float32" if given.float32 else "float64")
    print(f"{'first, second':36s} {'M steps/s':>19s} {'ratio':>6s} {'compile':>19s}")
    for name, steps in STEPS.items():
        table(f"{name}: llvm, xla", (Way(FOLDER / name, "llvm", steps), Way(FOLDER / name, "xla", steps)), given.rounds)
    with tempfile.TemporaryDirectory() as place:
        ways: list[Way] = []
        for form, law in (("arrays", LAW), ("vectors", VECTORS)):
            (Path(place) / form).mkdir()
            ways.append(Way(project(Path(place) / form, law), "llvm", 2000))
        table("a law: on arrays, on vectors", (ways[0], ways[1]), 3 * given.rounds)


if __name__ == "__main__":
    main()
