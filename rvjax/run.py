"""The pipeline: a campaign file becomes a run folder with its report.

campaigns/x.yaml ─load→ Spec ─resolve→ Problem ─draw→ Batch ─fly→ Flights ─columns→ Table ─write→ run folder ─→ report
"""

# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false, reportMissingTypeStubs=false
# (JAX and pandas say little about their types)

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path

from rvjax import process
from rvjax.batch import LANES
from rvjax.campaign import load
from rvjax.executors import Crew
from rvjax.executors.inline import inline
from rvjax.identity import identity, provenance, short
from rvjax.pilot import ENVELOPE_CHUNKS, Parcel, Pilot
from rvjax.replay import trace
from rvjax.results import RunFolder
from rvjax.results.manifest import NAME as MANIFEST

TRACE_ROWS = 600
WORST = 10

Progress = Callable[[int, int], None]
"""Called with the samples flown so far, and all samples requested."""


def run(
    path: str | Path,
    out: str | Path | None = None,
    overrides: Sequence[str] = (),
    progress: Progress | None = None,
    command: Sequence[str] = (),
    opened: Callable[[Path], None] | None = None,
    crew: Crew = inline,
) -> Path:
    """Flies a campaign into a run folder, keeps the traces of its worst samples and writes the report; returns the folder.

    out: the folder, default `reports/<name>/<identity>`. A folder with the same identity is gone on with: only what is missing
    is flown. overrides: `place=value`, as in `--set`. command: what to record as the command.
    opened: called with the folder once it is there, before anything flies. crew: who flies, `rvjax.executors`.

    Errors: CampaignError with every finding; FolderError where the folder is damaged or belongs to another run; IncompleteError
    where the disk refuses or chunks could not be flown.
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
        pilot = Pilot(problem, mine)
        _fly_missing(pilot, folder, crew, progress or (lambda done, total: None))
        keep_worst(pilot, folder)
    from rvjax import report  # plotting takes a second to import: the first chunk shall not wait for it

    report.build(place)
    return place


def _fly_missing(pilot: Pilot, folder: RunFolder, crew: Crew, progress: Progress) -> None:
    """Flies the chunks that the folder lacks and commits each as it comes."""
    samples = folder.requested
    count = math.ceil(samples / LANES)
    folder.weed(["envelopes", "traces"])
    for _ in folder.sift([chunk.number for chunk in folder.chunks]):
        pass
    missing = folder.missing(count, ENVELOPE_CHUNKS)
    if not missing:
        return
    done = samples - sum(min(LANES, samples - chunk * LANES) for chunk in missing)
    progress(done, samples)

    def keep(parcel: Parcel) -> None:
        nonlocal done
        for file in parcel.files:
            folder.take(file)
        done += parcel.samples
        progress(done, samples)

    with crew(pilot, folder) as executor:
        executor.fly(missing, keep)


def keep_worst(pilot: Pilot, folder: RunFolder) -> None:
    """Flies the worst samples again, thinned, and keeps their traces."""
    from rvjax.sections.opened import open_run
    from rvjax.sections.worst import worst_first

    run = open_run(folder.path)
    worst = [int(run.frame["sample"].iloc[row]) for row in worst_first(run)[:WORST]]
    every = math.ceil(pilot.problem.spec.horizon.steps / TRACE_ROWS)
    folder.drop_traces(run.traces.keys() - worst)
    new = [sample for sample in worst if sample not in run.traces]
    if new:
        for sample, (frame, columns) in trace(pilot.problem, pilot.flyer, new, every, run.frame).items():
            folder.write_trace(sample, frame, columns)
