"""Replay: the same compiled program on the same draws, so the metrics equal the table bit for bit."""

# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false, reportMissingTypeStubs=false
# (JAX and pandas say little about their types)

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from rvjax.analysis.verdicts.folders import campaign_of
from rvjax.columns import Column
from rvjax.errors import FolderError, UsageError
from rvjax.execution.identity import identity
from rvjax.places import Place
from rvjax.run_folder import RunFolder
from rvjax.run_folder.manifest import differences
from rvjax.run_folder.parquet import encode
from rvjax.simulation import jax_config, tables
from rvjax.simulation.batch import LANES, Flyer
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import Problem, load
from rvjax.simulation.signals import interrupting

Trace = tuple[pd.DataFrame, dict[str, Column]]


def replay(folder: str | Place, sample: int, every: int = 1) -> tuple[pd.DataFrame, dict[str, Column], dict[str, Any]]:
    """Flies a sample of a run again. Returns its trace (a row for every `every`-th step), the meaning of the trace's columns, and
    the sample's row of the samples table, which the flight has reproduced exactly.

    Errors: UsageError if the run has no such sample; FolderError if the run was flown by other code, packages or settings, or if
    the metrics are not those of the sample's row.
    """
    opened = RunFolder.open(folder)
    campaign_of(opened)  # refuses the folder of a search
    rows = recorded(opened, [sample])
    problem = load(opened.campaign_source(), opened.provenance["overrides"])
    jax_config.configure(problem.spec.precision)
    if differing := differences(opened.identity, identity(problem)):
        what = "\n".join(differing)
        raise FolderError(f"{folder}: was flown by other code, packages or settings, so its flights cannot be repeated\n{what}")
    row = rows.set_index("sample", drop=False).loc[sample].to_dict()
    return (*trace(problem, Flyer.of(problem), [sample], every, rows)[sample], row)


def recorded(folder: RunFolder, samples: Sequence[int]) -> pd.DataFrame:
    """The rows of some samples, in the order given, read from their chunks; UsageError where a sample is missing."""
    wanted = np.unique(np.asarray(samples, dtype=np.int64))
    chunks, held = folder.chunks.holding(wanted)
    if absent := wanted[~held].tolist():
        accepted = f"accepted: 0 to {folder.requested - 1}, if flown"
        raise UsageError(f"{folder.path}: no sample {', '.join(map(str, absent))}; {accepted}")
    rows = pd.concat([frame[np.isin(frame["sample"], wanted)] for _, frame, _ in folder.tables(chunks.number.tolist())])
    return rows.set_index("sample", drop=False).loc[list(samples)].reset_index(drop=True)


def trace_file(path: Path) -> Path:
    """The path; UsageError where its suffix is no format of `save`."""
    if path.suffix not in (".parquet", ".csv"):
        raise UsageError(f"{path}: unknown format; accepted: a name that ends in .parquet or .csv")
    return path


def save(path: Path, frame: pd.DataFrame, columns: Mapping[str, Column]) -> None:
    """Writes a trace as Parquet (with units and meanings) or as CSV, by the suffix. UsageError where it cannot be written."""
    trace_file(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        data = encode(frame, columns) if path.suffix == ".parquet" else frame.to_csv(index=False).encode()
        path.write_bytes(data)
    except OSError as error:
        raise UsageError(f"{path}: cannot be written ({error.strerror}); accepted: a path that can be written") from error


def trace(problem: Problem, flyer: Flyer, samples: Sequence[int], every: int, rows: pd.DataFrame) -> Mapping[int, Trace]:
    """The traces of some samples, flown together in a chunk. rows: of the samples table, at least those of the samples; the
    metrics of the flights must equal them.

    Errors: FolderError naming the samples whose metrics differ.
    """
    if len(samples) > LANES:
        raise UsageError(f"{len(samples)} samples to trace; accepted: up to {LANES}")
    numbers = np.resize(np.asarray(samples, dtype=np.int64), flyer.lanes(len(samples)))
    draws, drawn = Draws.of(problem, numbers)
    flown = flyer.fly(drawn, problem.spec.horizon.steps, every, trace=range(len(samples)))
    again, _ = tables.samples_table(problem, draws, flown, slice(0, len(samples)))
    known = rows.set_index("sample").loc[list(samples)].reset_index()
    differing = [name for name in again.columns if not again[name].equals(known[name])]
    if differing:
        raise FolderError(f"samples {', '.join(map(str, samples))}: flown again, {', '.join(differing)} differ from the table")
    signals, measured = problem.loop.controller.signals, bool(problem.navigation)
    effects = {choice.name: effect for choice, effect in zip(problem.spec.effects, problem.loop.effects, strict=True)}
    errors = {choice.name: error for choice, error in zip(problem.spec.navigation, problem.loop.navigation, strict=True)}
    frames, columns = tables.trace_tables(flown.steps, signals, measured, effects, flown.means, interrupting(errors))
    return {sample: (frame, columns) for sample, frame in zip(samples, frames, strict=True)}
