"""Run folder → sections → report.html, report.md, figures/ and summary.json. The same folder gives the same bytes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rvjax.analysis.verdicts.folders import SEARCH
from rvjax.report import figures, html, markdown, tuning_report
from rvjax.report.blocks import Headline, Number, Section
from rvjax.report.run_view import Run, open_run
from rvjax.report.sections import sections
from rvjax.report.sections.verdicts import headline
from rvjax.run_folder import RunFolder, verdict_columns

FORMAT = 1


def build(folder: str | Path) -> Path:
    """Writes the report of a run folder and returns the path of `report.html`.

    FolderError where `folder` is no run folder or is damaged, IncompleteError where nothing is flown yet or the disk is
    full. Values that the samples table lacks are left out with a sentence, never an error.
    """
    opened = RunFolder.open(folder)
    if SEARCH in opened.identity:
        return tuning_report.build(opened)
    return write(opened, open_run(folder))


def write(folder: RunFolder, run: Run) -> Path:
    """Writes the report of an opened run into its folder and returns the path of `report.html`; reads no samples."""
    top = headline(run)
    shown, pictures = figures.drawn(folder, lambda: sections(run))
    if run.extract is not None:
        folder.write_bytes(verdict_columns.NAME, run.extract)
    folder.write_summary(summary(run, top, shown))
    folder.write_text("report.md", markdown.page(top, shown))
    page = folder.write_text("report.html", html.page(top, shown, pictures))
    folder.seal()
    return page


def summary(run: Run, top: Headline, shown: Iterable[Section]) -> dict[str, Any]:
    """Every number of the report by name: value, interval, n, confidence, method, SI unit; the account; the verdicts.

    An infinite value or bound is None (null in the file).
    """
    cells = [cell for _, cell in top.facts if isinstance(cell, Number)]
    cells += [number for section in shown for number in section.numbers()]
    return {
        "format": FORMAT,
        "name": run.spec.name,
        "verdict": top.verdict.word,
        "account": asdict(run.account),
        "requirements": [
            {"metric": verdict.requirement.metric, "verdict": verdict.verdict, "text": verdict.text} for verdict in run.verdicts
        ],
        "numbers": {cell.name: asdict(cell.estimate) | {"unit": cell.unit} for cell in cells},
    }
