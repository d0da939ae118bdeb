"""`rvjax check`: verdicts as words and as an exit code."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from rvjax.cli import _completion
from rvjax.cli._app import Dask, Engine, Json, JunitXml, Out, Quiet, Samples, Seed, Sets, overrides
from rvjax.cli._ci_outputs import CiOutputs
from rvjax.cli._fly_and_judge import fly_and_judge, judge
from rvjax.cli._output import Output
from rvjax.errors import UsageError
from rvjax.places import place_of


def command(
    place: Annotated[
        Path,
        typer.Argument(
            metavar="DIR|FILE", help="A run folder, or a campaign file, which is flown first.", autocompletion=_completion.places
        ),
    ],
    *,
    out: Out = None,
    samples: Samples = None,
    seed: Seed = None,
    sets: Sets = None,
    engine: Engine = None,
    dask: Dask = None,
    junit_xml: JunitXml = None,
    against: Annotated[
        Path | None, typer.Option("--against", metavar="PATH", help="Fail where the run is significantly worse than a baseline.")
    ] = None,
    write_baseline: Annotated[
        Path | None, typer.Option("--write-baseline", metavar="PATH", help="Write a baseline for --against.")
    ] = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Print verdicts and set the exit code; a FILE flies first."""
    output, values = Output(as_json, quiet), overrides(sets, samples, seed, engine)
    ci_outputs = CiOutputs(junit_xml, against, write_baseline)
    where = place_of(place)
    if isinstance(where, Path) and not os.path.isdir(where):
        return fly_and_judge(where, out, values, output, ci_outputs, dask=dask, until_decided=True)
    if out is not None or values or dask is not None:
        accepted = "--junit-xml, --against, --write-baseline, --json, --quiet; or a campaign file"
        raise UsageError(f"{where}: a run folder is judged without flying; accepted: {accepted}")
    return judge(where, output, ci_outputs)
