"""Verdicts as JUnit XML: one test case for each requirement, and for each comparison with a baseline.

PASS is a test case by itself, FAIL one with a `failure`, UNDECIDED one with an `error`: viewers show both in red and apart, and a
job that shall not stop at UNDECIDED goes by the exit code (3), not by this file. What kept verdicts from coming about is an
`error` as well, since a file that is green, or an earlier run's, would hide it. The form is the one that Jenkins, GitLab and
GitHub actions read (testsuites, testsuite, testcase, properties, failure, error, system-out).
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING
from xml.etree import ElementTree

from rvjax.analysis.verdicts.sentences import title
from rvjax.errors import visible

if TYPE_CHECKING:
    from rvjax.analysis.baseline import BaselineComparison
    from rvjax.analysis.verdicts import Verdict

_NO_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that XML 1.0 cannot hold, however they are spelt."""

_KINDS = {"FAIL": "failure", "UNDECIDED": "error", "WORSE": "failure", "ERROR": "error"}


@dataclass(frozen=True)
class Case:
    """A test case. group: what its class is called behind the campaign's name. word: PASS, or one of `_KINDS`. advice: what to do
    where it does not pass."""

    name: str
    word: str
    text: str
    properties: Mapping[str, str] = field(default_factory=dict[str, str])
    group: str = ""
    advice: str = ""


def of_verdicts(verdicts: Sequence[Verdict], advice: Sequence[str] = ()) -> list[Case]:
    """One for each requirement. advice: of each, such as a command."""
    told = advice or [""] * len(verdicts)
    return [
        Case(f"{n}. {title(one.requirement)}", one.verdict, one.text, _properties(one), advice=its)
        for n, (one, its) in enumerate(zip(verdicts, told, strict=True), 1)
    ]


def of_comparisons(comparisons: Sequence[BaselineComparison], baseline: str) -> list[Case]:
    """One for each comparison with a baseline."""
    return [
        Case(
            one.what,
            "WORSE" if one.significant else "PASS",
            one.told(baseline),
            {"worse": str(one.worse), "better": str(one.better), "p": f"{one.p:.6g}"},
            ".baseline",
        )
        for one in comparisons
    ]


def of_error(name: str, text: str) -> Case:
    """What kept verdicts from coming about."""
    return Case(name, "ERROR", text, group=".rvjax")


def junit(campaign: str, cases: Sequence[Case]) -> bytes:
    """The document, UTF-8. campaign: its name."""
    kinds = [_KINDS.get(case.word) for case in cases]
    counts = {"tests": len(kinds), "failures": kinds.count("failure"), "errors": kinds.count("error")}
    numbers = {name: str(count) for name, count in counts.items()}
    root = ElementTree.Element("testsuites", {"name": "rvjax", **numbers, "time": "0"})
    suite = ElementTree.SubElement(root, "testsuite", {"name": _text(campaign), **numbers, "skipped": "0", "time": "0"})
    for case, kind in zip(cases, kinds, strict=True):
        named = {"classname": _text(campaign + case.group), "name": _text(case.name), "time": "0"}
        element = ElementTree.SubElement(suite, "testcase", named)
        properties = ElementTree.SubElement(element, "properties")
        for key, value in case.properties.items():
            ElementTree.SubElement(properties, "property", {"name": key, "value": value})
        if kind is not None:
            told = ElementTree.SubElement(element, kind, {"type": case.word, "message": _text(case.text)})
            told.text = _text(f"{case.text}\n{case.advice}".strip())
        ElementTree.SubElement(element, "system-out").text = _text(case.text)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="utf-8", xml_declaration=True) + b"\n"


def _properties(verdict: Verdict) -> dict[str, str]:
    return {
        "verdict": verdict.verdict,
        "method": verdict.requirement.method,
        "confidence": f"{verdict.requirement.confidence:g}",
        "samples": str(verdict.n),
        "complying": str(verdict.successes),
        "required": f"{verdict.limit:.12g}",
        "low": f"{verdict.low_bound:.12g}",
        "high": f"{verdict.high_bound:.12g}",
    }


def _text(text: str) -> str:
    """The text with what XML cannot hold, or what acts on a terminal, spelt out."""
    return _NO_XML.sub(lambda found: found[0].encode("unicode_escape", "surrogatepass").decode(), visible(text))
