"""`rvjax view`: the report in the browser."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rvjax.cli import _completion
from rvjax.cli._app import Folder, Json
from rvjax.cli._output import Output
from rvjax.errors import UsageError


def command(
    folder: Folder,
    *,
    sample: Annotated[
        int | None, typer.Option("--sample", min=0, help="At this kept flight.", autocompletion=_completion.samples)
    ] = None,
    at: Annotated[float | None, typer.Option("--at", min=0.0, metavar="S", help="With --sample: at this time.")] = None,
    only_print: Annotated[bool, typer.Option("--print", help="Print the address of the report, and open nothing.")] = False,
    as_json: Json = False,
) -> int:
    """Open the report of a run in the browser."""
    import webbrowser

    output = Output(as_json)
    if not isinstance(folder, Path):
        raise UsageError(f"{folder}: in an object store; accepted: a folder of this machine, such as a copy")
    page = folder / "report.html"
    if not page.is_file():
        raise UsageError(f"{page}: no report; accepted: the folder of a run that has ended, or `rvjax report {folder}` first")
    if at is not None and sample is None:
        raise UsageError("--at without a flight; accepted: with --sample K")
    place = {"sample": sample, "t": at}
    fragment = "&".join(f"{key}={value}" for key, value in place.items() if value is not None)
    address = page.resolve().as_uri() + (f"#{fragment}" if fragment else "")
    opened = not only_print and webbrowser.open(address)
    if not only_print and not opened:
        output.note("no browser here; open this address where there is one")
    output.text(address)
    output.document({"report": address, "opened": opened})
    return 0
