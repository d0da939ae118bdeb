"""`rvjax compare`: two runs on the same draws."""

from __future__ import annotations

import shlex
from dataclasses import asdict
from decimal import ROUND_CEILING, ROUND_FLOOR, Decimal
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rvjax.analysis.percentages import chosen, rounded
from rvjax.cli import _completion
from rvjax.cli._app import Folder, Json
from rvjax.cli._output import Output
from rvjax.errors import UsageError

if TYPE_CHECKING:
    from rvjax.analysis.compare import Comparison
    from rvjax.stats import Estimate


def command(
    folder: Folder,
    other: Annotated[
        Path | None,
        typer.Argument(metavar="DIR", help="Run folder B, the change; the first is A.", autocompletion=_completion.run_folders),
    ] = None,
    *,
    baseline: Annotated[
        str | None,
        typer.Option(
            "--baseline",
            metavar="NAME",
            help="Compare the run (B) with a baseline inside it (A).",
            autocompletion=_completion.baselines,
        ),
    ] = None,
    margin: Annotated[float, typer.Option("--margin", help="Accepted loss of a share from A to B; 0: is B better?")] = 0.0,
    confidence: Annotated[float, typer.Option("--confidence", help="Confidence of the verdicts and intervals.")] = 0.95,
    metrics: Annotated[
        list[str] | None, typer.Option("--metric", metavar="NAME:Q", help="A further quantile to compare; repeatable.")
    ] = None,
    common: Annotated[bool, typer.Option("--common", help="With folders of different sizes: use the samples of both.")] = False,
    shown: Annotated[int, typer.Option("--show", min=0, metavar="N", help="Samples needed to tell A from B, up to N.")] = 10,
    as_json: Json = False,
) -> int:
    """Compare two runs on the same draws, sample by sample."""
    from rvjax.analysis.compare import compare, sides
    from rvjax.analysis.verdicts import exit_code_of

    output = Output(as_json)
    result = compare(
        *sides(folder, other, baseline),
        margin=margin,
        confidence=confidence,
        quantiles=[_quantile(text) for text in metrics or []],
        common=common,
        shown=shown,
    )
    _show(result, output)
    code = exit_code_of(change.verdict for change in result.changes)
    output.document({**asdict(result), "a": str(result.a), "b": str(result.b), "exit_code": code})
    return code


def _quantile(text: str) -> tuple[str, float]:
    name, _, q = text.rpartition(":")
    try:
        return name, float(q)
    except ValueError:
        raise UsageError(f"--metric {text}; accepted: a metric and a quantile, as delta_v_m_s:0.95") from None


def _show(result: Comparison, output: Output) -> None:
    from rvjax.analysis.comparison_sentences import p_value

    output.text(f"A: {result.a}", f"B: {result.b}", f"{result.n:,} samples on the same draws; every difference is B − A")
    if result.differing:
        output.text("", "The runs differ in", *(f"  {line}" for line in result.differing))
    for side, names in (("A", result.only_a), ("B", result.only_b)):
        if names:
            output.text(f"drawn in {side} only: {', '.join(names)}")
    output.text("")
    names = [f"{number}. {change.name}" for number, change in enumerate(result.changes, 1)]
    shares = [
        (
            name,
            _share(change.share_a),
            _share(change.share_b),
            f"{change.pairs.only_a:,}",
            f"{change.pairs.only_b:,}",
        )
        for name, change in zip(names, result.changes, strict=True)
    ]
    output.table(("complies", "A", "B", "A only", "B only"), shares)
    tests = [
        (f"{number}.", _points(change.difference), *map(p_value, (change.p_exact, change.p_mid, change.p_holm)))
        for number, change in enumerate(result.changes, 1)
    ]
    output.table(("", "difference, percentage points", "p, exact", "mid-p", "p, Holm"), tests)
    output.table(
        ("verdict", "on"),
        [
            (change.verdict, f"{name}: {change.text.partition(': ')[2]}")
            for name, change in zip(names, result.changes, strict=True)
        ],
    )
    if result.shifts:
        shifts = [
            (
                f"{shift.metric}, {chosen(shift.q)} %",
                f"{shift.a:.4g}",
                f"{shift.b:.4g}",
                _interval(shift.shift),
                shift.unit,
                shift.word or "–",
            )
            for shift in result.shifts
        ]
        output.table(("quantile", "A", "B", "shift", "unit", "by itself"), shifts)
    if result.apart:
        _discordant(result, output)


def _discordant(result: Comparison, output: Output) -> None:
    """The samples that tell A from B, and the commands that replay the first."""
    rows = [
        (str(row.sample), row.outcome_a.replace("_", " "), row.outcome_b.replace("_", " "), "; ".join(row.lost) or "–")
        for row in result.discordant
    ]
    output.text(f"{result.apart:,} samples tell A from B; the first are:")
    output.table(("sample", "A", "B", "complies in A only"), rows)
    if result.discordant:
        sample = result.discordant[0].sample
        for path in (result.a, result.b):
            output.text(f"rvjax replay {shlex.quote(str(path))} --sample {sample}")


def _share(share: float) -> str:
    """A share in percent to two decimals, and to more where it would read as 0 or 100."""
    return f"{rounded(Decimal(f'{100 * share:.14g}'), 2):f}\u00a0%"


def _points(difference: Estimate) -> str:
    """A difference of shares in percentage points with its interval, rounded outwards."""
    from rvjax.analysis.comparison_sentences import points

    low, high = points(difference.low, ROUND_FLOOR), points(difference.high, ROUND_CEILING)
    return f"{points(difference.value)} [{low}, {high}]"


def _interval(estimate: Estimate) -> str:
    """−0.12 [−0.2, +0.01]."""
    value, low, high = (f"{x:+.3g}".replace("-", "−") for x in (estimate.value, estimate.low, estimate.high))
    return f"{value} [{low}, {high}]"
