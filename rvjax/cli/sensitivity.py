"""`rvjax sensitivity`: which groups of draws matter, by flights of their own."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated

import typer

from rvjax.cli._app import Campaign, Engine, Json, Quiet, Seed, Sets, overrides
from rvjax.cli._output import Output
from rvjax.errors import UsageError

if TYPE_CHECKING:
    from rvjax.search.sensitivity import Sensitivity
    from rvjax.stats import Estimate


def command(
    file: Campaign,
    *,
    rows: Annotated[int, typer.Option("--rows", min=30, help="Rows: each flies 2 + the number of groups.")] = 832,
    group: Annotated[
        list[str] | None,
        typer.Option("--group", metavar="NAME=DRAW,…", help="A group of draws whose names start so; repeatable."),
    ] = None,
    results: Annotated[
        list[str] | None, typer.Option("--result", metavar="NAME", help="A metric, beside the failures; repeatable.")
    ] = None,
    confidence: Annotated[float, typer.Option("--confidence", min=0.5, max=0.9999, help="Of the intervals.")] = 0.95,
    seed: Seed = None,
    sets: Sets = None,
    engine: Engine = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Show which groups of draws matter, by flights of their own."""
    from rvjax.search import sensitivity

    output = Output(as_json, quiet)
    flights = sensitivity.prepare(file, overrides(sets, None, seed, engine), _groups(group or []))
    total = rows * (len(flights.groups) + 2)
    output.note(f"{len(flights.groups)} groups, {rows:,} rows, {total:,} flights")
    found = sensitivity.sensitivity(
        flights, rows, results or (), confidence, lambda done: output.note(f"{done:,} of {total:,} flights")
    )
    _show(found, confidence, output)
    output.document(
        {
            "campaign": str(file),
            "rows": found.rows,
            "flights": found.flights,
            "groups": {name: list(streams) for name, streams in found.groups.items()},
            "results": [
                {"name": result.name, "kind": result.kind, "groups": {name: asdict(part) for name, part in result.groups.items()}}
                for result in found.results
            ],
            "constant": list(found.constant),
            "changed_no_bit": dict(found.unchanged),
            "times_s": found.times_s.tolist(),
            "over_time": {
                signal: {
                    name: {
                        "first": part.first,
                        "total": part.total,
                        "first_of": part.first_of.tolist(),
                        "total_of": part.total_of.tolist(),
                    }
                    for name, part in curves.items()
                }
                for signal, curves in found.curves.items()
            },
        }
    )
    return 0


def _groups(given: list[str]) -> dict[str, list[str]]:
    groups: dict[str, list[str]] = {}
    for text in given:
        name, equals, draws = text.partition("=")
        if not name or not equals or not draws or name in groups:
            raise UsageError(f"--group {text}; accepted: NAME=DRAW,DRAW with a name of its own, as masses=pursuer.mass_kg")
        groups[name] = draws.split(",")
    return groups


def _show(found: Sensitivity, confidence: float, output: Output) -> None:
    output.text(f"{found.flights:,} flights; intervals at {100 * confidence:g} % hold for all groups of a table together")
    for result in found.results:
        parts = result.groups
        left_out = max((part.left_out for part in parts.values()), default=0.0)
        lost = f"; up to {100 * left_out:.2g} % of the rows, with a flight without a finite value, are left out"
        words = lost if left_out else ""
        output.text(f"{result.name}, {result.kind}{words}")
        ordered = sorted(parts, key=lambda name: -parts[name].total.value)
        rows = [(name, _text(parts[name].first), _text(parts[name].total), _bracket(parts[name])) for name in ordered]
        output.table(("group", "S, alone", "T, with all others", "Shapley's effect"), rows)
        if unchecked := [name for name in ordered if not parts[name].checked]:
            output.text(f"the bootstrap disagrees with the delta method, the wider counts: {', '.join(unchecked)}")
    if found.constant:
        output.text(f"the same in every flight: {', '.join(found.constant)}")
    for name, share in found.unchanged.items():
        if share is not None:
            output.text(
                f"{name} changed no bit of {found.rows:,} flights, so it matters in at most {100 * share:.2g} % of them "
                f"({100 * confidence:g} % confidence)"
            )
    for signal, curves in found.curves.items():
        ordered = sorted(curves, key=lambda name: -curves[name].total)
        output.text(f"{signal} over the whole flight")
        output.table(("group", "S", "T"), [(name, f"{curves[name].first:.3f}", f"{curves[name].total:.3f}") for name in ordered])


def _text(estimate: Estimate) -> str:
    if estimate.n < 4:
        return "–"
    return f"{estimate.value:.3f} [{estimate.low:.3f}, {estimate.high:.3f}]".replace("-", "−")


def _bracket(part: object) -> str:
    low, high = getattr(part, "low", 0.0), getattr(part, "high", 1.0)
    return f"{low:.3f} … {max(low, high):.3f}" if low > float("-inf") else "–"
