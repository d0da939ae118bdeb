"""GitHub actions: annotations on the lines of a campaign, and a summary of the job.

The commands and their escaping are those of GitHub's documentation, "Workflow commands for GitHub Actions".
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rvjax.analysis.verdicts.sentences import title
from rvjax.errors import visible

if TYPE_CHECKING:
    from rvjax.analysis.baseline import BaselineComparison
    from rvjax.analysis.verdicts import Verdict
    from rvjax.errors import Finding

_LEVELS = {"FAIL": "error", "UNDECIDED": "warning"}
_PLACE = re.compile(r"(.*):(\d+):(\d+)", re.DOTALL)
_SIGNS = {"PASS": "✅", "FAIL": "❌", "UNDECIDED": "❔"}


def active(environment: Mapping[str, str] = os.environ) -> bool:
    """Whether this runs as a step of GitHub actions."""
    return environment.get("GITHUB_ACTIONS") == "true"


def of_verdicts(verdicts: Sequence[Verdict], places: Sequence[str]) -> list[str]:
    """One command for each requirement that does not pass. places: `file:line:column` of each requirement."""
    return [
        command(_LEVELS[verdict.verdict], place, f"{verdict.verdict}: {title(verdict.requirement)}", verdict.text)
        for verdict, place in zip(verdicts, places, strict=True)
        if verdict.verdict in _LEVELS
    ]


def of_comparisons(comparisons: Sequence[BaselineComparison], baseline: str, place: str) -> list[str]:
    """One command for each comparison with a baseline that is worse. place: of the controller in the campaign."""
    worse = [one for one in comparisons if one.significant]
    return [command("error", place, f"worse than the baseline: {one.what}", one.told(baseline)) for one in worse]


def of_error(text: str) -> str:
    """A command for what ended the program and has no place in a file."""
    return command("error", "", "rvjax", text)


def of_findings(findings: Iterable[Finding]) -> list[str]:
    """One command for each mistake in a campaign."""
    return [command("error", finding.where, "campaign", str(finding)) for finding in findings]


def command(level: str, place: str, heading: str, message: str) -> str:
    """`::error file=…,line=…,col=…,title=…::message`, one line whatever is in the texts."""
    found = _PLACE.fullmatch(place)
    where = {"file": relative(found[1]), "line": found[2], "col": found[3]} if found else {}
    parts = ",".join(f"{name}={_property(value)}" for name, value in {**where, "title": heading}.items())
    return f"::{level} {parts}::{_data(message)}"


def relative(path: str, environment: Mapping[str, str] = os.environ) -> str:
    """The path as seen from the checkout, where it lies below it; with forward slashes."""
    root = environment.get("GITHUB_WORKSPACE")
    absolute = Path(path).absolute()
    return absolute.relative_to(root).as_posix() if root and absolute.is_relative_to(root) else Path(path).as_posix()


def _data(text: str) -> str:
    return visible(text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A"))


def _property(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")


def summary(campaign: str, verdicts: Sequence[Verdict], comparisons: Sequence[BaselineComparison] = ()) -> str:
    """A table of requirements, verdicts and bounds in Markdown, and one of comparisons with a baseline; nothing in them acts."""
    words = [verdict.verdict for verdict in verdicts]
    found = ", ".join(f"{words.count(word)} {word}" for word in _SIGNS if word in words) or "no requirement"
    lines = [f"### {_cell(campaign)}: {found}", ""]
    if verdicts:
        lines += ["| requirement | verdict | samples | found | at least | at most | required |", "| --- " * 7 + "|"]
    for verdict in verdicts:
        numbers = ((verdict.estimate.value, round), (verdict.low_bound, math.floor), (verdict.high_bound, math.ceil))
        shown = [_shown(verdict, x, way) for x, way in (*numbers, (verdict.limit, round))]
        cells = [title(verdict.requirement), f"{_SIGNS[verdict.verdict]} {verdict.verdict}", f"{verdict.n:,}", *shown]
        lines.append(f"| {' | '.join(map(_cell, cells))} |")
    if comparisons:
        worse = sum(one.significant for one in comparisons)
        lines += ["", f"Against the baseline: {f'worse in {worse}' if worse else 'not worse'}", ""]
        lines += ["| compared | | worse samples | better | p |", "| --- " * 5 + "|"]
    for one in comparisons:
        cells = [one.what, "❌ WORSE" if one.significant else "–", f"{one.worse:,}", f"{one.better:,}", f"{one.p:.2g}"]
        lines.append(f"| {' | '.join(map(_cell, cells))} |")
    return "\n".join([*lines, ""])


def _shown(verdict: Verdict, x: float, way: Callable[[float], int]) -> str:
    """A share in percent, its bounds rounded outwards; a mean in its unit."""
    if verdict.requirement.mean:
        return f"{x:.5g} {verdict.unit}".removesuffix(" 1")
    return f"{way(round(1e4 * x, 9)) / 100:g} %" if math.isfinite(x) else "–"


def _cell(text: str) -> str:
    """Text of a Markdown table as it is: no line end, no HTML, no mark that acts."""
    plain = visible(text).replace("\n", " ").replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return re.sub(r"([\\`*_{}\[\]()#+!|~@])", r"\\\1", plain)


def append_summary(text: str, environment: Mapping[str, str] = os.environ) -> None:
    """Adds to the job's summary, where the service has a file for it."""
    if path := environment.get("GITHUB_STEP_SUMMARY"):
        with open(path, "a", encoding="utf-8") as file:
            file.write(f"{text}\n")
