"""`rvjax tune`: a search for better values of a campaign."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from rvjax.cli._app import Campaign, Engine, Json, Out, Quiet, Samples, Seed, Sets, overrides
from rvjax.cli._output import Output
from rvjax.cli._resuming import resumable

if TYPE_CHECKING:
    from rvjax.run_folder.tuning_record import Confirmed, Searched


def command(
    file: Campaign,
    *,
    out: Out = None,
    samples: Samples = None,
    seed: Seed = None,
    sets: Sets = None,
    engine: Engine = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Search better gains; confirm them on fresh draws."""
    from rvjax.run_folder import atomic_files

    atomic_files.check_folder(out or Path("reports"))
    from rvjax.search.tuning.tune import tune

    output, values = Output(as_json, quiet), overrides(sets, samples, seed, engine)
    with resumable(output, out) as on_open, output.progress() as on_progress:
        place, record = tune(
            file,
            out,
            values,
            on_message=output.note,
            progress=on_progress,
            on_open=on_open,
            on_warnings=output.warnings,
            command=sys.argv,
        )
    code = _exit_code(record)
    _show(place, record, code, output)
    return code


def _exit_code(record: Searched) -> int:
    """1 where no candidate meets the requirements, or the winner fails a requirement on fresh draws or is worse than the original
    campaign; 3 where a requirement is undecided; 0 otherwise."""
    from rvjax.analysis.verdicts import exit_code_of
    from rvjax.report.tuning_sections.confirmation import WORDS, overall

    assert record.confirmation is not None, "a search ends with its confirmation"
    if record.missed or overall(record)[0] == WORDS["worse"]:
        return 1
    return exit_code_of(requirement.tuned for requirement in record.confirmation.requirements)


def _show(place: Path, record: Searched, code: int, output: Output) -> None:
    from rvjax.report.tuning_sections.confirmation import headline, value_text
    from rvjax.report.tuning_sections.values import setting_text

    confirmation = record.confirmation
    assert confirmation is not None, "a search ends with its confirmation"
    top = headline(record)
    output.text(f"{top.verdict.word}: {top.sentence}")
    rows = [
        (
            item.verdict,
            item.text,
            value_text(item.tuned, item),
            value_text(item.own, item),
            _interval(item),
            value_text(item.optimism, item),
        )
        for item in confirmation.objectives
    ]
    output.table(("verdict", "objective", "winner", "original", "difference", "optimism"), rows)
    if confirmation.requirements:
        kept = [
            (item.tuned, item.own, item.text, *("–" if n is None else f"{n}" for n in (item.only_tuned, item.only_own)))
            for item in confirmation.requirements
        ]
        output.table(("winner", "original", "requirement", "only winner", "only original"), kept)
    values = [
        (value.name, value.range, setting_text(value.own), setting_text(value.best if record.best else value.own))
        for value in record.parameters
    ]
    output.table(("value", "range", "original", "winner"), values)
    output.text(f"best campaign: {place / 'best.yaml'}", f"report: {place / 'report.html'}")
    output.document({"folder": str(place), **record.model_dump(), "exit_code": code})


def _interval(item: Confirmed) -> str:
    if math.isnan(item.difference.value):
        return "–"  # both are infinite
    scale, unit = (100.0, " %") if item.share else (1.0, f" {item.unit}".rstrip(" 1"))
    difference = item.difference
    return f"{scale * difference.value:+.4g} ({scale * difference.low:+.4g} … {scale * difference.high:+.4g}){unit}"
