"""What CI services read: well-formed whatever is in the texts, on the line of the requirement, one entry for each of them."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
from markdown_it import MarkdownIt

from rvjax.analysis.verdicts import Verdict, judge_all
from rvjax.campaign import Requirement
from rvjax.errors import Finding, visible
from rvjax.report.ci import github
from rvjax.report.ci.junit import junit, of_verdicts
from rvjax.stats.sampling_design import Independent
from tests.program import Run
from tests.reliability.texts import texts
from tests.short import CAMPAIGN, SHORT

QUICK = [part for one in (*SHORT, "controller={use: pd-plus}", "keep={worst: 0}") for part in ("--set", one)]
REQUIRE = (
    "require=[{metric: captured, at_least: 0.5}, {metric: delta_v_m_s, below: 1.0e-6, at_least: 0.5}, "
    "{name: 'is, it: 100 %?', metric: captured, at_least: 0.99}]"
)
NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def verdicts(names: list[str]) -> tuple[Verdict, ...]:
    """PASS, FAIL and UNDECIDED in turn, with these names."""
    forms = ({"at_least": 0.5}, {"at_least": 0.99}, {"at_least": 0.9})
    requirements = [Requirement(metric="captured", name=name, **forms[n % 3]) for n, name in enumerate(names)]  # pyright: ignore
    frame = pd.DataFrame({"sample": np.arange(100), "outcome": ["captured"] * 90 + ["not_settled"] * 10})
    return judge_all(requirements, frame, Independent())


def check_junit(data: bytes) -> ElementTree.Element:
    """The form that Jenkins' and GitLab's readers take; every count adds up."""
    root = ElementTree.fromstring(data)
    assert root.tag == "testsuites"
    for suite in root:
        assert suite.tag == "testsuite"
        cases = list(suite)
        assert {case.tag for case in cases} <= {"testcase"}
        for case in cases:
            assert case.get("classname")
            assert case.get("name")
            tags = [part.tag for part in case]
            assert tags in (
                ["properties", "system-out"],
                ["properties", "failure", "system-out"],
                ["properties", "error", "system-out"],
            )
            for part in case:
                if part.tag in ("failure", "error"):
                    assert part.get("message")
                    assert part.get("type")
            assert all(one.tag == "property" and one.get("name") and one.get("value") is not None for one in case[0])
        for owner in (suite, root):
            assert int(owner.get("tests", -1)) == len(cases)
            assert int(owner.get("failures", -1)) == sum(case.find("failure") is not None for case in cases)
            assert int(owner.get("errors", -1)) == sum(case.find("error") is not None for case in cases)
    return root


def test_junit_has_a_case_for_each_requirement() -> None:
    """Kills: FAIL and UNDECIDED alike, counts that do not add up, a case that is left out."""
    root = check_junit(junit("docking", of_verdicts(verdicts(["a", "b", "c"]), ["", "look here", ""])))
    kinds = [[part.tag for part in case if part.tag in ("failure", "error")] for case in root[0]]
    assert kinds == [[], ["failure"], ["error"]]
    assert "look here" in (root[0][1][1].text or "")
    assert [case.get("name") for case in root[0]] == ["1. a", "2. b", "3. c"]


def test_hostile_texts_are_text_everywhere() -> None:
    """Kills: XML that cannot be read, a line end that begins another command, a mark that acts in the summary."""
    names = ["up\u202edown", "\x9b31mred", *[text for text in texts() if text.strip()][:118]]
    found = verdicts(names)
    root = check_junit(junit("x <&> \x1b]", of_verdicts(found)))
    assert len(root[0]) == len(names)
    for name, case in zip(names, root[0], strict=True):
        assert visible(case.get("name") or "") == case.get("name")
        if not NOT_XML.search(visible(name)):
            assert (case.get("name") or "").endswith(visible(name))
    lines = github.of_verdicts(found, ["dir/a,b:c.yaml:3:5"] * len(found))
    assert len(lines) == sum(verdict.verdict != "PASS" for verdict in found)
    for line in lines:
        assert "\n" not in line
        assert "\r" not in line
        assert re.match(r"::(error|warning) file=dir/a%2Cb%3Ac\.yaml,line=3,col=5,title=[^,:\n]*::", line), line
    table = MarkdownIt("commonmark").enable("table").render(github.summary("<b>x</b> | y", found))
    assert table.count("<tr>") == 1 + len(names)
    assert not re.search(r"<(?!/?(h3|table|thead|tbody|tr|th|td)\b)", table)


def test_bounds_of_the_summary_are_rounded_outwards() -> None:
    """Kills: 90.98 % for a lower bound of 90.976 %."""
    frame = pd.DataFrame({"sample": np.arange(40), "outcome": ["captured"] * 40})
    said = {"metric": "captured", "at_least": 0.9, "method": "sequential"}
    (verdict,) = judge_all([Requirement(**said)], frame, Independent())  # pyright: ignore
    assert verdict.low_bound == pytest.approx(0.909764, abs=1e-6)
    assert "| 100 % | 90.97 % | 100 % | 90 % |" in github.summary("x", [verdict])


def test_findings_are_annotated_where_they_are(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Relative to the checkout. Kills: a path that GitHub cannot match, a finding of an argument that takes a line."""
    monkeypatch.setenv("GITHUB_WORKSPACE", str(tmp_path))
    inside = Finding(f"{tmp_path}/campaigns/a.yaml:7:3", "samples", "found 0", "accepted: at least 1")
    beside = Finding("--set samples=0", "samples", "found 0", "accepted: at least 1")
    first, second = github.of_findings([inside, beside])
    assert first.startswith("::error file=campaigns/a.yaml,line=7,col=3,title=campaign::")
    assert second.startswith("::error title=campaign::--set samples=0")


