"""Commands that search: tune, worst."""

from __future__ import annotations

import shlex
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rvjax.cli.app import Campaign, Json, Out, Quiet, Samples, Seed, Sets, Terminated, app, overrides
from rvjax.cli.output import Output, say
from rvjax.errors import IncompleteError

if TYPE_CHECKING:
    from rvjax.run_folder.tuning_record import Confirmed, Searched
    from rvjax.search.worst_case import Worst


@app.command()
def tune(
    file: Campaign,
    out: Out = None,
    samples: Samples = None,
    seed: Seed = None,
    sets: Sets = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Search better values of a campaign on common draws, and confirm them on fresh ones. Again on the same folder: resumes."""
    from rvjax.search.tuning.tune import tune as search

    output, given = Output(as_json, quiet), overrides(sets, samples, seed)
    began = time.monotonic()
    folder: list[Path] = []
    try:
        with output.progress() as progress:
            place, found = search(file, out, given, output.note, progress, sys.argv, folder.append)
    except (KeyboardInterrupt, Terminated, IncompleteError):
        if folder:
            again = ["rvjax", "tune", str(file), "--out", str(folder[0]), *(part for one in given for part in ("--set", one))]
            say(f"stopped; what was flown is kept in {folder[0]}. Go on with\n  {shlex.join(again)}", sys.stderr)
            output.document({"stopped": str(folder[0]), "go_on_with": again})
        raise
    output.note(f"done in {time.monotonic() - began:.0f} s")
    _show(place, found, output)
    return 0


def _show(place: Path, found: Searched, output: Output) -> None:
    from rvjax.report.tuning_sections.confirmation import headline, shown
    from rvjax.report.tuning_sections.values import said

    assert found.confirmation is not None, "a search ends with its confirmation"
    top = headline(found)
    output.text(f"{top.verdict.word}: {top.sentence}")
    rows = [
        (one.verdict, one.text, shown(one.tuned, one), shown(one.own, one), _interval(one), shown(one.optimism, one))
        for one in found.confirmation.objectives
    ]
    output.table(("verdict", "objective", "winner", "as it is", "difference", "optimism"), rows)
    if found.confirmation.requirements:
        kept = [
            (one.tuned, one.own, one.text, *("–" if n is None else f"{n}" for n in (one.only_tuned, one.only_own)))
            for one in found.confirmation.requirements
        ]
        output.table(("winner", "as it is", "requirement", "only winner", "only as it is"), kept)
    values = [(one.name, one.range, said(one.own), said(one.best if found.best else one.own)) for one in found.parameters]
    output.table(("value", "range", "as it is", "winner"), values)
    output.text(f"best campaign: {place / 'best.yaml'}", f"report: {place / 'report.html'}")
    output.document({"folder": str(place), **found.model_dump()})


def _interval(one: Confirmed) -> str:
    scale, unit = (100.0, " %") if one.share else (1.0, f" {one.unit}".rstrip(" 1"))
    return f"{scale * one.difference.value:+.4g} ({scale * one.difference.low:+.4g} … {scale * one.difference.high:+.4g}){unit}"


@app.command()
def worst(
    file: Campaign,
    requirement: Annotated[int, typer.Option("--requirement", min=1, metavar="N", help="Which requirement, from 1.")] = 1,
    flights: Annotated[int, typer.Option("--flights", min=1, help="Flights at most.")] = 20_000,
    radius: Annotated[
        float | None,
        typer.Option("--radius", min=0.1, help="Draws in a ball of so many sigma; default: one sample in a million is outside."),
    ] = None,
    box: Annotated[
        float | None, typer.Option("--box", min=0.1, max=8.0, metavar="SIGMA", help="Each draw within so many sigma, not a ball.")
    ] = None,
    vary: Annotated[
        list[str] | None, typer.Option("--vary", metavar="NAME", help="Only draws with this name or beginning; repeatable.")
    ] = None,
    first: Annotated[bool, typer.Option("--first", help="End with the first flight that does not comply.")] = False,
    likeliest: Annotated[
        bool, typer.Option("--likeliest", help="After a failure, look for the most probable one, not for the worst.")
    ] = False,
    search_seed: Annotated[int, typer.Option("--search-seed", min=0, help="Seed of the search.")] = 0,
    seed: Seed = None,
    sets: Sets = None,
    out: Annotated[Path | None, typer.Option("--out", metavar="DIR", help="Where to write the campaign that replays it.")] = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Search the draws for the smallest margin of a requirement; write what is found as a campaign that replays it."""
    from rvjax.search import worst_case as search

    output, given = Output(as_json, quiet), overrides(sets, None, seed)
    hunt = search.prepare(file, given, requirement, vary or ())

    def told(done: int, margin: float) -> None:
        output.note(f"{done} of {flights} flights, smallest margin {margin:.4g}")

    found = search.worst(hunt, flights, search_seed, radius, box, first, likeliest, told)
    place = out or Path("reports") / hunt.problem.spec.name / f"worst-{requirement}"
    campaign = search.export(hunt, found, place, given)
    _show_worst(found, campaign, output)
    return 1 if found.failing else 0


def _show_worst(found: Worst, campaign: Path, output: Output) -> None:
    from scipy.special import ndtr

    from rvjax.campaign.draw_names import covers

    one = found.worst
    fails = f"{found.failing} of them do not comply" if found.failing else "all of them comply"
    how = f"{one.outcome.replace('_', ' ')}, |z| = {one.distance:.3g}"
    output.text(f"{found.requirement}: smallest margin {one.margin:.4g} ({how}) in {found.flights} flights; {fails}")
    if found.likeliest is not None:
        output.text(
            f"nearest flight that does not comply: |z| = {found.likeliest.distance:.3g}, margin {found.likeliest.margin:.4g}"
        )
    order = sorted(range(len(found.coordinates)), key=lambda k: -abs(one.z[k]))[:12]
    rows = []
    for k in order:
        name, variable = found.coordinates[k].name, found.coordinates[k].variable
        values = [f"{value:.6g}" for draw, value in one.draws.items() if covers(variable, draw)]
        rows.append((name, ", ".join(values), f"{one.z[k]:+.2f}", f"{100 * ndtr(-abs(one.z[k])):.2g} %"))
    output.table(("draw that is farthest out", "value, SI", "sigma", "farther out"), rows)
    output.text(f"replay: rvjax run {campaign}")
    cases = {"worst": one, "likeliest": found.likeliest}
    told = {
        name: None
        if case is None
        else {
            "margin": case.margin,
            "distance": case.distance,
            "outcome": case.outcome,
            "draws": dict(case.draws),
        }
        for name, case in cases.items()
    }
    output.document(
        {
            "requirement": found.requirement,
            "flights": found.flights,
            "failing": found.failing,
            **told,
            "campaign": str(campaign),
            "exit_code": 1 if found.failing else 0,
        }
    )
