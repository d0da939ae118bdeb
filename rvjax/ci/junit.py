"""Verdicts as JUnit XML: one test case for each requirement.

PASS is a test case by itself, FAIL one with a `failure`, UNDECIDED one with an `error`: viewers show both in red and apart, and a
job that shall not stop at UNDECIDED goes by the exit code (3), not by this file. The form is the one that Jenkins, GitLab and
GitHub actions read (testsuites, testsuite, testcase, properties, failure, error, system-out).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING
from xml.etree import ElementTree

from rvjax.check.words import title

if TYPE_CHECKING:
    from rvjax.check import Verdict

_NO_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that XML 1.0 cannot hold, however they are spelt."""

_KINDS = {"FAIL": "failure", "UNDECIDED": "error"}


def junit(campaign: str, verdicts: Sequence[Verdict], advice: str = "") -> bytes:
    """The document, UTF-8. campaign: its name. advice: what to do about a requirement that does not pass, such as a command."""
    words = [verdict.verdict for verdict in verdicts]
    counts = {"tests": len(words), "failures": words.count("FAIL"), "errors": words.count("UNDECIDED")}
    numbers = {name: str(count) for name, count in counts.items()}
    root = ElementTree.Element("testsuites", {"name": "rvjax", **numbers, "time": "0"})
    suite = ElementTree.SubElement(root, "testsuite", {"name": _text(campaign), **numbers, "skipped": "0", "time": "0"})
    for number, verdict in enumerate(verdicts, 1):
        name = f"{number}. {title(verdict.requirement)}"
        case = ElementTree.SubElement(suite, "testcase", {"classname": _text(campaign), "name": _text(name), "time": "0"})
        properties = ElementTree.SubElement(case, "properties")
        for key, value in _properties(verdict).items():
            ElementTree.SubElement(properties, "property", {"name": key, "value": value})
        if kind := _KINDS.get(verdict.verdict):
            told = ElementTree.SubElement(case, kind, {"type": verdict.verdict, "message": _text(verdict.text)})
            told.text = _text(f"{verdict.text}\n{advice}".strip())
        ElementTree.SubElement(case, "system-out").text = _text(verdict.text)
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
    """The text without what XML cannot hold, which is spelt out."""
    return _NO_XML.sub(lambda found: found[0].encode("unicode_escape", "surrogatepass").decode(), text)
