"""`rvjax export`: tables and traces for other tools."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rvjax.cli import _completion
from rvjax.cli._app import Folder, Json
from rvjax.cli._output import Output


def command(
    folder: Folder,
    *,
    to: Annotated[Path, typer.Option("--to", metavar="FILE", help="A .csv, .json, .mat, .oem, .aem, .rrd or .mcap file.")],
    sample: Annotated[
        int | None,
        typer.Option(
            "--sample", min=0, help="The flight of this sample, not the samples table.", autocompletion=_completion.samples
        ),
    ] = None,
    every: Annotated[
        int | None, typer.Option("--every", min=1, metavar="N", help="Every N-th step; default: at most 601 rows.")
    ] = None,
    epoch: Annotated[
        str | None, typer.Option("--epoch", metavar="UTC", help="The date of t = 0 in .oem and .aem; default J2000.")
    ] = None,
    plane: Annotated[
        tuple[float, float, float],
        typer.Option(
            "--plane",
            metavar="NODE INCLINATION PERIGEE",
            help="The orbit plane in .oem and .aem: ascending node, inclination and argument of perigee in degrees.",
        ),
    ] = (0.0, 0.0, 0.0),
    as_json: Json = False,
) -> int:
    """Write samples or the flight of a sample for other tools."""
    from rvjax.execution.exporting import Options, export

    output = Output(as_json)
    files = export(folder, to, sample, Options(every, epoch, plane))
    output.text(*map(str, files))
    output.document({"files": [str(path) for path in files], "sample": sample})
    return 0
