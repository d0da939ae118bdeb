"""Golden flights: the first chunk of every shipped campaign as a digest.

`python -m tests.golden.flights` writes flights.json anew, for a change after which results differ. CHANGELOG says so then.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import jax
import numpy as np

from rvjax.simulation import jax_config
from rvjax.simulation.batch import LANES, Flyer
from rvjax.simulation.draws import Draws
from rvjax.simulation.engines.llvm.engine import LlvmEngine
from rvjax.simulation.engines.llvm.machine_code import Target
from rvjax.simulation.problem import load

FOLDER = Path(__file__).parents[2] / "campaigns"
FILE = Path(__file__).with_suffix(".json")
CAMPAIGNS = sorted(str(path.relative_to(FOLDER)) for path in FOLDER.rglob("*.yaml"))


def digest(name: str, target: Target | None = None) -> str:
    """Of all numbers that are drawn for the samples of the first chunk, of all metrics and of the times of loss."""
    problem = load(FOLDER / name)
    jax_config.configure(problem.spec.precision)
    _, drawn = Draws.of(problem, np.arange(LANES, dtype=np.int64))
    steps = problem.spec.horizon.steps
    flown = Flyer(LlvmEngine(problem.loop, problem.metrics, target)).fly(drawn, steps, steps)
    text = hashlib.sha256()
    for numbers in (*jax.tree.leaves(drawn), *(flown.values[column] for column in sorted(flown.values)), flown.lost_s):
        rows = np.array(numbers, dtype="<f8")
        rows[np.isnan(rows)] = np.nan
        text.update(rows.tobytes())
    return text.hexdigest()[:16]


def main() -> None:
    """Writes the digests."""
    FILE.write_text(json.dumps({name: digest(name) for name in CAMPAIGNS}, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
