"""`rvjax init`: a starter campaign."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rvjax.cli._app import Json
from rvjax.cli._output import Output


def command(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder to write to; default: this one.")] = Path(),
    as_json: Json = False,
) -> int:
    """Write a commented starter campaign."""
    from rvjax.cli._starter import write

    output = Output(as_json)
    campaign, schema = write(folder)
    output.text(str(campaign), str(schema))
    output.note(f"fly it with\n  rvjax run {campaign}")
    output.document({"campaign": str(campaign), "schema": str(schema)})
    return 0
