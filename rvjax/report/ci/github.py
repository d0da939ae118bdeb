"""GitHub Actions: annotations on the lines of a campaign file, and the job summary.

The commands and their escaping follow GitHub's documentation, "Workflow commands for GitHub Actions".
"""

from __future__ import annotations

import math
import os
import re
import shlex
from collections.abc import Iterable, Mapping, Sequence
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Decimal
from pathlib import Path
from typing import TYPE_CHECKING

from rvjax.analysis.percentages import rounded
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
    """Whether this process runs in GitHub Actions."""
    return environment.get("GITHUB_ACTIONS") == "true"


def of_verdicts(verdicts: Sequence[Verdict], places: Sequence[str]) -> list[str]:
    """A command for each requirement that does not pass. places: `file:line:column` of each requirement."""
    return [
        command(_LEVELS[verdict.verdict], place, f"{verdict.verdict}: {title(verdict.requirement)}", verdict.text)
        for verdict, place in zip(verdicts, places, strict=True)
        if verdict.verdict in _LEVELS
    ]


def of_comparisons(comparisons: Sequence[BaselineComparison], baseline: str, place: str) -> list[str]:
    """A command for each comparison that is significantly worse than the baseline. place: of the controller in the campaign."""
    worse = [comparison for comparison in comparisons if comparison.significant]
    return [
        command("error", place, f"worse than the baseline: {comparison.what}", comparison.sentence(baseline))
        for comparison in worse
    ]


def of_error(text: str) -> str:
    """A command for an error without a place in a file."""
    return command("error", "", "rvjax", text)


def of_findings(findings: Iterable[Finding]) -> list[str]:
    """A command for each mistake in a campaign."""
    return [command("error", finding.where, "campaign", str(finding)) for finding in findings]


def command(level: str, place: str, heading: str, message: str) -> str:
    """`::error file=…,line=…,col=…,title=…::message`, always a single line."""
    match = _PLACE.fullmatch(place)
    where = {"file": relative(match[1]), "line": match[2], "col": match[3]} if match else {}
    parts = ",".join(f"{name}={_property(value)}" for name, value in {**where, "title": heading}.items())
    return f"::{level} {parts}::{_data(message)}"


def relative(path: str, environment: Mapping[str, str] = os.environ) -> str:
    """The path with forward slashes, relative to the checkout if it lies inside."""
    root = environment.get("GITHUB_WORKSPACE")
    absolute = Path(path).absolute()
    return absolute.relative_to(root).as_posix() if root and absolute.is_relative_to(root) else Path(path).as_posix()


def _data(text: str) -> str:
    return visible(text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A"))


def _property(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")


def summary(campaign: str, verdicts: Sequence[Verdict], comparisons: Sequence[BaselineComparison] = ()) -> str:
    """Markdown tables of the verdicts and of the comparisons with a baseline; every text is escaped."""
    words = [verdict.verdict for verdict in verdicts]
    counts = ", ".join(f"{words.count(word)} {word}" for word in _SIGNS if word in words) or "no requirement"
    lines = [f"### {_cell(campaign)}: {counts}", ""]
    if verdicts:
        lines += ["| requirement | verdict | samples | estimate | lower bound | upper bound | required |", "| --- " * 7 + "|"]
    for verdict in verdicts:
        numbers = (
            (verdict.estimate.value, ROUND_HALF_EVEN),
            (verdict.low_bound, ROUND_FLOOR),
            (verdict.high_bound, ROUND_CEILING),
        )
        shown = [_shown(verdict, x, way) for x, way in (*numbers, (verdict.limit, ROUND_HALF_EVEN))]
        cells = [title(verdict.requirement), f"{_SIGNS[verdict.verdict]} {verdict.verdict}", f"{verdict.n:,}", *shown]
        lines.append(f"| {' | '.join(map(_cell, cells))} |")
    if comparisons:
        worse = sum(comparison.significant for comparison in comparisons)
        lines += [
            "",
            f"Comparison with the baseline: {f'significantly worse in {worse}' if worse else 'not significantly worse'}",
            "",
        ]
        lines += ["| comparison | result | samples worse | samples better | p |", "| --- " * 5 + "|"]
    for comparison in comparisons:
        result = "❌ WORSE" if comparison.significant else "–"
        cells = [comparison.what, result, f"{comparison.worse:,}", f"{comparison.better:,}", f"{comparison.p:.2g}"]
        lines.append(f"| {' | '.join(map(_cell, cells))} |")
    return "\n".join([*lines, ""])


def summary_of_error(command: Sequence[str], code: int, text: str) -> str:
    """Markdown for a command that ended without a result: the command, its exit code and each line of its message."""
    lines = [f"- {_cell(line)}" for line in text.splitlines() if line.strip()]
    return "\n".join([f"### {_cell(shlex.join(command))}: exit code {code}", "", *lines, ""])


def _shown(verdict: Verdict, x: float, way: str) -> str:
    """A share in percent, with its bounds rounded outwards; a mean in its unit. Only 1 reads as 100 %, only 0 as 0 %."""
    if verdict.requirement.mean:
        return f"{x:.5g} {verdict.unit}".removesuffix(" 1")
    return f"{rounded(Decimal(f'{100 * x:.14g}'), 2, way).normalize():f} %" if math.isfinite(x) else "–"


def _cell(text: str) -> str:
    """Text for a cell of a Markdown table, with line ends, HTML and marks escaped."""
    plain = visible(text).replace("\n", " ").replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return re.sub(r"([\\`*_{}\[\]()#+!|~@])", r"\\\1", plain)


def append_summary(text: str, environment: Mapping[str, str] = os.environ) -> None:
    """Appends to the job summary, if the environment names a file for it."""
    if path := environment.get("GITHUB_STEP_SUMMARY"):
        with open(path, "a", encoding="utf-8") as file:
            file.write(f"{text}\n")
