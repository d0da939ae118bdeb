"""The pipeline: a campaign file becomes a run folder with its report.

campaigns/x.yaml ─load→ Spec ─resolve→ Problem ─draw→ Batch ─fly→ Flights ─columns→ Table ─write→ run folder ─→ report
"""

# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false, reportMissingTypeStubs=false
# (JAX and pandas say little about their types)

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from rvjax.analysis.accumulator import RunAccumulator
from rvjax.analysis.run_totals import Totals, wanted
from rvjax.analysis.verdicts import Verdict, campaign_of
from rvjax.campaign import Spec
from rvjax.campaign.choice import Choice
from rvjax.components.samplers import sampling_design_of
from rvjax.cores import cores
from rvjax.errors import UsageError
from rvjax.execution.audit import prove
from rvjax.execution.chunks import ENVELOPE_CHUNKS, ChunkResult, ChunkRunner
from rvjax.execution.executors import ExecutorFactory
from rvjax.execution.executors.threads import inline, map_in_threads
from rvjax.execution.identity import PLAN, identity, provenance, short
from rvjax.execution.replay import Trace, recorded, trace
from rvjax.run_folder import BASELINES, Account, RunFolder
from rvjax.run_folder.manifest import NAME as MANIFEST
from rvjax.simulation import jax_config
from rvjax.simulation.batch import LANES
from rvjax.simulation.problem import load

TRACE_ROWS = 600
"""Of a kept flight: one of more steps is thinned to at most so many."""

TRACED = 104
"""Flights that are traced together: each takes 400 kB until it is written."""

Progress = Callable[[int, int], None]
"""Called with the samples flown so far, and all samples requested."""


def run(
    path: str | Path,
    out: str | Path | None = None,
    overrides: Sequence[str] = (),
    progress: Progress | None = None,
    command: Sequence[str] = (),
    opened: Callable[[Path], None] | None = None,
    crew: ExecutorFactory = inline,
    finished: Callable[[Account, tuple[Verdict, ...]], None] | None = None,
    baseline: Callable[[str], None] | None = None,
    until_decided: bool = False,
) -> Path:
    """Flies a campaign into a run folder, keeps the flights that it asks for and writes the report; returns the folder.

    out: the folder, default `reports/<name>/<identity>`. A folder with the same identity is gone on with: only what is missing
    or damaged is flown. overrides: `place=value`, as in `--set`. command: what to record as the command.
    opened: called with the folder once it is there, before anything flies. crew: who flies, `rvjax.execution.executors`.
    finished: called with how the samples ended and with the verdicts, for which the folder need not be read again.
    baseline: called with the name of each other controller before it flies the same draws, into `baselines/<name>` of the folder.
    until_decided: no more chunks are flown once sequential methods have decided all requirements; the samples of the campaign are
    the most that are flown. Where one requirement is judged by a fixed number of samples, all of them are.

    Errors: CampaignError with every finding; UsageError where samples are added that a fixed number of them was judged without;
    FolderError where the folder is damaged or belongs to another run; IncompleteError
    where the disk refuses or chunks could not be flown.
    """
    given = progress or _nothing, command, opened or _nothing, crew, baseline or _nothing, until_decided
    place, account, fold = _run(path, out, overrides, *given)
    if finished is not None:
        finished(account, fold.verdicts)
    return place


def _run(
    path: str | Path,
    out: str | Path | None,
    overrides: Sequence[str],
    progress: Progress,
    command: Sequence[str],
    opened: Callable[[Path], None],
    crew: ExecutorFactory,
    baseline: Callable[[str], None] | None,
    until_decided: bool = False,
) -> tuple[Path, Account, RunAccumulator]:
    """As `run`; returns the folder, how the samples ended, and all that was folded of them. baseline: None where one flies."""
    problem = load(path, overrides)
    jax_config.configure(problem.spec.precision)
    mine = identity(problem)
    spec = problem.spec
    place = Path(out) if out is not None else Path("reports") / spec.name / short(mine)
    before = RunFolder.open(place) if (place / MANIFEST).exists() else None
    inputs = spec.source.inputs
    if before is not None:
        _may_go_on(before, mine, spec)
    early = until_decided and bool(spec.require) and all(one.method != "fixed" for one in spec.require)
    first = _next_look(0) if before is None else before.requested
    samples = min(spec.samples, first) if early else spec.samples
    described = (mine, provenance(command, overrides), spec.source.text, samples, spec.name)
    folder = RunFolder.resume(place, *described, LANES, inputs) if before else RunFolder.create(place, *described, inputs)
    opened(place)
    fold = RunAccumulator(spec.require, sampling_design_of(spec), spec.keep)
    with folder:
        pilot = ChunkRunner(problem, mine)
        _fly(pilot, folder, fold, crew, progress, baseline is None)
        while early and not fold.decided and folder.requested < spec.samples:
            folder.grow(min(spec.samples, _next_look(folder.requested)))
            _fly_missing(pilot, folder, fold, crew, progress)
        _keep(pilot, folder, wanted(fold.totals))
        others: dict[str, Totals] = {}
        for choice in spec.baselines:
            assert baseline is not None, "a baseline has none"
            baseline(choice.name)
            its = place / BASELINES / choice.name, (*overrides, *instead(choice), f"samples={folder.requested}")
            others[choice.name] = _run(path, *its, progress, command, _nothing, crew, None)[2].totals
        from rvjax import report  # plotting takes a second to import: the first chunk shall not wait for it

        report.write(folder, report.opened(folder, fold, spec, others))
        return place, fold.totals.account(folder.requested), fold


