"""`rvjax bench`: the speed on this machine."""

from __future__ import annotations

import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rvjax.cli import _completion
from rvjax.cli._app import Json, Quiet
from rvjax.cli._output import Output, say

if TYPE_CHECKING:
    from rvjax.execution.bench import Bench


def command(
    file: Annotated[
        Path | None,
        typer.Argument(
            metavar="FILE", help="A campaign file; default: the starter campaign.", autocompletion=_completion.campaigns
        ),
    ] = None,
    *,
    rounds: Annotated[int, typer.Option("--rounds", min=1, help="Flights of every way, in turn.")] = 3,
    yardsticks: Annotated[
        Path | None,
        typer.Option(
            "--yardsticks",
            metavar="DIR",
            help="`benchmarks` of a clone, whose code is run; default: that of the clone in which the command is given.",
        ),
    ] = None,
    way: Annotated[
        list[str] | None,
        typer.Option("--way", metavar="WAY", help="Only this way to fly, beside rvjax itself; may be repeated. Default: all."),
    ] = None,
    growth: Annotated[bool, typer.Option(help="Also time and memory from 10³ to 10⁶ samples.")] = True,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Measure the speed against other ways to fly."""
    from rvjax.execution.bench import measure

    output = Output(as_json, quiet)
    result = measure(file, rounds, yardsticks, way or (), growth, output.note)
    output.document(asdict(result))
    _show(result, output)
    differing = [way for way, agree in result.agree.items() if not agree]
    if differing:
        say(f"rvjax: not the same results: {', '.join(differing)}", sys.stderr)
    return 1 if differing else 0


def _show(result: Bench, output: Output) -> None:
    from rvjax.execution.bench.workload import RVJAX

    case, machine = result.case, result.machine
    output.text(
        f"{case['samples']} samples of {case['campaign']}, {case['steps']} steps; median of {case['rounds']} rounds; "
        f"{machine['device']}, {machine['cores']} cores, {machine['processor']}, jaxlib {machine['jaxlib']}"
    )
    rows = [
        (
            way,
            f"{result.steps_per_s[way] / 1e6:.2f}",
            f"{result.samples_per_s[way]:,.0f}",
            f"{result.ratio[way]:.2f}",
            f"{result.apart[way]:.0e}{'' if result.agree[way] else ' (!)'}",
            f"{result.compile_s[way]:.1f}",
        )
        for way in result.steps_per_s
    ]
    output.table(("way", "M steps/s", "samples/s", "rvjax ×", "differs", "compile s"), rows)
    output.text("rvjax ×: how many times as fast rvjax is. differs: where flights end, relative to the largest error.")
    for way, why in result.unavailable.items():
        output.text(f"{way}: not measured, {why}")
    if not result.unavailable and not set(result.steps_per_s).difference(RVJAX):
        output.text("no yardsticks: they are in `benchmarks` of a clone, `--yardsticks DIR` says where")
    output.text(
        f"first chunk after {result.cold_s:.1f} s cold, {result.warm_s:.1f} s warm; peak memory {result.peak_memory_mb:.0f} MB"
    )
    if result.growth:
        grown = [
            (f"{row['samples']:,}", f"{row['steps_per_s'] / 1e6:.3g} M", f"{row['peak_memory_mb']:.0f} MB")
            for row in result.growth
        ]
        output.table(("samples", "steps/s, draws included", "peak memory"), grown)
