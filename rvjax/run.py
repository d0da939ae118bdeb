"""The pipeline: a campaign file becomes a run folder with its report.

campaigns/x.yaml ─load→ Spec ─resolve→ Problem ─draw→ Batch ─fly→ Flights ─columns→ Table ─write→ run folder ─→ report
"""

# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false, reportMissingTypeStubs=false
# (JAX and pandas say little about their types)

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rvjax import process, tables
from rvjax.batch import LANES, Flown, Flyer, devices, streams
from rvjax.campaign import Problem, load
from rvjax.draw import Draws
from rvjax.identity import identity, provenance, short
from rvjax.replay import trace
from rvjax.results import RunFolder
from rvjax.results.manifest import NAME as MANIFEST

ENVELOPE_CHUNKS = 5
"""Envelopes over time are kept of the first so many chunks, whose samples are drawn like all others."""

ENVELOPE_INSTANTS = 120
STRETCH = 250
"""Fewest steps between two looks at whether the run is to stop: a fraction of a second."""

TRACE_ROWS = 600
WORST = 10

Progress = Callable[[int, int], None]
"""Called with the samples flown so far, and all samples requested."""


class Chunk(NamedTuple):
    """A chunk by its number: what was drawn for its lanes, and what came of it."""

    chunk: int
    draws: Draws
    flown: Flown


def run(
    path: str | Path,
    out: str | Path | None = None,
    overrides: Sequence[str] = (),
    progress: Progress | None = None,
    command: Sequence[str] = (),
    opened: Callable[[Path], None] | None = None,
) -> Path:
    """Flies a campaign into a run folder, keeps the traces of its worst samples and writes the report; returns the folder.

    out: the folder, default `reports/<name>/<identity>`. A folder with the same identity is gone on with: only what is missing
    is flown. overrides: `place=value`, as in `--set`. command: what to record as the command.
    opened: called with the folder once it is there, before anything flies.

    Errors: CampaignError with every finding; FolderError where the folder is damaged or belongs to another run; IncompleteError
    where the disk refuses.
    """
    problem = load(path, overrides)
    process.configure(problem.spec.precision)
    mine = identity(problem)
    samples = problem.spec.samples
    place = Path(out) if out is not None else Path("reports") / problem.spec.name / short(mine)
    described = (mine, provenance(command, overrides), problem.spec.source.text, samples, problem.spec.name)
    there = (place / MANIFEST).exists()
    folder = RunFolder.resume(place, *described, LANES) if there else RunFolder.create(place, *described)
    if opened is not None:
        opened(place)
    with folder:
        flyer = Flyer(problem.loop, problem.metrics)
        _fly_missing(problem, flyer, folder, progress or (lambda done, total: None))
        folder.flush()
        keep_worst(problem, flyer, folder)
    from rvjax import report  # plotting takes a second to import: the first chunk shall not wait for it

    report.build(place)
    return place


def fly(problem: Problem, flyer: Flyer, chunks: Iterable[int], take: Callable[[Chunk], None]) -> None:
    """Draws and flies chunks, several beside each other, and hands them over in their order. What `take` does goes on beside
    flying; memory holds a few chunks at a time. Where it is interrupted, what has been flown is still handed over."""
    with ThreadPoolExecutor(streams()) as threads:
        todo, flying = deque(chunks), deque[Future[Chunk]]()
        try:
            while todo or flying:
                while todo and len(flying) < 2 * streams():
                    flying.append(threads.submit(_fly_chunk, problem, flyer, todo.popleft()))
                take(flying.popleft().result())
        except BaseException:
            flyer.stop()
            threads.shutdown(wait=True, cancel_futures=True)
            for future in flying:
                if not future.cancelled() and future.exception() is None:
                    take(future.result())
            raise


def _fly_missing(problem: Problem, flyer: Flyer, folder: RunFolder, progress: Progress) -> None:
    """Flies the chunks that the folder lacks and commits each as it comes."""
    samples = problem.spec.samples
    missing = folder.missing(math.ceil(samples / LANES))
    if not missing:
        return
    done = samples - sum(_count(problem, chunk) for chunk in missing)
    progress(done, samples)

    def keep(flown: Chunk) -> None:
        nonlocal done
        done += _commit(problem, folder, flown)
        progress(done, samples)

    fly(problem, flyer, missing, keep)


def keep_worst(problem: Problem, flyer: Flyer, folder: RunFolder) -> None:
    """Flies the worst samples again, thinned, and keeps their traces."""
    from rvjax.sections.opened import open_run
    from rvjax.sections.worst import worst_first

    run = open_run(folder.path)
    worst = [int(run.frame["sample"].iloc[row]) for row in worst_first(run)[:WORST]]
    every = math.ceil(problem.spec.horizon.steps / TRACE_ROWS)
    folder.drop_traces(run.traces.keys() - worst)
    new = [sample for sample in worst if sample not in run.traces]
    if new:
        for sample, (frame, columns) in trace(problem, flyer, new, every, run.frame).items():
            folder.write_trace(sample, frame, columns)


def _fly_chunk(problem: Problem, flyer: Flyer, chunk: int) -> Chunk:
    """Draws and flies one chunk."""
    draws, drawn = Draws.of(problem, np.arange(chunk * LANES, (chunk + 1) * LANES, dtype=np.int64))
    glance, places = chunk < ENVELOPE_CHUNKS, devices()
    every = _every(problem) if glance else max(_every(problem), STRETCH)
    flown = flyer.fly(drawn, problem.spec.horizon.steps, every, glance, device=places[chunk % len(places)])
    return Chunk(chunk, draws, flown)


def _commit(problem: Problem, folder: RunFolder, flown: Chunk) -> int:
    """Writes a chunk and returns how many samples it holds. Lanes behind the last sample are dropped."""
    rows = slice(0, _count(problem, flown.chunk))
    if flown.chunk < ENVELOPE_CHUNKS:
        frame = tables.envelope_table(flown.flown, _instants(problem), flown.draws.samples, rows)
        folder.write_envelope(flown.chunk, frame, tables.ENVELOPE)
    folder.commit(flown.chunk, *tables.samples_table(problem, flown.draws, flown.flown, rows))
    return rows.stop


def _count(problem: Problem, chunk: int) -> int:
    """Samples of a chunk: all its lanes, fewer in the last one."""
    return min(LANES, problem.spec.samples - chunk * LANES)


def _every(problem: Problem) -> int:
    return math.ceil(problem.spec.horizon.steps / ENVELOPE_INSTANTS)


def _instants(problem: Problem) -> NDArray[np.float64]:
    """Times of the observed steps [s], the last step always among them."""
    steps = problem.spec.horizon.steps
    return np.array([*range(0, steps, _every(problem)), steps]) * problem.spec.horizon.step_s
