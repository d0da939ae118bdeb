"""`rvjax drivers`: which draws matter, from a run that is there."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rvjax.cli._app import Folder, Json, Quiet
from rvjax.cli._output import Output

if TYPE_CHECKING:
    from rvjax.analysis.drivers import Driver, Drivers, Result
    from rvjax.analysis.drivers_of_folder import Sample
    from rvjax.stats.reweighting import Class
    from rvjax.stats.sampling_design import SamplingDesign


def command(
    folder: Folder,
    *,
    results: Annotated[
        list[str] | None,
        typer.Option("--result", metavar="NAME", help="A metric, or `failures`; repeatable. Default: failures and every metric."),
    ] = None,
    draw: Annotated[
        list[str] | None, typer.Option("--draw", metavar="NAME", help="Only draws whose name starts so; repeatable.")
    ] = None,
    samples: Annotated[int, typer.Option("--samples", min=30, help="Largest number of samples that are read.")] = 20_000,
    shown: Annotated[int, typer.Option("--show", min=1, metavar="N", help="Draws shown for each result, up to N.")] = 5,
    classes: Annotated[int, typer.Option("--classes", min=2, max=50, help="Classes of a draw with a failure share each.")] = 5,
    confidence: Annotated[float, typer.Option("--confidence", min=0.5, max=0.9999, help="Of tests and intervals.")] = 0.95,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Show which draws matter, from a run that is there."""
    from rvjax.analysis import drivers as analysis
    from rvjax.analysis.drivers_of_folder import opened

    output = Output(as_json, quiet)
    sample = opened(folder, results or (), draw or (), samples)
    output.note(f"{len(sample.drawn)} draws with {len(sample.results)} results")
    found = analysis.drivers(sample.drawn, sample.results, sample.design, confidence)
    output.text(_head(found, sample.design, sample.requested))
    for result in sample.results:
        _show(found, result, shown, output)
    tables = _classes(found, sample, classes, shown, bool(draw))
    for result, draw_name, parts in tables:
        _show_classes(result, draw_name, parts, sample.units.get(draw_name, ""), output)
    output.document(
        {
            "folder": str(folder),
            "samples": found.n,
            "draws": list(found.draws),
            "confidence": confidence,
            "pairs": [asdict(pair) for pair in found.pairs],
            "failing": [
                {"result": result, "draw": name, "classes": [_plain(part) for part in parts]} for result, name, parts in tables
            ],
        }
    )
    return 0


def _head(found: Drivers, design: SamplingDesign, requested: int) -> str:
    from rvjax.stats.sampling_design import Exploration

    of = f"the first {found.n:,} of {requested:,}" if found.n < requested else f"{found.n:,}"
    tests, draws = len(found.pairs), f"{len(found.draws)} draw{'s that vary' if len(found.draws) != 1 else ' that varies'}"
    if isinstance(design, Exploration):
        return f"{draws}, {of} samples; {design.sentence}: no p-values and no intervals"
    return (
        f"{draws}, {of} samples; p: Holm's for all {tests:,} pairs of a draw and a result, "
        f"clear at {100 * found.confidence:g} % confidence"
    )


def _show(found: Drivers, result: Result, shown: int, output: Output) -> None:
    pairs, clear = found.of(result.name), found.clear(result.name)
    if not pairs:
        output.text(f"{result.name}: the same in every flight")
        return
    tested = pairs[0].p is not None
    words = f"{len(clear)} of {len(pairs)} draws matter clearly" if tested else "no test"
    left_out = f"; {100 * pairs[0].left_out:.2g} % of the flights have no finite value, and are left out of S"
    output.text(f"{result.name}: {words}{left_out if pairs[0].left_out else ''}")
    rows = (clear or pairs)[:shown] if tested else pairs[:shown]
    output.table(("draw", "xi", "p, Holm", "S, first order"), [_row(pair) for pair in rows])
    if any(pair.share is None for pair in rows):
        output.text("S: not shown where a few flights decide it")


def _row(pair: Driver) -> tuple[str, ...]:
    from rvjax.analysis.comparison_sentences import p_value
    from rvjax.stats import Estimate

    share = pair.share
    if share is None:
        text = "–"
    elif isinstance(share, Estimate):
        text = f"{share.value:.3f} [{share.low:.3f}, {share.high:.3f}]"
    else:
        text = f"{share.value:.3f}"
    return pair.draw, f"{pair.xi:+.3f}", "–" if pair.p_holm is None else p_value(pair.p_holm), text.replace("-", "−")


def _classes(found: Drivers, sample: Sample, classes: int, shown: int, every: bool) -> list[tuple[str, str, list[Class]]]:
    """The shares of failures by class of the draws that matter most for each failure; every: of all draws, which were chosen."""
    from rvjax.analysis.drivers import failing_classes

    tables: list[tuple[str, str, list[Class]]] = []
    for result in sample.results:
        if result.failure:
            pairs = found.of(result.name)
            for pair in (pairs if every else found.clear(result.name) or pairs[:1])[:shown]:
                parts = failing_classes(sample.drawn[pair.draw], result.values, sample.design, found.confidence, classes)
                tables.append((result.name, pair.draw, parts))
    return tables


def _show_classes(result: str, draw: str, parts: list[Class], unit: str, output: Output) -> None:
    output.text(f"{result}, by {draw}" + (f" [{unit}]" if unit not in ("", "1") else ""))
    rows = [
        (
            f"{part.low:.4g} … {part.high:.4g}".replace("-", "−"),
            f"{part.share.n:,}",
            f"{100 * part.share.value:.2f} %",
            f"{100 * part.share.low:.2f} … {100 * part.share.high:.2f} %",
        )
        for part in parts
    ]
    output.table(("class of the draw", "flights", "share", "interval"), rows)


def _plain(part: Class) -> dict[str, Any]:
    return {"low": part.low, "high": part.high, "share": asdict(part.share)}
