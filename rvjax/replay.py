"""Flying samples again: the same compiled program on the same draws, so the metrics are those of the table, bit for bit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from rvjax import process, tables
from rvjax.batch import LANES, Flyer
from rvjax.campaign import Problem, load
from rvjax.columns import Column
from rvjax.draw import Draws
from rvjax.errors import FolderError, UsageError
from rvjax.identity import identity
from rvjax.results import RunFolder
from rvjax.results.manifest import differences

Trace = tuple[pd.DataFrame, dict[str, Column]]


def replay(folder: str | Path, sample: int, every: int = 1) -> tuple[pd.DataFrame, dict[str, Column]]:
    """Flies one sample of a run again; returns its trace (one row for every so many steps) and the meaning of its columns.

    Errors: UsageError if the run has no such sample; FolderError if the run was flown by other code, packages or settings, or if
    the metrics are not those of the sample's row.
    """
    opened = RunFolder.open(folder)
    frame = opened.samples().frame
    if sample not in frame["sample"].to_numpy():
        raise UsageError(f"{folder}: no sample {sample}; accepted: 0 to {opened.requested - 1}, if flown")
    problem = load(Path(folder) / "campaign.yaml")
    process.configure(problem.spec.precision)
    if differing := differences(opened.identity, identity(problem)):
        what = "\n".join(differing)
        raise FolderError(f"{folder}: was flown by other code, packages or settings, so its flights cannot be repeated\n{what}")
    return trace(problem, [sample], every, frame)[sample]


def trace(problem: Problem, samples: Sequence[int], every: int, table: pd.DataFrame) -> Mapping[int, Trace]:
    """The traces of some samples, flown together in one chunk. table: the samples table that their metrics must equal.

    Errors: FolderError naming the samples whose metrics differ.
    """
    if len(samples) > LANES:
        raise UsageError(f"{len(samples)} samples to trace; accepted: at most {LANES}")
    numbers = np.resize(np.asarray(samples, dtype=np.int64), LANES)
    draws, drawn = Draws.of(problem, numbers)
    flyer = Flyer(problem.loop, problem.metrics)
    flown = flyer.fly(drawn, problem.spec.horizon.steps, every, trace=range(len(samples)))
    again, _ = tables.samples_table(problem, draws, flown, slice(0, len(samples)))
    recorded = table.set_index("sample").loc[list(samples)].reset_index()
    differing = [name for name in again.columns if not again[name].equals(recorded[name])]
    if differing:
        raise FolderError(f"samples {', '.join(map(str, samples))}: flown again, {', '.join(differing)} differ from the table")
    return {sample: tables.trace_table(flown.steps, position) for position, sample in enumerate(samples)}
