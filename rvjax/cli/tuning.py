"""Commands that search: tune."""

from __future__ import annotations

import shlex
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

from rvjax.cli.app import Campaign, Json, Out, Quiet, Samples, Seed, Sets, Terminated, app, overrides
from rvjax.cli.output import Output, say
from rvjax.errors import IncompleteError

if TYPE_CHECKING:
    from rvjax.searched import Searched


@app.command()
def tune(
    file: Campaign,
    out: Out = None,
    samples: Samples = None,
    seed: Seed = None,
    sets: Sets = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Search better values of a campaign on common draws, and confirm them on fresh ones. Again on the same folder: resumes."""
    from rvjax.tuning.tune import tune as search

    output, given = Output(as_json, quiet), overrides(sets, samples, seed)
    began = time.monotonic()
    folder: list[Path] = []
    try:
        with output.progress() as progress:
            place, found = search(file, out, given, output.note, progress, sys.argv, folder.append)
    except (KeyboardInterrupt, Terminated, IncompleteError):
        if folder:
            again = ["rvjax", "tune", str(file), "--out", str(folder[0]), *(part for one in given for part in ("--set", one))]
            say(f"stopped; what was flown is kept in {folder[0]}. Go on with\n  {shlex.join(again)}", sys.stderr)
            output.document({"stopped": str(folder[0]), "go_on_with": again})
        raise
    output.note(f"done in {time.monotonic() - began:.0f} s")
    _show(place, found, output)
    return 0


def _show(place: Path, found: Searched, output: Output) -> None:
    from rvjax.sections.tuning.confirmation import headline, shown
    from rvjax.sections.tuning.values import said

    assert found.confirmation is not None, "a search ends with its confirmation"
    top = headline(found)
    output.text(f"{top.verdict.word}: {top.sentence}")
    rows = [
        (one.verdict, one.text, shown(one.tuned, one), shown(one.own, one), _interval(one), shown(one.optimism, one))
        for one in found.confirmation.objectives
    ]
    output.table(("verdict", "objective", "winner", "as it is", "difference", "optimism"), rows)
    if found.confirmation.requirements:
        kept = [(one.tuned, one.own, one.text, f"{one.only_tuned}", f"{one.only_own}") for one in found.confirmation.requirements]
        output.table(("winner", "as it is", "requirement", "only winner", "only as it is"), kept)
    values = [(one.name, one.range, said(one.own), said(one.best if found.best else one.own)) for one in found.parameters]
    output.table(("value", "range", "as it is", "winner"), values)
    output.text(f"best campaign: {place / 'best.yaml'}", f"report: {place / 'report.html'}")
    output.document({"folder": str(place), **found.model_dump()})


def _interval(one: object) -> str:
    from rvjax.searched import Confirmed

    assert isinstance(one, Confirmed)
    scale, unit = (100.0, " %") if one.share else (1.0, f" {one.unit}".rstrip(" 1"))
    return f"{scale * one.difference.value:+.4g} ({scale * one.difference.low:+.4g} … {scale * one.difference.high:+.4g}){unit}"
