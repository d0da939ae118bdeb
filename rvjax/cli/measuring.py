"""Commands that measure: bench."""

from __future__ import annotations

import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rvjax.cli.app import Json, Quiet, app
from rvjax.cli.output import Output, say

if TYPE_CHECKING:
    from rvjax.bench import Bench


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
    from rvjax.bench import measure

    output = Output(as_json, quiet)
    found = measure(file, rounds, yardsticks, growth, output.note)
    output.document(asdict(found))
    _show(found, output)
    strangers = [way for way, agree in found.agree.items() if not agree]
    if strangers:
        say(f"rvjax: not the same results: {', '.join(strangers)}", sys.stderr)
    return 1 if strangers else 0


def _show(found: Bench, output: Output) -> None:
    from rvjax.bench.case import OWN

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
