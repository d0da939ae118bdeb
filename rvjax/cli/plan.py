"""`rvjax plan`: the number of samples."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rvjax.analysis.percentages import chosen
from rvjax.cli import _completion
from rvjax.cli._app import Json
from rvjax.cli._output import Output
from rvjax.errors import UsageError

if TYPE_CHECKING:
    from rvjax.analysis.sample_size import Running


def command(
    file: Annotated[
        Path | None,
        typer.Argument(
            metavar="FILE", help="A campaign file, for each of its requirements.", autocompletion=_completion.campaigns
        ),
    ] = None,
    *,
    at_least: Annotated[float | None, typer.Option("--at-least", help="Share of good samples that is required.")] = None,
    at_most: Annotated[float | None, typer.Option("--at-most", help="Share of bad samples that is allowed.")] = None,
    confidence: Annotated[float, typer.Option("--confidence", help="Of the verdict.")] = 0.95,
    true: Annotated[list[float] | None, typer.Option("--true", help="The same share, as it may truly be; repeatable.")] = None,
    power: Annotated[float, typer.Option("--power", help="Required chance to pass at the first --true.")] = 0.9,
    expected: Annotated[float | None, typer.Option("--expected", help="Also an SPRT against this better share.")] = None,
    as_json: Json = False,
) -> int:
    """Compute the samples that a requirement needs."""
    output = Output(as_json)
    if [file, at_least, at_most].count(None) != 2:
        raise UsageError("plan: accepted: a campaign FILE, or --at-least SHARE, or --at-most SHARE")
    if file is not None:
        return _of_campaign(file, true or [], output)
    from rvjax.analysis.sample_size import plan as plan_of

    bad = at_most is not None
    sizes = plan_of(at_most if bad else at_least or 0.0, confidence, true or [], power, expected=expected, bad=bad)
    trues = [f"{chosen(share)} %" for share in sizes.trues]
    required = f"at {'most' if bad else 'least'} {chosen(sizes.limit)} %"
    output.text(f"{required} with {chosen(sizes.confidence)} % confidence, judged once:")
    rows = [(str(size.failures), f"{size.n:,}", *(_percent(chance.passes) for chance in size.chances)) for size in sizes.fixed]
    output.table(("failures", "samples", *(f"pass at {share}" for share in trues)), rows)
    goal = f"{chosen(sizes.power)} % at a true share of {trues[0]}"
    if sizes.enough is not None:
        best = sizes.enough
        output.text(f"for {goal}: {best.n:,} samples, of which {best.failures} may fail ({_percent(best.chances[0].passes)})")
    else:
        output.text(f"no plan reaches {goal}")
    output.text(f"judged after every chunk of {sizes.running[0].every} samples, up to {sizes.running[0].budget:,}:")
    _running(sizes.running, output)
    output.document(asdict(sizes))
    return 0


def _of_campaign(file: Path, trues: list[float], output: Output) -> int:
    """Every requirement of a campaign with its method and samples; time and memory."""
    from rvjax.analysis.sample_size import of_requirement
    from rvjax.analysis.verdicts.sentences import title
    from rvjax.simulation.batch import LANES
    from rvjax.simulation.cost import cost
    from rvjax.simulation.problem import load

    problem = load(file)
    expected = cost(problem)
    output.text(f"{file}: {expected}")
    document: dict[str, object] = {"cost": vars(expected)}
    for number, requirement in enumerate(problem.spec.require, 1):
        name = f"{number}. {title(requirement)}"
        try:
            share = problem.laws[requirement.under].share_kept if requirement.under else 1.0
            samples, every = (max(1, round(number * share)) for number in (problem.spec.samples, LANES))
            sizes = of_requirement(requirement, samples, trues, every)
        except UsageError as error:
            output.text(str(error))
            continue
        output.text(f"{name}, {chosen(requirement.confidence)} % confidence")
        _running(sizes, output)
        document[name] = [asdict(size) for size in sizes]
    output.document(document)
    return 0


def _running(tests: Sequence[Running], output: Output) -> None:
    head = ("method", "true share", "PASS", "FAIL", "UNDECIDED", "samples, mean")
    rows = [
        (
            test.method,
            f"{chosen(test.true)} %",
            *map(_percent, (test.passes, test.fails, test.undecided)),
            f"{test.samples:,.0f}",
        )
        for test in tests
    ]
    output.table(head, rows)


def _percent(share: float) -> str:
    """A probability such as 98.3 %; near 0 or 1 its distance from there."""
    if share <= 0.0 or 1e-4 <= share <= 0.9999:
        return f"{100 * share:.1f} %" if share else "0 %"
    return f"{share:.0e}" if share < 0.5 else f"1 − {1 - share:.0e}" if share < 1.0 else "100 %"
