"""Commands that measure and plan: bench, plan."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rvjax.cli.app import Json, Quiet, app
from rvjax.cli.output import Output, say
from rvjax.errors import UsageError

if TYPE_CHECKING:
    from rvjax.analysis.sample_size import Running
    from rvjax.execution.bench import Bench


@app.command()
def bench(
    file: Annotated[Path | None, typer.Argument(metavar="[FILE]", help="A campaign file; default the starter campaign.")] = None,
    rounds: Annotated[int, typer.Option("--rounds", min=1, help="Flights of every way, in turn.")] = 3,
    yardsticks: Annotated[
        Path | None,
        typer.Option(
            "--yardsticks", metavar="DIR", help="`benchmarks` of a clone; its code is run. Default: that beside the package."
        ),
    ] = None,
    growth: Annotated[bool, typer.Option(help="Time and memory from 10³ to 10⁶ samples as well.")] = True,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Measure the speed on this machine against other ways to fly the same samples, in one run; a few minutes."""
    from rvjax.execution.bench import measure

    output = Output(as_json, quiet)
    found = measure(file, rounds, yardsticks, growth, output.note)
    output.document(asdict(found))
    _show(found, output)
    strangers = [way for way, agree in found.agree.items() if not agree]
    if strangers:
        say(f"rvjax: not the same results: {', '.join(strangers)}", sys.stderr)
    return 1 if strangers else 0


def _show(found: Bench, output: Output) -> None:
    from rvjax.execution.bench.workload import OWN

    case, machine = found.case, found.machine
    output.text(
        f"{case['samples']} samples of {case['campaign']}, {case['steps']} steps; median of {case['rounds']} rounds; "
        f"{machine['device']}, {machine['cores']} cores, {machine['processor']}, jaxlib {machine['jaxlib']}"
    )
    rows = [
        (
            way,
            f"{found.steps_per_s[way] / 1e6:.2f}",
            f"{found.samples_per_s[way]:,.0f}",
            f"{found.ratio[way]:.2f}",
            f"{found.apart[way]:.0e}{'' if found.agree[way] else ' (!)'}",
            f"{found.compile_s[way]:.1f}",
        )
        for way in found.steps_per_s
    ]
    output.table(("way", "M steps/s", "samples/s", "rvjax ×", "differs", "compile s"), rows)
    output.text("rvjax ×: how many times as fast rvjax is. differs: where flights end, relative to the largest error.")
    for way, why in found.unavailable.items():
        output.text(f"{way}: not measured, {why}")
    if not found.unavailable and not set(found.steps_per_s).difference(OWN):
        output.text("no yardsticks: they are in `benchmarks` of a clone, `--yardsticks DIR` says where")
    output.text(
        f"first chunk after {found.cold_s:.1f} s cold, {found.warm_s:.1f} s warm; peak memory {found.peak_memory_mb:.0f} MB"
    )
    if found.growth:
        grown = [
            (f"{row['samples']:,}", f"{row['steps_per_s'] / 1e6:.3g} M", f"{row['peak_memory_mb']:.0f} MB")
            for row in found.growth
        ]
        output.table(("samples", "steps/s, draws included", "peak memory"), grown)


@app.command()
def plan(
    file: Annotated[Path | None, typer.Argument(metavar="[FILE]", help="A campaign file, for each of its requirements.")] = None,
    at_least: Annotated[float | None, typer.Option("--at-least", help="Share of the samples that is required.")] = None,
    confidence: Annotated[float, typer.Option("--confidence", help="Of the verdict.")] = 0.95,
    true: Annotated[list[float] | None, typer.Option("--true", help="Share that may be true; repeatable.")] = None,
    power: Annotated[float, typer.Option("--power", help="Wanted chance to pass at the first --true.")] = 0.9,
    expected: Annotated[float | None, typer.Option("--expected", help="Also SPRT against this better share.")] = None,
    as_json: Json = False,
) -> int:
    """How many samples a requirement needs, and its chance to pass; with FILE also time and memory on this machine."""
    output = Output(as_json)
    if (file is None) == (at_least is None):
        raise UsageError("plan: accepted: a campaign FILE, or --at-least SHARE")
    if file is not None:
        return _of_campaign(file, true or [], output)
    from rvjax.analysis.sample_size import plan as plan_of

    found = plan_of(at_least or 0.0, confidence, true or [], power, expected)
    shares = [f"pass at {100 * p:.6g} %" for p in found.trues]
    output.text(f"at least {100 * found.limit:.6g} % with {100 * found.confidence:.6g} % confidence, judged once:")
    rows = [(str(one.failures), f"{one.n:,}", *(_percent(chance.passes) for chance in one.chances)) for one in found.fixed]
    output.table(("failures", "samples", *shares), rows)
    if found.enough is not None:
        best = found.enough
        output.text(
            f"for {100 * found.power:.6g} % at a true share of {100 * found.trues[0]:.6g} %: {best.n:,} samples, "
            f"of which {best.failures} may fail ({_percent(best.chances[0].passes)})"
        )
    else:
        output.text(f"no plan reaches {100 * found.power:.6g} % at a true share of {100 * found.trues[0]:.6g} %")
    output.text(f"judged after every chunk of {found.running[0].every} samples, at most {found.running[0].budget:,}:")
    _running(found.running, output)
    output.document(asdict(found))
    return 0


def _of_campaign(file: Path, trues: list[float], output: Output) -> int:
    """Every requirement of a campaign with its own method and samples; time and memory."""
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
            found = of_requirement(requirement, problem.spec.samples, trues, LANES)
        except UsageError as error:
            output.text(str(error))
            continue
        output.text(f"{name}, {100 * requirement.confidence:.6g} % confidence")
        _running(found, output)
        document[name] = [asdict(one) for one in found]
    output.document(document)
    return 0


def _running(found: Sequence[Running], output: Output) -> None:
    head = ("method", "true share", "PASS", "FAIL", "UNDECIDED", "samples, mean")
    rows = [
        (
            one.method,
            f"{100 * one.true:.6g} %",
            *map(_percent, (one.passes, one.fails, one.undecided)),
            f"{one.samples:,.0f}",
        )
        for one in found
    ]
    output.table(head, rows)


def _percent(share: float) -> str:
    """A probability: 98.3 %, and where it is nearly 0 or 1 how nearly."""
    if share <= 0.0 or 1e-4 <= share <= 0.9999:
        return f"{100 * share:.1f} %" if share else "0 %"
    return f"{share:.0e}" if share < 0.5 else f"1 − {1 - share:.0e}" if share < 1.0 else "100 %"
