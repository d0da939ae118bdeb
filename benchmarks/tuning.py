"""What a tuning costs beside a campaign: `python -m benchmarks.tuning [--rounds N] [FILE]`.

In turn, in one process and on all cores: a campaign's own chunks as `rvjax run` flies them, drawn and encoded, and the first
round of a race of as many lanes, `--candidates` candidates on common draws, loaded, drawn and encoded as `rvjax tune` does. The
ratio of their steps per second within each round, its median and quartiles. What came out: docs/tuning.md.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np

from rvjax.execution.chunks import ENVELOPE_CHUNKS, ChunkRunner
from rvjax.execution.executors.threads import map_in_threads
from rvjax.execution.identity import identity
from rvjax.run_folder import RunDescription, RunFolder
from rvjax.search.tuning.candidate_flights import Flights
from rvjax.search.tuning.tune import prepare
from rvjax.simulation import jax_config
from rvjax.simulation.batch import LANES, streams

CAMPAIGN = Path(__file__).parents[1] / "campaigns" / "tuning" / "saturated-adaptive.yaml"
CHUNKS = 4
"""A race's first round by default: 16 candidates on 104 samples each."""


def main() -> None:
    """Prints the ratios."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", nargs="?", default=CAMPAIGN, type=Path)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--candidates", type=int, default=16)
    given = parser.parse_args()
    jax_config.configure()
    space, _, _, _ = prepare(given.file, ["samples=100000000"])  # as many chunks as it may take
    problem, rng = space.problem, np.random.default_rng(0)
    runner = ChunkRunner(problem, {})
    lanes = CHUNKS * LANES
    samples = np.arange(lanes // given.candidates, dtype=np.int64)
    ratios: list[float] = []
    with tempfile.TemporaryDirectory() as place:
        description = RunDescription(identity=identity(problem), provenance={}, campaign_text="", samples=LANES, name="x")
        folder = RunFolder.create(Path(place) / "out", description)
        with folder:
            flights = Flights(space, folder, ["metric.settling_time_s", "metric.delta_v_m_s"], np.inf)
            for number in range(given.rounds + 1):
                began = time.perf_counter()
                first = ENVELOPE_CHUNKS + number * CHUNKS  # later ones keep no envelopes
                map_in_threads(runner.fly_chunk, range(first, first + CHUNKS), lambda result: None, runner.flyer.stop)
                own = time.perf_counter() - began
                began = time.perf_counter()
                points = rng.random((given.candidates, len(space.free)))
                flights.fly([flights.number(space.values(point), point) for point in points], samples)
                raced = time.perf_counter() - began
                if number:  # the first round compiles
                    ratios.append(own / raced)
                    speed = lanes * problem.spec.horizon.steps / own
                    print(
                        f"campaign {speed / 1e6:.2f} M steps/s, race {speed * own / raced / 1e6:.2f}: {own / raced:.3f}",
                        flush=True,
                    )
    low, middle, high = np.quantile(ratios, [0.25, 0.5, 0.75])
    print(f"{given.candidates} candidates x {len(samples)} samples, {streams()} streams: {middle:.3f} ({low:.3f} to {high:.3f})")


if __name__ == "__main__":
    main()
