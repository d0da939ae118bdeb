"""Verdicts as JUnit XML: one test case for each requirement, and for each comparison with a baseline.

PASS is a plain test case, FAIL has a `failure`, and UNDECIDED has an `error`. Viewers show both in red and tell them apart. A job
that shall continue after UNDECIDED uses the exit code (3), not this file. An error that prevents verdicts is an `error` as well:
otherwise a green file, or that of an earlier run, would hide it. Jenkins, GitLab and GitHub Actions read this format (testsuites,
testsuite, testcase, properties, failure, error, system-out).
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING
from xml.etree import ElementTree

from rvjax.analysis.verdicts.rare import WORDS
from rvjax.analysis.verdicts.sentences import title
from rvjax.errors import visible

if TYPE_CHECKING:
    from rvjax.analysis.baseline import BaselineComparison
    from rvjax.analysis.verdicts import Verdict
    from rvjax.analysis.verdicts.verdict import RareFailure

_NO_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that XML 1.0 cannot hold, not even escaped."""

_KINDS = {"FAIL": "failure", "UNDECIDED": "error", "WORSE": "failure", "ERROR": "error"}


@dataclass(frozen=True)
class Case:
    """A test case. word: PASS or a key of `_KINDS`; group: suffix of its class, after the campaign's name; advice: what to do
    if it does not pass."""

    name: str
    word: str
    text: str
    properties: Mapping[str, str] = field(default_factory=dict[str, str])
    group: str = ""
    advice: str = ""


def of_verdicts(verdicts: Sequence[Verdict], advice: Sequence[str] = ()) -> list[Case]:
    """A test case for each requirement. advice: of each requirement, such as a command."""
    advice = advice or [""] * len(verdicts)
    return [
        Case(f"{n}. {title(verdict.requirement)}", verdict.verdict, verdict.text, _properties(verdict), advice=text)
        for n, (verdict, text) in enumerate(zip(verdicts, advice, strict=True), 1)
    ]


def of_comparisons(comparisons: Sequence[BaselineComparison], baseline: str) -> list[Case]:
    """A test case for each comparison with a baseline."""
    return [
        Case(
            comparison.what,
            "WORSE" if comparison.significant else "PASS",
            comparison.sentence(baseline),
            {"worse": str(comparison.worse), "better": str(comparison.better), "p": f"{comparison.p:.6g}"},
            ".baseline",
        )
        for comparison in comparisons
    ]


def of_error(name: str, text: str) -> Case:
    """A test case for an error that prevented verdicts."""
    return Case(name, "ERROR", text, group=".rvjax")


def junit(campaign: str, cases: Sequence[Case]) -> bytes:
    """The XML document in UTF-8. campaign: its name."""
    kinds = [_KINDS.get(case.word) for case in cases]
    counts = {"tests": len(kinds), "failures": kinds.count("failure"), "errors": kinds.count("error")}
    numbers = {name: str(count) for name, count in counts.items()}
    root = ElementTree.Element("testsuites", {"name": "rvjax", **numbers, "time": "0"})
    suite = ElementTree.SubElement(root, "testsuite", {"name": _text(campaign), **numbers, "skipped": "0", "time": "0"})
    for case, kind in zip(cases, kinds, strict=True):
        attributes = {"classname": _text(campaign + case.group), "name": _text(case.name), "time": "0"}
        element = ElementTree.SubElement(suite, "testcase", attributes)
        properties = ElementTree.SubElement(element, "properties")
        for key, value in case.properties.items():
            ElementTree.SubElement(properties, "property", {"name": key, "value": value})
        if kind is not None:
            problem = ElementTree.SubElement(element, kind, {"type": case.word, "message": _text(case.text)})
            problem.text = _text(f"{case.text}\n{case.advice}".strip())
        ElementTree.SubElement(element, "system-out").text = _text(case.text)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="utf-8", xml_declaration=True) + b"\n"


def _properties(verdict: Verdict) -> dict[str, str]:
    return (
        {name: _text(text) for name, text in verdict.requirement.origin.items()}
        | {
            "verdict": verdict.verdict,
            "method": verdict.requirement.method,
            "confidence": f"{verdict.requirement.confidence:g}",
            "samples": str(verdict.n),
            "complying": str(verdict.successes),
            "required": f"{verdict.limit:.12g}",
            "low": f"{verdict.low_bound:.12g}",
            "high": f"{verdict.high_bound:.12g}",
            **({} if verdict.under is None else {name: str(value) for name, value in vars(verdict.under).items()}),
        }
        | ({} if verdict.rare is None else _of_rare(verdict.rare))
    )


def _of_rare(rare: RareFailure) -> dict[str, str]:
    """The failure probability: allowed, proved bounds, and the estimate with its nominal bounds; what the verdict rests on."""
    numbers = {"allowed": rare.allowed, "proved_low": rare.proved_low, "proved_high": rare.proved_high}
    numbers |= {
        name: x for name, x in (("estimate", rare.value), ("nominal_low", rare.low), ("nominal_high", rare.high)) if x is not None
    }
    return {"basis": WORDS[rare.basis]} | {f"failure_{name}": f"{value:.6g}" for name, value in numbers.items()}


def _text(text: str) -> str:
    """The text with escapes for characters that XML cannot hold, and for control sequences of terminals."""
    return _NO_XML.sub(lambda match: match[0].encode("unicode_escape", "surrogatepass").decode(), visible(text))
