"""The pipeline: a campaign file becomes a run folder with its report.

campaigns/x.yaml ─load→ Spec ─resolve→ Problem ─draw→ Batch ─fly→ Flights ─columns→ Table ─write→ run folder ─→ report
"""

# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false, reportMissingTypeStubs=false
# (JAX and pandas say little about their types)

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from rvjax.analysis.accumulator import RunAccumulator
from rvjax.analysis.run_totals import Totals, wanted
from rvjax.analysis.verdicts import Verdict, campaign_of
from rvjax.analysis.verdicts.rare import conclude_all
from rvjax.campaign import Source, Spec
from rvjax.campaign.choice import Choice
from rvjax.campaign.trace_retention import steps_per_row
from rvjax.components.samplers import sampling_design_of
from rvjax.cores import cores
from rvjax.errors import CampaignWarning, Finding, UsageError
from rvjax.execution.audit import prove, prove_baselines
from rvjax.execution.chunks import ENVELOPE_CHUNKS, ChunkResult, ChunkRunner
from rvjax.execution.executors import Executor, ExecutorFactory
from rvjax.execution.executors.threads import local_threads, map_in_threads
from rvjax.execution.identity import PLAN, fixed, provenance
from rvjax.execution.preparation import Prepared, prepare
from rvjax.execution.progress import OnProgress, PhaseProgress, timed
from rvjax.execution.progress_display import shown
from rvjax.execution.rare import search_all
from rvjax.execution.replay import Trace, recorded, trace
from rvjax.places import Place
from rvjax.run_folder import BASELINES, Account, RunDescription, RunFolder
from rvjax.run_folder.storages import is_run_folder, storage_of
from rvjax.simulation.batch import LANES
from rvjax.simulation.cautions import cautions
from rvjax.simulation.problem import Problem, baseline_overrides
from rvjax.timings import phase, timings

TRACED = 104
"""Flights that are traced together: each takes 400 kB until it is written."""

FEW = 64
"""Up to this number of finished chunks are read by this process where nothing else is to be done, without another executor."""


def _ignore(*args: object) -> None:
    """Does nothing: the default of every callback."""


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """How a campaign is flown and who is told; nothing here changes a number.

    command: recorded in the run folder. executor: what flies the chunks, see `rvjax.execution.executors`.
    until_decided: stop once sequential methods have decided every requirement. A requirement with a fixed number of samples
    needs all samples.
    on_progress: see `OnProgress`. on_open: called with the folder before the first flight. on_baseline: called with the name of
    each baseline controller before it flies. on_warnings: called before that with what is hardly meant in the campaign.
    timings: record in the run folder where the time of this process went.
    """

    command: Sequence[str] = ()
    executor: ExecutorFactory = local_threads
    until_decided: bool = False
    on_progress: OnProgress = _ignore
    on_open: Callable[[Place], None] = _ignore
    on_baseline: Callable[[str], None] = _ignore
    on_warnings: Callable[[Sequence[Finding]], None] = _ignore
    timings: bool = False


class FinishedRun(NamedTuple):
    """A run folder, how its samples ended, and the verdict on each requirement."""

    folder: Place
    account: Account
    verdicts: tuple[Verdict, ...]


def run(
    path: str | Path | Source,
    out: str | Place | None = None,
    overrides: Sequence[str] = (),
    *,
    progress: bool | OnProgress = True,
    until_decided: bool = False,
    executor: ExecutorFactory = local_threads,
    command: Sequence[str] = (),
) -> Place:
    """Flies a campaign into a run folder, writes its report and returns the folder.

    out: the folder, or `s3://bucket/prefix`; default `reports/<name>/<identity>`. A folder with the same identity is resumed:
    only missing and damaged chunks are flown. overrides: `place=value` as in `--set`. progress: shown in a terminal and in a
    notebook; False: nowhere; a function: called instead (`rvjax.execution.progress`). The other arguments are those of
    `RunOptions`. Warns (CampaignWarning) of what is hardly meant in the campaign.

    Errors: CampaignError with every finding; UsageError where samples are added to a run that a fixed number of samples has
    judged; FolderError where the folder is damaged or belongs to another run; IncompleteError where a file cannot be written
    or a chunk cannot be flown.
    """
    with shown(progress) as on_progress:
        options = RunOptions(
            command=command, executor=executor, until_decided=until_decided, on_progress=on_progress, on_warnings=warn
        )
        return fly(path, out, overrides, options).folder


def warn(findings: Sequence[Finding]) -> None:
    """Python's warnings of what is hardly meant in a campaign."""
    for finding in findings:
        warnings.warn(str(finding), CampaignWarning, stacklevel=4)


