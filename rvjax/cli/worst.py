"""`rvjax worst`: the draws with the smallest margin of a requirement."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rvjax.cli._app import Campaign, Engine, Json, Quiet, Seed, Sets, overrides
from rvjax.cli._output import Output
from rvjax.errors import UsageError

if TYPE_CHECKING:
    from rvjax.search.worst_case import Case, Worst


def command(
    file: Campaign,
    *,
    requirement: Annotated[int, typer.Option("--requirement", min=1, metavar="N", help="Which requirement, from 1.")] = 1,
    flights: Annotated[int, typer.Option("--flights", min=1, help="Largest number of flights.")] = 20_000,
    radius: Annotated[
        float | None,
        typer.Option(
            "--radius",
            min=0.1,
            metavar="SIGMA",
            help="Draws in a ball of this radius; default: a sample in a million is outside.",
        ),
    ] = None,
    box: Annotated[
        float | None,
        typer.Option("--box", min=0.1, max=8.0, metavar="SIGMA", help="Each draw within this bound; replaces the ball."),
    ] = None,
    vary: Annotated[
        list[str] | None, typer.Option("--vary", metavar="NAME", help="Only draws whose name starts so; repeatable.")
    ] = None,
    first: Annotated[bool, typer.Option("--first", help="Stop at the first flight that does not comply.")] = False,
    likeliest: Annotated[bool, typer.Option("--likeliest", help="After a failure, search the most probable failure.")] = False,
    search_seed: Annotated[int, typer.Option("--search-seed", min=0, help="Seed of the search.")] = 0,
    seed: Seed = None,
    sets: Sets = None,
    engine: Engine = None,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", help="Folder for the campaign that replays the worst draws.")
    ] = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Search the draws for the smallest margin of a requirement."""
    from rvjax.search import worst_case, worst_case_export

    output, values = Output(as_json, quiet), overrides(sets, None, seed, engine)
    if radius is not None and box is not None:
        raise UsageError("--radius and --box together; accepted: --radius or --box")
    search = worst_case.prepare(file, values, requirement, vary or ())
    place = out or Path("reports") / search.problem.spec.name / f"worst-{requirement}"
    worst_case_export.check(place, search)

    def on_progress(done: int, margin: float) -> None:
        output.note(f"{done} of {flights} flights, smallest margin {margin:.4g}")

    result = worst_case.worst(
        search,
        flights,
        search_seed,
        radius=radius,
        box=box,
        first_only=first,
        likeliest_too=likeliest,
        on_progress=on_progress,
    )
    campaign = worst_case_export.export(search, result, place, values)
    _show(result, campaign, output)
    return 1 if result.failing else 0


def _show(result: Worst, campaign: Path, output: Output) -> None:
    worst = result.worst
    fails = f"{result.failing} of them do not comply" if result.failing else "all of them comply"
    how = f"{worst.outcome.replace('_', ' ')}, |z| = {worst.distance:.3g}"
    output.text(f"{result.requirement}: smallest margin {worst.margin:.4g} ({how}) in {result.flights} flights; {fails}")
    nearest = result.likeliest
    if nearest is not None:
        output.text(f"nearest flight that does not comply: |z| = {nearest.distance:.3g}, margin {nearest.margin:.4g}")
    output.table(("draw farthest from its median", "value, SI", "sigma", "farther out"), _farthest(result))
    output.text(f"replay: rvjax run {campaign}")
    document = {"requirement": result.requirement, "flights": result.flights, "failing": result.failing}
    for name, flight in (("worst", worst), ("likeliest", nearest)):
        document[name] = None if flight is None else _document(flight)
    output.document({**document, "campaign": str(campaign), "exit_code": 1 if result.failing else 0})


def _farthest(result: Worst) -> list[tuple[str, ...]]:
    """A row for each of the twelve coordinates that lie farthest from their medians."""
    from scipy.special import ndtr

    from rvjax.campaign.draw_names import covers

    worst = result.worst
    rows: list[tuple[str, ...]] = []
    for k in sorted(range(len(result.coordinates)), key=lambda k: -abs(worst.z[k]))[:12]:
        name, variable = result.coordinates[k].name, result.coordinates[k].variable
        values = [f"{value:.6g}" for draw, value in worst.draws.items() if covers(variable, draw)]
        rows.append((name, ", ".join(values), f"{worst.z[k]:+.2f}", f"{100 * ndtr(-abs(worst.z[k])):.2g} %"))
    return rows


def _document(flight: Case) -> dict[str, object]:
    return {
        "margin": flight.margin,
        "distance": flight.distance,
        "outcome": flight.outcome,
        "draws": dict(flight.draws),
    }
