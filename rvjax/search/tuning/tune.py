"""Tuning: a campaign with a section `tune` becomes a folder with the search, the best campaign, and its confirmation.

    campaign ─space→ candidates ─races on common draws→ the best ─`run` on fresh draws→ tuned/, and the original campaign → own/

A search is a function of its campaign and its seeds. A stopped search resumes: what its folder holds is not flown again.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import rankdata

from rvjax.analysis.verdicts.folders import SEARCH
from rvjax.campaign import Source, Spec, validate
from rvjax.campaign.distribution_notation import did_you_mean
from rvjax.campaign.named_laws import LAWS
from rvjax.campaign.plain_values import describe
from rvjax.campaign.python_files import PythonFile
from rvjax.campaign.requirement import TRACED
from rvjax.campaign.tuning import Tuning
from rvjax.campaign.tuning_parameters import Log, is_free
from rvjax.columns import draw_column, metric_column
from rvjax.components.registry import component, members
from rvjax.components.samplers import sampling_design_of
from rvjax.components.search_methods.interface import Method, Task
from rvjax.errors import CampaignError, Finding, FolderError
from rvjax.execution import run
from rvjax.execution.audit import prove
from rvjax.execution.identity import identity, provenance, short, source_digest
from rvjax.execution.progress import OnProgress
from rvjax.execution.progress_display import shown
from rvjax.run_folder import CAMPAIGN, RunDescription, RunFolder, tuning_record
from rvjax.run_folder.manifest import NAME as MANIFEST
from rvjax.run_folder.refusals import leaves_no_folder
from rvjax.run_folder.tuning_record import Axis, Cost, Measured, Missed, Row, Searched, Sensitivity
from rvjax.search.tuning.candidate_flights import Flights
from rvjax.search.tuning.confirm import confirm
from rvjax.search.tuning.evaluation import OWN, Search
from rvjax.search.tuning.exports import best_campaign, candidates_table
from rvjax.search.tuning.gradients import Slopes
from rvjax.search.tuning.objective import Judge, Measure
from rvjax.search.tuning.space import Space
from rvjax.simulation import jax_config
from rvjax.simulation.batch import LANES, Flyer
from rvjax.simulation.cautions import cautions
from rvjax.simulation.problem import load
from rvjax.simulation.requirement_checks import counted
from rvjax.stats import explained
from rvjax.stats.sampling_design import Independent

SEED = 20181
"""Of permutations and bootstraps."""


def prepare(path: str | Path | Source, overrides: Sequence[str] = ()) -> tuple[Space, Tuning, Method[Any], Any]:
    """The space, the section, the method and its parameters. CampaignError with every finding."""
    space, tuning = Space.of(path, overrides)
    source, findings = space.problem.spec.source, []
    if not isinstance(basis := sampling_design_of(space.problem.spec), Independent):
        accepted = "accepted: sampler: {use: monte-carlo}, without which nothing is confirmed"
        findings.append(source.finding(("sampler",), basis.sentence, accepted))
    method, parameters = None, None
    known, use = members("searches"), tuning.method.use
    if use not in known and not isinstance(use, PythonFile):
        findings.append(source.finding(("tune", "method", "use"), f"{describe(use)} is not known here", did_you_mean(use, known)))
    else:
        method = component("searches", use)
        parameters, more = validate(method.parameters, dict(tuning.method.parameters), ("tune", "method"), source)
        findings += more
        for problem in method.problems(parameters, space.axes, tuning.budget.candidates) if parameters is not None else ():
            place = ("tune", "method", *problem.place)
            findings.append(source.finding(place, problem.message, problem.accepted, problem.at_key))
        if method.gradient:
            findings += Slopes.findings(space.problem, tuning)
        if tuning.goal == "pareto" and not method.several and len(tuning.objective) > 1:
            several = ", ".join(name for name in known if component("searches", name).several)
            accepted = f"accepted: {several}; or another goal"
            findings.append(
                source.finding(("tune", "method"), f"{use} follows a single objective, but the goal is pareto", accepted)
            )
    measures = [Measure.of(objective, _columns(space)) for objective in tuning.objective]
    for index, measure in enumerate(measures):
        if measure.needs_sense(_columns(space)):
            accepted = "accepted: sense: smallest, or sense: largest"
            findings.append(
                source.finding(
                    ("tune", "objective", index),
                    f"rvjax does not know whether {measure.objective.metric} should be small or large",
                    accepted,
                )
            )
    findings += _confirmable(path, overrides, space.problem.spec)
    if findings:
        raise CampaignError(dict.fromkeys(findings))
    assert method is not None, "or there are findings"
    return space, tuning, method, parameters


def _confirmable(path: str | Path | Source, overrides: Sequence[str], spec: Spec) -> list[Finding]:
    """What the campaign would say against the samples of the confirmation."""
    assert spec.tune is not None
    try:
        load(path, [*overrides, *_fresh_draws(spec)])
    except CampaignError as error:
        where = spec.source.where(("tune", "confirm", "samples"))
        return [replace(finding, where=where, path=f"tune.confirm.samples: {finding.path}") for finding in error.findings]
    return []


def _fresh_draws(spec: Spec) -> list[str]:
    """Overrides that turn a campaign into the campaign that confirms."""
    return [f"samples={_samples(spec)}", f"seed={_fresh(spec)}", "baselines=[]", "tune=null"]


def plan(spec: Spec) -> str:
    """What a tuning is going to do, in words."""
    tuning = spec.tune
    assert tuning is not None, "there is something to tune"
    free = sum(map(is_free, tuning.parameters.values()))
    budget = [f"{value:,.6g} {name}" for name, value in tuning.budget.model_dump().items() if value is not None]
    sizes = " → ".join(f"{size:,}" for size in tuning.rounds)
    return (
        f"{free} {'value' if free == 1 else 'values'} by {tuning.method.use}, {' or '.join(budget)}; races of {sizes} samples; "
        f"confirmed on {_samples(spec):,} fresh draws"
    )


def _columns(space: Space) -> Mapping[str, Any]:
    return {metric_column(name): column for name, column in space.problem.metric_columns.items()}


def tune(
    path: str | Path | Source,
    out: str | Path | None = None,
    overrides: Sequence[str] = (),
    *,
    on_message: Callable[[str], None] = lambda _: None,
    progress: bool | OnProgress = True,
    on_open: Callable[[Path], None] = lambda _: None,
    on_warnings: Callable[[Sequence[Finding]], None] = run.warn,
    command: Sequence[str] = (),
) -> tuple[Path, Searched]:
    """Searches the parameters of a campaign, confirms the winner on fresh draws and writes the report; returns the folder and
    the record of the search.

    on_message: called with a line for each batch. on_open: called with the folder before the first flight. progress: of the
    confirmation, as in `run`. on_warnings: called with what is hardly meant in the campaign; by default Python's warnings.

    Errors: CampaignError with every finding; FolderError where the folder is damaged or belongs to another search.
    """
    first, tuning, method, parameters = prepare(path, overrides)
    jax_config.configure(first.problem.spec.precision)
    on_warnings(cautions(first.problem))
    spec = first.problem.spec
    seed = spec.seed + 1 if tuning.seed is None else tuning.seed
    measures = [Measure.of(objective, _columns(first)) for objective in tuning.objective]
    judge = Judge(spec.require, measures, tuning.goal, _samples(spec))
    mine = _identity(first, tuning, seed)
    place = Path(out) if out is not None else Path("reports") / spec.name / f"tune-{short(mine)}"
    if not (place / MANIFEST).exists():
        confirmed = load(path, [*overrides, *_fresh_draws(spec)])
        prove(confirmed, Flyer.of(confirmed))
    with leaves_no_folder(place), _open(place, mine, spec, provenance(command, overrides)) as folder:
        on_open(place)
        done = _earlier(place)
        seeds = (f"seed={seed}", f"tune.seed={seed}", f"tune.confirm.seed={_fresh(spec)}")
        space = first.of_search(place / CAMPAIGN, *seeds)
        names = [*_columns(space), *(draw_column(name) for name in (*space.problem.dispersions.columns, *counted(spec)))]
        most = float("inf") if tuning.budget.flights is None else tuning.budget.flights
        flights = Flights(space, folder, judge.columns(names), most)
        slopes = Slopes(space, tuning, flights) if method.gradient else None
        stop_at = done.cost.lanes if done is not None and tuning.budget.minutes is not None else None
        search = Search(tuning, flights, judge, on_message, slopes, stop_at)
        task = Task(space.axes, seed, space.start, tuning.budget.candidates, judge.objectives)
        search.run(method.build(parameters), task)
        winner = search.winner()
        record = _record(space, spec, search, winner, seed)
        values = flights.candidates[record.best].values if record.best != OWN else {}
        folder.write_text(tuning_record.BEST, best_campaign(spec, space, values, overrides, met=winner is not None))
        folder.write_bytes(tuning_record.NAME, record.encode())
        folder.seal()  # from here on the search is over, whatever happens to the confirmation
        on_message(f"confirming on {_samples(spec)} fresh draws")
        with shown(progress) as on_progress:
            options = run.RunOptions(command=command, on_progress=on_progress)
            record = _confirmed(place, overrides, spec, search, record, options)
        folder.write_text(tuning_record.TABLE, candidates_table(record))
        folder.write_bytes(tuning_record.NAME, record.encode())
        from rvjax.report import tuning_report as report  # plotting takes a second to import

        report.write(folder, record)
    return place, record


def _open(place: Path, search_identity: Mapping[str, Any], spec: Spec, origin: Mapping[str, Any]) -> RunFolder:
    """The folder of a search, created or resumed. origin: the provenance."""
    before = RunFolder.open(place) if (place / MANIFEST).exists() else None
    description = RunDescription(
        identity=search_identity,
        provenance=origin,
        campaign_text=spec.source.text,
        samples=LANES if before is None else before.requested,
        name=spec.name,
        inputs=spec.source.inputs,
    )
    return RunFolder.create(place, description) if before is None else RunFolder.resume(place, description, LANES)


def _earlier(place: Path) -> Searched | None:
    """The record of an earlier search in the folder; None where there is none or it is damaged."""
    try:
        return tuning_record.read(place)
    except FolderError:
        return None


def _fresh(spec: Spec) -> int:
    """The seed of the confirmation."""
    assert spec.tune is not None
    return spec.seed if spec.tune.confirm.seed is None else spec.tune.confirm.seed


def _samples(spec: Spec) -> int:
    assert spec.tune is not None
    return spec.samples if spec.tune.confirm.samples is None else spec.tune.confirm.samples


def _identity(space: Space, tuning: Tuning, seed: int) -> dict[str, Any]:
    """Everything that decides the result of a search."""
    spec = space.problem.spec
    settings = tuning.model_dump(mode="json", exclude={"confirm", "parameters", "method"})
    settings["parameters"] = {name: repr(parameter) for name, parameter in tuning.parameters.items()}
    settings["method"] = {"use": tuning.method.use, **tuning.method.parameters}
    settings["require"] = [requirement.model_dump(mode="json", exclude=set(TRACED)) for requirement in spec.require]
    if spec.laws:
        settings[LAWS] = dict(spec.laws)
    settings["fresh"] = _samples(spec)  # decides which shares are needed
    if isinstance(tuning.method.use, PythonFile):
        settings["code"] = tuning.method.use.digests
    settings["packages"] = {name: version(name) for name in component("searches", tuning.method.use).packages}
    text = json.dumps(settings, sort_keys=True, default=repr)
    mine = identity(space.problem) | {"seed": seed}
    return mine | {
        SEARCH: hashlib.sha256(text.encode()).hexdigest(),
        "search": source_digest(("analysis", "components/search_methods", "search", "stats")),
    }


def _confirmed(
    place: Path, overrides: Sequence[str], spec: Spec, search: Search, record: Searched, options: run.RunOptions
) -> Searched:
    """Flies the winner and the original campaign on fresh draws and judges them. Returns the record with the confirmation."""
    tuning = search.tuning
    run.fly(place / tuning_record.BEST, place / tuning_record.TUNED, ["baselines=[]"], options)
    run.fly(place / CAMPAIGN, place / tuning_record.ORIGINAL, [*overrides, *_fresh_draws(spec)], options)
    table = search.table(record.best)
    seen = [*search.judge.values(table), search.judge.score(table).objectives[0]]
    from rvjax.analysis.verdicts import campaign_of

    original = campaign_of(RunFolder.open(place / tuning_record.ORIGINAL))
    confirmation = confirm(
        place / tuning_record.TUNED, place / tuning_record.ORIGINAL, original, search.judge, seen, tuning.confirm.confidence
    )
    return record.model_copy(update={"confirmation": confirmation})


def _record(space: Space, spec: Spec, search: Search, winner: int | None, seed: int) -> Searched:
    """winner: None where no candidate meets the requirements; then the original campaign is kept."""
    tuning, flights, judge = search.tuning, search.flights, search.judge
    rows: list[Row] = []
    sizes = tuning.rounds
    for number, standing in search.standings.items():
        candidate = flights.candidates[number]
        flown = standing.samples > 0
        table = search.table(number) if flown else None
        early = flights.table(number, np.arange(sizes[0], dtype=np.int64)) if flown else None
        rows.append(
            Row(
                candidate=number,
                batch=search.batch_of[number],
                u=[] if candidate.point is None else [float(u) for u in candidate.point],
                values=candidate.values,
                round=standing.round,
                samples=standing.samples,
                left=standing.left,
                violation=standing.score.violation,
                objectives=[] if table is None else list(judge.values(table)),
                score=list(standing.score.objectives),
                first=[] if early is None else list(judge.score(early).objectives),
            )
        )
    chosen = OWN if winner is None else winner
    best = flights.candidates[chosen].values
    missed: list[Missed] = []
    if winner is None:
        missed = judge.missed(search.table(search.best), _columns(space))
    return Searched(
        name=spec.name,
        description=spec.description,
        method=tuning.method.use,
        goal=tuning.goal,
        seed=seed,
        requirements=len(spec.require),
        parameters=[
            Axis(
                name=name,
                range=str(parameter),
                free=is_free(parameter),
                scale="log" if isinstance(parameter, Log) else "levels" if is_free(parameter) and parameter.levels else "linear",
                own=space.original.get(name),
                best=best.get(name),
            )
            for name, parameter in tuning.parameters.items()
        ],
        start=[] if space.start is None else [float(u) for u in space.start],
        objectives=[_measured(measure) for measure in judge.measures],
        rows=rows,
        best=chosen,
        front=search.front() if tuning.goal == "pareto" else [],
        closest=search.best if winner is None else None,
        missed=missed,
        sensitivity=_sensitivity(space, rows),
        cost=_cost(search),
        confirmation=None,
    )


def _measured(measure: Measure) -> Measured:
    objective = measure.objective
    large = measure.largest or objective.probability
    return Measured(text=str(measure), unit=measure.unit, largest=large, share=objective.probability, weight=objective.weight)


def _sensitivity(space: Space, rows: Sequence[Row]) -> list[Sensitivity]:
    """Of the ranks of the first objective after the first round, which all candidates have flown."""
    known = [row for row in rows if row.u and row.first]
    if len(known) < 8:
        return []
    y = rankdata([row.first[0] for row in known])
    generator = np.random.default_rng(SEED)
    shares: list[Sensitivity] = []
    for index, name in enumerate(space.free):
        part = explained([row.u[index] for row in known], y, rng=generator)
        interval = tuning_record.Interval(value=part.share.value, low=part.share.low, high=part.share.high)
        shares.append(Sensitivity(name=name, share=interval, p=part.p))
    return shares


def _cost(search: Search) -> Cost:
    flights, sizes = search.flights, search.tuning.rounds
    original = len(flights.samples(OWN))
    flew = [number for number, standing in search.standings.items() if number != OWN and standing.samples]
    return Cost(
        flights=flights.flights,
        own=original,
        full=len(flew) * sizes[-1],
        lanes=flights.lanes,
        programs=flights.programs,
        sizes=list(sizes),
        begun=[round_.begun for round_ in search.rounds],
        by_test=[round_.by_test for round_ in search.rounds],
        by_halving=[round_.by_halving for round_ in search.rounds],
    )
