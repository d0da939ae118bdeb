"""Command that compares: compare."""

from __future__ import annotations

import shlex
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rvjax.cli.app import Folder, Json, app
from rvjax.cli.output import Output
from rvjax.errors import UsageError

if TYPE_CHECKING:
    from rvjax.analysis.compare import Comparison
    from rvjax.stats import Estimate


@app.command()
def compare(
    folder: Folder,
    other: Annotated[Path | None, typer.Argument(metavar="[DIR]", help="Run folder B, the change; the first one is A.")] = None,
    baseline: Annotated[
        str | None, typer.Option("--baseline", metavar="NAME", help="Compare the run (B) with its own baseline (A).")
    ] = None,
    margin: Annotated[float, typer.Option("--margin", help="How much smaller a share of B may be; 0: is B better?")] = 0.0,
    confidence: Annotated[float, typer.Option("--confidence", help="Of the verdicts and intervals.")] = 0.95,
    metrics: Annotated[list[str] | None, typer.Option("--metric", metavar="NAME:Q", help="Another quantile; repeatable.")] = None,
    common: Annotated[bool, typer.Option("--common", help="Folders of different size: the samples that both have.")] = False,
    shown: Annotated[int, typer.Option("--show", min=0, help="Samples that tell them apart, at most so many.")] = 10,
    as_json: Json = False,
) -> int:
    """Compare two run folders on the same draws, sample by sample: what is better, what is worse, and where."""
    from rvjax.analysis.compare import compare as compared
    from rvjax.analysis.compare import sides

    output = Output(as_json)
    found = compared(
        *sides(folder, other, baseline),
        margin=margin,
        confidence=confidence,
        quantiles=[_quantile(one) for one in metrics or []],
        common=common,
        shown=shown,
    )
    _show(found, output)
    words = {change.verdict for change in found.changes}
    code = 1 if "FAIL" in words else 3 if "UNDECIDED" in words else 0
    output.document({**asdict(found), "a": str(found.a), "b": str(found.b), "exit_code": code})
    return code


def _quantile(text: str) -> tuple[str, float]:
    name, _, q = text.rpartition(":")
    try:
        return name, float(q)
    except ValueError:
        raise UsageError(f"--metric {text}; accepted: a metric and a quantile, as delta_v_m_s:0.95") from None


def _show(found: Comparison, output: Output) -> None:
    from rvjax.analysis.compare import p_value

    output.text(f"A: {found.a}", f"B: {found.b}", f"{found.n:,} samples on the same draws; every difference is B − A")
    if found.differing:
        output.text("", "The campaigns differ in", *(f"  {line}" for line in found.differing))
    for side, names in (("A", found.only_a), ("B", found.only_b)):
        if names:
            output.text(f"drawn in {side} only: {', '.join(names)}")
    output.text("")
    names = [f"{number}. {change.name}" for number, change in enumerate(found.changes, 1)]
    shares = [
        (
            name,
            f"{100 * change.share_a:.2f}\u00a0%",
            f"{100 * change.share_b:.2f}\u00a0%",
            f"{change.pairs.only_a:,}",
            f"{change.pairs.only_b:,}",
        )
        for name, change in zip(names, found.changes, strict=True)
    ]
    output.table(("complies", "A", "B", "A only", "B only"), shares)
    tests = [
        (f"{number}.", _interval(one.difference, 100.0), *map(p_value, (one.p_exact, one.p_mid, one.p_holm)))
        for number, one in enumerate(found.changes, 1)
    ]
    output.table(("", "difference, percentage points", "p, exact", "mid-p", "p, Holm"), tests)
    output.table(
        ("verdict", "on"),
        [(one.verdict, f"{name}: {one.text.partition(': ')[2]}") for name, one in zip(names, found.changes, strict=True)],
    )
    if found.shifts:
        shifts = [
            (f"{one.metric}, {100 * one.q:g} %", f"{one.a:.4g}", f"{one.b:.4g}", _interval(one.shift), one.unit, one.word or "–")
            for one in found.shifts
        ]
        output.table(("quantile", "A", "B", "shift", "unit", "by itself"), shifts)
    if found.apart:
        _discordant(found, output)


def _discordant(found: Comparison, output: Output) -> None:
    """The samples that tell A and B apart, and how to fly them again."""
    rows = [
        (str(one.sample), one.outcome_a.replace("_", " "), one.outcome_b.replace("_", " "), "; ".join(one.lost) or "–")
        for one in found.discordant
    ]
    output.text(f"{found.apart:,} samples tell them apart, these first:")
    output.table(("sample", "A", "B", "complies in A only"), rows)
    if found.discordant:
        sample = found.discordant[0].sample
        for path in (found.a, found.b):
            output.text(f"rvjax replay {shlex.quote(str(path))} --sample {sample}")


def _interval(estimate: Estimate, scale: float = 1.0) -> str:
    """−0.12 [−0.2, +0.01]."""
    value, low, high = (f"{scale * x:+.3g}".replace("-", "−") for x in (estimate.value, estimate.low, estimate.high))
    return f"{value} [{low}, {high}]"
