"""`rvjax report`: the report of a run folder."""

from __future__ import annotations

from typing import Annotated

import typer

from rvjax.cli._app import Folder, Json
from rvjax.cli._output import Output


def command(
    folder: Folder,
    as_json: Json = False,
    png: Annotated[bool, typer.Option("--png", help="Write the figures as PNG files too.")] = False,
) -> int:
    """Rebuild the report from a run folder alone."""
    from rvjax.report import build

    output = Output(as_json)
    page = build(folder, png)
    output.text(str(page))
    output.document({"report": str(page)})
    return 0
