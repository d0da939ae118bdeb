"""The result of a search → sections → report.html, report.md and figures in its folder. The same search gives the same bytes."""

from __future__ import annotations

from rvjax.errors import IncompleteError
from rvjax.places import Place
from rvjax.report import html, markdown
from rvjax.report.figures import render
from rvjax.report.tuning_sections import sections
from rvjax.report.tuning_sections.confirmation import headline
from rvjax.run_folder import RunFolder, tuning_record
from rvjax.run_folder.tuning_record import Searched


def build(folder: RunFolder, png: bool = False) -> Place:
    """Rewrites the report of a finished search and returns the path of `report.html`; IncompleteError if it has not finished."""
    search = tuning_record.read(folder.path)
    if search is None:
        raise IncompleteError(f"{folder.path}: the search has not finished; `rvjax tune` with the same --out resumes it")
    for name in (tuning_record.NAME, tuning_record.TABLE, tuning_record.BEST):
        folder.write_bytes(name, folder.read_bytes(name))
    return write(folder, search, png)


def write(folder: RunFolder, search: Searched, png: bool = False) -> Place:
    """Writes the report of a search into its folder, seals the folder, and returns the path of `report.html`."""
    top = headline(search)
    shown, pictures = render(folder, lambda: sections(search), png)
    folder.write_text("report.md", markdown.page(top, shown))
    page = folder.write_text("report.html", html.page(top, shown, pictures))
    folder.seal()
    return page