def fly(
    path: str | Path | Source,
    out: str | Place | None,
    overrides: Sequence[str],
    options: RunOptions,
    prepared: Prepared | None = None,
) -> FinishedRun:
    """As `run`, with all options. Baseline controllers of the campaign fly the same draws into `baselines/<name>`. prepared: the
    campaign, where it was prepared before."""
    problem, flown_by, place = prepared or prepare(path, overrides, out)
    spec = problem.spec
    doubtful = cautions(problem)
    options.on_warnings(doubtful)
    if spec.baselines and not is_run_folder(place):
        with timed("audit", options.on_progress), phase("audit"):
            prove_baselines(problem)
    with storage_of(place).tidied(), _open(problem, flown_by, place, overrides, options, doubtful) as folder:
        options.on_open(place)
        results = _fly_problem(problem, flown_by, folder, options)
        with phase("fly"):
            search_all(problem, flown_by, folder, options.on_progress)
        baselines: dict[str, Totals] = {}
        for choice in spec.baselines:
            options.on_baseline(choice.name)
            baselines[choice.name] = _fly_baseline(path, choice, folder, overrides, options)
        _report(folder, results, spec, baselines, options)
        verdicts = conclude_all(results.verdicts, folder.path)
    return FinishedRun(place, results.totals.account(folder.requested), verdicts)


def _fly_baseline(
    path: str | Path | Source, choice: Choice, main: RunFolder, overrides: Sequence[str], options: RunOptions
) -> Totals:
    """Flies a baseline controller on the draws of the main run, into a run folder inside the main one."""
    overrides = (*overrides, *baseline_overrides(choice), f"samples={main.requested}")
    problem, flown_by, place = prepare(path, overrides, main.path / BASELINES / choice.name)
    with _open(problem, flown_by, place, overrides, options) as folder:
        results = _fly_problem(problem, flown_by, folder, options, baseline=True)
        _report(folder, results, problem.spec, {}, options)
    return results.totals


def _open(
    problem: Problem,
    flown_by: Mapping[str, Any],
    place: Place,
    overrides: Sequence[str],
    options: RunOptions,
    doubtful: Sequence[Finding] = (),
) -> RunFolder:
    """The run folder of a problem, created or resumed, with the samples that are flown first. doubtful: its warnings."""
    spec = problem.spec
    existing = RunFolder.open(place) if is_run_folder(place) else None
    if existing is not None:
        _check_resumable(existing, flown_by, spec)
    samples = spec.samples
    if _stops_early(spec, options):
        samples = min(samples, _next_look(0) if existing is None else existing.requested)
    description = RunDescription(
        identity=flown_by,
        provenance=provenance(options.command, overrides)
        | {"fixed": fixed(problem)}
        | ({"warnings": [*map(str, doubtful)]} if doubtful else {}),
        campaign_text=spec.source.text,
        samples=samples,
        name=spec.name,
        inputs=spec.source.inputs,
    )
    return RunFolder.create(place, description) if existing is None else RunFolder.resume(place, description, LANES)


def _stops_early(spec: Spec, options: RunOptions) -> bool:
    """Whether the run may end before all samples are flown."""
    sequential = bool(spec.require) and all(requirement.is_sequential for requirement in spec.require)
    return options.until_decided and sequential


def _fly_problem(
    problem: Problem, flown_by: Mapping[str, Any], folder: RunFolder, options: RunOptions, *, baseline: bool = False
) -> RunAccumulator:
    """Flies what the folder lacks, and more until all is decided where the run may end early; keeps traces. Returns the
    results of all samples. baseline: a baseline controller flies; its audit looks at the controller's draws only."""
    spec = problem.spec
    runner = ChunkRunner(problem, flown_by)
    results = RunAccumulator(spec.require, sampling_design_of(spec), spec.keep)
    folder.quarantine_damaged(["envelopes"])
    if _missing(folder):
        with timed("audit", options.on_progress), phase("audit"):
            folder.keep_audit(prove(problem, runner.flyer, baseline).record)
    flights = PhaseProgress("flights", options.on_progress, runner.steps_flown, spec.horizon.steps, LANES)
    looks = not baseline and _stops_early(spec, options)
    many = _missing(folder) or looks or len(folder.chunks) > FEW
    with phase("fly"), (options.executor if many else local_threads)(runner, folder) as executor:
        _fly_and_fold(executor, folder, results, flights, spec.samples)
        while looks and not results.decided and folder.requested < spec.samples:
            folder.grow(min(spec.samples, _next_look(folder.requested)))
            _fly_and_fold(executor, folder, results, flights, spec.samples)
    flights.end()
    with phase("kept traces"):
        _keep_traces(runner, folder, wanted(results.totals), options.on_progress)
    return results


