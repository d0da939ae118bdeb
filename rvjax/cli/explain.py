"""`rvjax explain`: a manual page."""

from __future__ import annotations

from textwrap import indent
from typing import TYPE_CHECKING, Annotated

import typer

from rvjax.cli import _completion
from rvjax.cli._app import Json
from rvjax.cli._output import Output

if TYPE_CHECKING:
    from rvjax.components.manual import Page

MARGIN = "    "


def command(
    name: Annotated[
        str,
        typer.Argument(
            help="A component, family, metric, distribution, key of the campaign file, or your Python file.",
            autocompletion=_completion.topics,
        ),
    ],
    as_json: Json = False,
) -> int:
    """Show the manual page of a component, key or topic."""
    from rvjax.components.manual_lookup import pages_called

    output = Output(as_json)
    pages = pages_called(name)
    listed = {member for page in pages for member, _ in page.members}
    for page in pages:
        if page.name not in listed:
            _print(page, output)
    output.document({"pages": [page.document() for page in pages]})
    return 0


def _print(page: Page, output: Output) -> None:
    """A page on the terminal."""
    origin = f", from {page.origin}" if "." in page.origin else ""
    output.text(f"{page.name}  ({page.family}{origin})", "", page.text, "")
    for head, cells in ((("member", "description"), page.members), *page.tables):
        if cells:
            output.table(head, cells)
    for example in page.examples:
        files = "".join(f"\n{name}:\n\n{indent(text, MARGIN)}" for name, text in example.files.items())
        output.text("Example, in place of these sections of a campaign:", "", indent(example.yaml, MARGIN) + files)