def _next_look(flown: int) -> int:
    """So many samples are to be there at the next look at whether all is decided: a quarter more, or a chunk for each core."""
    chunks = flown // LANES
    return LANES * (chunks + max(cores(), chunks // 4))


def _nothing(*given: object) -> None:
    """Takes no notice."""


def instead(choice: Choice) -> tuple[str, ...]:
    """Overrides that put a baseline in the place of the controller under test."""
    said = {"use": choice.use, "name": choice.name, **choice.parameters}
    return f"controller={json.dumps(said)}", "baselines=[]"


def _may_go_on(folder: RunFolder, mine: Mapping[str, Any], spec: Spec) -> None:
    """UsageError where a folder cannot be gone on with to so many samples, or could not be judged then."""
    if PLAN in mine:
        _same_plan(folder, mine)
    if spec.samples <= folder.requested or folder.missing(math.ceil(folder.requested / LANES)):
        return
    if any(one.method == "fixed" for one in spec.require) and any(one.method == "fixed" for one in campaign_of(folder).require):
        raise UsageError(
            f"{folder.path}: judged at {folder.requested} samples, now {spec.samples} are asked for; to look again until it "
            f"passes is no test by a fixed number of samples. Accepted: --samples {folder.requested}, method: sequential in "
            "require, or another folder with --out and another --seed"
        )


def _same_plan(folder: RunFolder, mine: Mapping[str, Any]) -> None:
    """UsageError where the folder's samples are a plan of another number of them."""
    theirs, ours = (identity.get(PLAN, {}) for identity in (folder.identity, mine))
    if theirs and ours and theirs["use"] == ours["use"] and theirs["samples"] != ours["samples"]:
        raise UsageError(
            f"{folder.path}: {theirs['samples']} samples of {theirs['use']}, now {ours['samples']}: a plan cannot be extended or "
            f"cut, another number of samples is another plan; go on with --samples {theirs['samples']}, or choose another folder "
            "with --out"
        )


def _fly(
    pilot: ChunkRunner, folder: RunFolder, fold: RunAccumulator, crew: ExecutorFactory, progress: Progress, baseline: bool
) -> None:
    """Flies the chunks that the folder lacks, and folds them and those that were there. One of these that turns out to be
    damaged is flown again."""
    chunks = math.ceil(folder.requested / LANES)
    folder.quarantine_damaged(["envelopes"])
    unread = {chunk.number for chunk in folder.chunks}
    if folder.missing(chunks, ENVELOPE_CHUNKS):
        folder.keep_audit(prove(pilot.problem, pilot.flyer, baseline).record)
    while (missing := folder.missing(chunks, ENVELOPE_CHUNKS)) or unread:
        if missing:
            _fly_missing(pilot, folder, fold, crew, progress)
        for table in folder.read_valid_chunks(sorted(unread.difference(missing))):  # a damaged one is missing from then on
            fold.add(*table)
        unread.clear()


def _fly_missing(pilot: ChunkRunner, folder: RunFolder, fold: RunAccumulator, crew: ExecutorFactory, progress: Progress) -> None:
    """Flies the chunks that are missing, commits each as it comes, and folds it."""
    samples, total = folder.requested, max(folder.requested, pilot.problem.spec.samples)
    missing = folder.missing(math.ceil(samples / LANES), ENVELOPE_CHUNKS)
    done = samples - sum(min(LANES, samples - chunk * LANES) for chunk in missing)
    progress(done, total)

    def keep(parcel: ChunkResult) -> None:
        nonlocal done
        for file in parcel.files:
            folder.take(file)
        for table in folder.tables([parcel.chunk]):  # what is on the disk is what is folded
            fold.add(*table)
        done += parcel.samples
        progress(done, total)

    with crew(pilot, folder) as executor:
        executor.fly(missing, keep)


def _keep(pilot: ChunkRunner, folder: RunFolder, samples: Sequence[int]) -> None:
    """Flies samples again and keeps their flights, thinned, in place of those that were kept before."""
    folder.quarantine_damaged(["traces"])
    kept = set(folder.trace_samples())
    folder.drop_traces(kept.difference(samples))
    new = [sample for sample in samples if sample not in kept]
    every = math.ceil(pilot.problem.spec.horizon.steps / TRACE_ROWS)

    def fly(group: Sequence[int]) -> dict[int, Trace]:
        return dict(trace(pilot.problem, pilot.flyer, group, every, recorded(folder, group)))

    def write(traces: dict[int, Trace]) -> None:
        for sample, (frame, columns) in traces.items():
            folder.write_trace(sample, frame, columns)

    map_in_threads(fly, (new[first : first + TRACED] for first in range(0, len(new), TRACED)), write, pilot.flyer.stop)