@pytest.mark.usefixtures("bare")
def test_the_program_tells_the_service(rvjax: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """`check FILE` and `check DIR`. Kills: annotations on another line, outside of GitHub, or in the JSON document; a summary
    that is written over; an exit code that the file changes."""
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(tmp_path / "summary.md"))
    campaign = tmp_path / "a.yaml"
    text = CAMPAIGN.read_text()
    campaign.write_text(
        text[: text.index("require:")] + REQUIRE.replace("=[", ":\n  - ").replace("}, {", "}\n  - {").rstrip("]") + "\n"
    )
    line = 1 + campaign.read_text()[: campaign.read_text().index("delta_v")].count("\n")
    code, out, _ = rvjax("check", campaign, "--out", tmp_path / "run", "--junit-xml", tmp_path / "j.xml", "--quiet", *QUICK)
    assert code == 1
    assert "::error" not in out
    assert not (tmp_path / "summary.md").exists()
    assert len(check_junit((tmp_path / "j.xml").read_bytes())[0]) == 3
    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    code, out, err = rvjax("check", campaign, "--out", tmp_path / "run", "--quiet", *QUICK)
    assert (code, err) == (1, "")
    assert re.search(rf"^::error file=.*a\.yaml,line={line},col=5,title=FAIL", out, re.MULTILINE), out
    assert re.search(
        rf"^::warning file=.*a\.yaml,line={line + 1},col=5,title=UNDECIDED%3A is%2C it%3A 100 %25\?::", out, re.MULTILINE
    )
    code, out, err = rvjax("check", tmp_path / "run", "--json")
    assert code == 1
    assert "::error" in err
    assert "::error" not in out
    assert (tmp_path / "summary.md").read_text().count("### short: 1 PASS, 1 FAIL, 1 UNDECIDED") == 2
    code, out, err = rvjax("check", tmp_path / "run", "--samples", 3)
    assert code == 2
    assert "a run folder is judged without flying" in err
    campaign.write_text(text.replace("samples: 512", "samples: 0"))
    code, out, _ = rvjax("check", campaign)
    assert code == 2
    assert "::error file=" in out
