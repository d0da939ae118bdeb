"""Run folder → sections → report.html, report.md, figures/ and summary.json. The same folder gives the same bytes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict
from typing import Any

from rvjax.analysis.verdicts.folders import SEARCH
from rvjax.places import Place
from rvjax.report import html, markdown, tuning_report
from rvjax.report.blocks import Headline, Number, Section
from rvjax.report.figures import render
from rvjax.report.interactive.page_parts import interactive
from rvjax.report.pdf import printed
from rvjax.report.run_view import Run, open_run
from rvjax.report.sections import sections
from rvjax.report.sections.verdicts import headline
from rvjax.run_folder import RunFolder, verdict_columns

FORMAT = 1


def build(folder: str | Place, png: bool = False, pdf: bool = False) -> Place:
    """Writes the report of a run folder or of a tuning folder, and returns the path of `report.html`. png: also write the figures
    as PNG files. pdf: also print the report with a Chromium; UsageError where there is none.

    Raises FolderError if the folder is not a run folder or is damaged, and IncompleteError if no chunk is finished or the disk
    is full. A column that the samples table lacks is no error: the report says so in a sentence.
    """
    run_folder = RunFolder.open(folder)
    search = SEARCH in run_folder.identity
    page = tuning_report.build(run_folder, png) if search else write(run_folder, open_run(folder), png=png)
    if pdf:
        run_folder.write_bytes("report.pdf", printed(run_folder.read_bytes("report.html")))
        run_folder.seal()
    return page


def write(folder: RunFolder, run: Run, timings: Callable[[], Mapping[str, Any]] | None = None, png: bool = False) -> Place:
    """Writes the report of an opened run into its folder and returns the path of `report.html`. It reads no samples.

    timings: of the process so far, for the run folder and `summary.json`. png: also write the figures as PNG files.
    """
    top = headline(run)
    shown, pictures = render(folder, lambda: sections(run), png)
    if run.extract is not None:
        folder.write_bytes(verdict_columns.NAME, run.extract)
    folder.write_text("report.md", markdown.page(top, shown))
    page = folder.write_text("report.html", html.page(top, shown, pictures, interactive(folder, run, shown)))
    if timings is not None:
        folder.keep_timings(timings())
    folder.write_summary(summary(run, top, shown) | folder.timings)
    folder.seal()
    return page


def summary(run: Run, top: Headline, shown: Iterable[Section]) -> dict[str, Any]:
    """`summary.json`: the account, the verdicts, and every number of the report with its interval, n, method and SI unit.

    The file holds null for an infinite value or bound.
    """
    cells = [cell for _, cell in top.facts if isinstance(cell, Number)]
    cells += [number for section in shown for number in section.numbers()]
    return {
        "format": FORMAT,
        "name": run.spec.name,
        "verdict": top.verdict.word,
        "account": asdict(run.account),
        "requirements": [
            verdict.requirement.origin | {"metric": verdict.requirement.metric, "verdict": verdict.verdict, "text": verdict.text}
            for verdict in run.verdicts
        ],
        "numbers": {cell.name: asdict(cell.estimate) | {"unit": cell.unit} for cell in cells},
    }
