"""What every way flies: samples, steps and the carry at t = 0; and the yardsticks by name."""

# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false, reportMissingTypeStubs=false
# (JAX says little about its types)

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import jax
import numpy as np
from numpy.typing import NDArray

from rvjax.errors import UsageError
from rvjax.simulation import closed_loop, flight
from rvjax.simulation.batch import compiled
from rvjax.simulation.closed_loop import Drawn
from rvjax.simulation.draws import Draws
from rvjax.simulation.flight import Carry
from rvjax.simulation.problem import Problem, load

Values = Mapping[str, NDArray[np.float64]]
"""Metric → (samples,)."""


class OwnWay(NamedTuple):
    """A way of rvjax. threads: chunks at a time, None: as in `rvjax run`."""

    engine: str = "auto"
    precision: str = "float64"
    threads: int | None = None


RVJAX: Mapping[str, OwnWay] = {
    "rvjax": OwnWay(),
    "rvjax_one_device": OwnWay(threads=1),
    "rvjax_float32": OwnWay(precision="float32"),
    "rvjax_xla": OwnWay("xla"),
}
"""The ways of rvjax, the first that all are compared with; all others are yardsticks."""


class UnavailableError(Exception):
    """A way cannot fly here; the message says why."""


@dataclass(frozen=True)
class Case:
    """drawn, carry: numbers of all samples, each of shape (samples,), in the precision; the carry is that of t = 0.

    Every way flies all samples from step 0 to `steps`, metrics included, and gives the carry there.
    """

    problem: Problem
    samples: int
    steps: int
    precision: str
    drawn: Drawn
    carry: Carry

    @property
    def evaluate(self) -> Callable[..., Any]:
        """(numbers, t, y, held, tick) → (ẏ, everything at this instant, held), of one sample."""
        return partial(closed_loop.evaluate, self.problem.loop)

    @property
    def step(self) -> Callable[[Drawn, Carry, Any], Carry]:
        """(numbers, carry at step k, k) → carry at step k + 1, of one sample."""
        return partial(flight.step, self.evaluate, self.problem.metrics)

    def values(self, carry: Carry) -> Values:
        """The metrics of flights that ended with this carry."""
        finish = partial(flight.finish, self.evaluate, self.problem.metrics)
        values, _ = compiled(finish, 0, 0, None)(self.drawn, carry, self.steps)
        return {name: np.asarray(value, dtype=np.float64) for name, value in values.items()}


def case(campaign: str | Path, samples: int, steps: int, precision: str, start: str | Path, engine: str = "auto") -> Case:
    """The case of a campaign's first samples. engine: that flies the ways of rvjax. start: file of the carry at t = 0, written by
    `save` if it is not there."""
    problem = load(campaign, [f"engine={engine}"])
    _, drawn = Draws.of(problem, np.arange(samples, dtype=np.int64))
    drawn = jax.tree.map(partial(np.asarray, dtype=precision), drawn)
    begin = compiled(partial(flight.begin, problem.loop, problem.metrics), 0)
    if not Path(start).exists():
        save(start, begin(drawn))
    return Case(problem, samples, steps, precision, drawn, read(start, jax.eval_shape(begin, drawn)))


def save(path: str | Path, tree: Any) -> None:
    """The numbers of a tree, in their order."""
    np.savez(path, *(np.asarray(leaf) for leaf in jax.tree.leaves(tree)))


def read(path: str | Path, like: Any) -> Any:
    """A tree of this kind from its numbers."""
    with np.load(path, allow_pickle=False) as data:
        leaves = [data[f"arr_{index}"] for index in range(len(data.files))]
    return jax.tree.unflatten(jax.tree.structure(like), leaves)


def yardsticks(folder: Path | None) -> Mapping[str, Any]:
    """Name → module of the yardsticks, as listed in `YARDSTICKS` of the package in `folder`; none without a folder."""
    if folder is None:
        return {}
    if not (folder / "__init__.py").is_file():
        raise UsageError(f"{folder}: no yardsticks; accepted: the folder `benchmarks` of a clone of rvjax")
    sys.path.insert(0, str(folder.resolve().parent))
    table = import_module(folder.resolve().name).YARDSTICKS
    return {name: import_module(module) for name, module in table.items()}


def clone_folder() -> Path | None:
    """The yardsticks of the clone that holds this package or in which the command is given; None without a clone."""
    for place in (Path(__file__).parents[3], Path.cwd(), *Path.cwd().parents):
        if all((place / name).is_file() for name in ("pyproject.toml", "rvjax/__init__.py", "benchmarks/__init__.py")):
            return place / "benchmarks"
    return None
