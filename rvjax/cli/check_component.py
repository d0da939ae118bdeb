"""`rvjax check-component`: a user's component against everything that flying it relies on."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rvjax.cli._app import Json
from rvjax.cli._output import Output


def command(
    file: Annotated[
        Path, typer.Argument(metavar="FILE[:NAME]", help="A Python file with components; NAME: only this one of them.")
    ],
    as_json: Json = False,
) -> int:
    """Check the shapes, units and numbers of a component's file."""
    from rvjax.execution.component_check import STATES, STEP, check_file

    output = Output(as_json)
    checked = check_file(file)
    for found in checked:
        numbers = ", ".join(found.parameters) or "none"
        output.text(f"{found.name}: one of {found.family}; it is traced, pure and finite at {STATES} states")
        output.text(f"  parameters: {numbers}")
        if found.signals:
            output.text(f"  {'columns' if found.family == 'metrics' else 'signals'}: {', '.join(found.signals)}")
        output.text(f"  cost: {found.operations} operations, {found.cost:.2g} times pd-plus")
        if found.idle:
            output.text(f"  changes no result by {STEP:.0%} at these states: {', '.join(found.idle)}")
    output.document({"components": [vars(found) for found in checked]})
    return 0
