"""What a search found → sections → report.html, report.md and figures in its folder. The same search gives the same bytes."""

from __future__ import annotations

from pathlib import Path

from rvjax import searched
from rvjax.errors import IncompleteError
from rvjax.report import html, markdown
from rvjax.report.picture import drawn
from rvjax.results import RunFolder
from rvjax.searched import Searched
from rvjax.sections.tuning import sections
from rvjax.sections.tuning.confirmation import headline


def build(folder: RunFolder) -> Path:
    """Writes the report of a finished search again; IncompleteError where it has not finished."""
    found = searched.read(folder.path)
    if found is None:
        raise IncompleteError(f"{folder.path}: the search has not finished; `rvjax tune` with the same --out goes on with it")
    for name in (searched.NAME, searched.TABLE, searched.BEST):
        folder.write_bytes(name, (folder.path / name).read_bytes())
    return write(folder, found)


def write(folder: RunFolder, found: Searched) -> Path:
    """Writes the report beside what was found, and seals the folder; returns the path of `report.html`."""
    top = headline(found)
    shown, pictures = drawn(folder, lambda: sections(found))
    folder.write_text("report.md", markdown.page(top, shown))
    page = folder.write_text("report.html", html.page(top, shown, pictures))
    folder.seal()
    return page
