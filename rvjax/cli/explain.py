"""`rvjax explain`: a manual page."""

from __future__ import annotations

from typing import Annotated

import typer

from rvjax.cli import _completion
from rvjax.cli._app import Json
from rvjax.cli._output import Output


def command(
    name: Annotated[
        str,
        typer.Argument(
            help="A component, metric, distribution, or section of the campaign file.", autocompletion=_completion.topics
        ),
    ],
    as_json: Json = False,
) -> int:
    """Show a component's equations, source, parameters and units."""
    from rvjax.components import manual

    output = Output(as_json)
    pages = manual.pages_called(name)
    for page in pages:
        output.text(f"{page.name}  ({page.family}, from {page.origin})", "", page.text, "")
        if page.rows:
            output.table(page.headings, page.rows)
    output.document({"pages": [vars(page) for page in pages]})
    return 0
