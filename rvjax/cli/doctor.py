"""`rvjax doctor`: the state of this installation and of a run folder."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rvjax.cli import _completion
from rvjax.cli._app import Json
from rvjax.cli._output import Output
from rvjax.places import place_of


def command(
    folder: Annotated[
        Path | None,
        typer.Argument(
            metavar="DIR", help="A run folder whose files are verified as well.", autocompletion=_completion.run_folders
        ),
    ] = None,
    as_json: Json = False,
) -> int:
    """Check the installation, and with DIR every file of a run."""
    from rvjax.execution.doctor import examine

    output = Output(as_json)
    examined = examine(folder and place_of(folder))
    output.table(("what", "value"), [(name, str(value)) for name, value in examined.facts.items()])
    output.text(*[f"wrong: {complaint}" for complaint in examined.complaints] or ["nothing is wrong"])
    output.document({"facts": examined.facts, "complaints": examined.complaints, "exit_code": examined.exit_code})
    return examined.exit_code