def _report(folder: RunFolder, results: RunAccumulator, spec: Spec, baselines: Mapping[str, Totals], options: RunOptions) -> None:
    """Writes the report of a run whose results are at hand."""
    with timed("report", options.on_progress), phase("report"):
        with phase("imports"):
            from rvjax import report  # plotting takes a second to import: the first chunk shall not wait for it

        run = report.assemble_run(folder, results, spec, baselines)
        report.write(folder, run, timings=(lambda: timings().document()) if options.timings else None)


def _next_look(flown: int) -> int:
    """Samples at the next look of a sequential test: a quarter more than `flown`, at least one chunk for each core."""
    chunks = flown // LANES
    return LANES * (chunks + max(cores(), chunks // 4))


def _check_resumable(folder: RunFolder, flown_by: Mapping[str, Any], spec: Spec) -> None:
    """UsageError where a folder cannot be extended to the campaign's samples, or its verdict would be a second look."""
    if PLAN in flown_by:
        _same_plan(folder, flown_by)
    if spec.samples <= folder.requested or folder.missing(math.ceil(folder.requested / LANES)):
        return
    requirements = (spec.require, campaign_of(folder).require)
    if all(any(not requirement.is_sequential for requirement in each) for each in requirements):
        raise UsageError(
            f"{folder.path}: judged at {folder.requested} samples, now {spec.samples} are asked for; a test with a fixed number "
            f"of samples allows no second look. Accepted: --samples {folder.requested}, method: sequential in "
            "require, or another folder with --out and another --seed"
        )


def _same_plan(folder: RunFolder, flown_by: Mapping[str, Any]) -> None:
    """UsageError where the folder's samples are a plan of another size."""
    old, new = (run_identity.get(PLAN, {}) for run_identity in (folder.identity, flown_by))
    if old and new and old["use"] == new["use"] and old["samples"] != new["samples"]:
        raise UsageError(
            f"{folder.path}: {old['samples']} samples of {old['use']}, now {new['samples']}: a plan cannot be extended or cut, "
            f"since another number of samples is another plan; accepted: --samples {old['samples']}, or another folder with --out"
        )


def _missing(folder: RunFolder) -> list[int]:
    """The chunks that a folder lacks."""
    return folder.missing(math.ceil(folder.requested / LANES), ENVELOPE_CHUNKS)


def _fly_and_fold(executor: Executor, folder: RunFolder, results: RunAccumulator, flights: PhaseProgress, samples: int) -> None:
    """Flies the chunks that the folder lacks and adds all chunks to the results. A damaged chunk is flown again. samples: of the
    whole campaign."""
    while (missing := _missing(folder)) or _unfolded(folder, results):
        if missing:
            _fly_missing(executor, folder, results, flights, samples)
        with phase("fold"):
            executor.fold(_unfolded(folder, results), results, flights.look)  # a damaged chunk is missing from then on


def _unfolded(folder: RunFolder, results: RunAccumulator) -> list[int]:
    """The finished chunks that the results do not have."""
    return [chunk for chunk in folder.chunks.number.tolist() if chunk not in results]


def _fly_missing(executor: Executor, folder: RunFolder, results: RunAccumulator, flights: PhaseProgress, samples: int) -> None:
    """Flies the missing chunks and commits each as it arrives. A chunk that no worker has added to totals is added here."""
    requested = folder.requested
    missing = _missing(folder)
    flights.begin(requested - sum(min(LANES, requested - chunk * LANES) for chunk in missing), max(requested, samples))

    def commit(arrived: Sequence[ChunkResult]) -> None:
        with phase("write"):
            folder.take_all(file for result in arrived for file in result.files)
        with phase("fold"):
            for table in folder.tables(result.chunk for result in arrived if result.segment is None):  # read back from the disk
                results.add(*table)
        for result in arrived:
            flights.count(result.samples)

    executor.fly(missing, commit, flights.look)


def _keep_traces(runner: ChunkRunner, folder: RunFolder, samples: Sequence[int], on_progress: OnProgress) -> None:
    """Flies samples again and keeps their thinned traces, instead of those kept before."""
    folder.quarantine_damaged(["traces"])
    kept = set(folder.trace_samples())
    folder.drop_traces(kept.difference(samples))
    new = [sample for sample in samples if sample not in kept]
    if not new:
        return
    steps = runner.problem.spec.horizon.steps
    every = steps_per_row(steps)
    progress = PhaseProgress("traces", on_progress, runner.steps_flown, steps, min(TRACED, len(new)))
    progress.begin(0, len(new))

    def fly_group(group: Sequence[int]) -> dict[int, Trace]:
        return dict(trace(runner.problem, runner.flyer, group, every, recorded(folder, group)))

    def write(traces: dict[int, Trace]) -> None:
        folder.write_traces(traces)
        progress.count(len(traces))

    groups = (new[first : first + TRACED] for first in range(0, len(new), TRACED))
    map_in_threads(fly_group, groups, write, runner.flyer.stop, progress.look)
    progress.end()
