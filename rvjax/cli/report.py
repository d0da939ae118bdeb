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
    pdf: Annotated[bool, typer.Option("--pdf", help="Print the report as report.pdf too; needs a Chromium.")] = False,
) -> int:
    """Rebuild the report from a run folder alone."""
    from rvjax.report import build

    output = Output(as_json)
    if pdf:
        from rvjax.report.pdf import browser

        browser()  # refused before the report is built
    page = build(folder, png, pdf)
    printed = {"pdf": str(page.with_name("report.pdf"))} if pdf else {}
    output.text(str(page), *printed.values())
    output.document({"report": str(page), **printed})
    return 0
