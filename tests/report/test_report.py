"""The report from a run folder: what it shows adds up, nothing in it acts, and the same folder gives the same bytes."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Callable
from contextlib import AbstractContextManager
from html.parser import HTMLParser
from pathlib import Path

import pytest

from rvjax.errors import FolderError
from rvjax.report import build, sections
from rvjax.report.interactive.page_parts import SCRIPTS
from rvjax.run_folder import Audited, RunFolder

Make = Callable[..., Path]
Within = Callable[[], AbstractContextManager[None]]

HOSTILE = """</title><script>alert(1)</script><img src=x onerror=alert(1)> "'`|]]> --> ${{7*7}} {% raw %} $\\frac$ 名 🚀"""


class Page(HTMLParser):
    """Counts elements, and keeps attributes and the visible text, without scripts and data."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: Counter[str] = Counter()
        self.attributes: list[tuple[str, str]] = []
        self.words: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements[tag] += 1
        self.attributes += [(name, value or "") for name, value in attrs]

    def handle_data(self, data: str) -> None:
        if self.cdata_elem != "script":
            self.words.append(data)

    @property
    def text(self) -> str:
        return " ".join(" ".join(self.words).split())


def test_accounting_shown_adds_up_to_what_was_requested(report: Path) -> None:
    """Mutation killed: leaving the missing or the not-finite samples out of the account."""
    text = Page((report / "report.html").read_text()).text
    account = r"(\d+) captured \+ (\d+) not settled \+ (\d+) collided \+ (\d+) not finite \+ (\d+) missing = (\d+) requested"
    found = [tuple(map(int, counts)) for counts in re.findall(account, text)]
    assert found == [(288, 9, 0, 3, 12, 312)] * 2  # at the top and in the section on outcomes
    assert sum(found[0][:-1]) == found[0][-1]
    summary = json.loads((report / "summary.json").read_text())["account"]
    assert sum(value for name, value in summary.items() if name != "requested") == summary["requested"] == 312


def test_every_number_in_the_summary_has_its_interval(report: Path) -> None:
    """Mutation killed: a point estimate, or an interval that does not hold its value. null stands for infinity."""
    numbers = json.loads((report / "summary.json").read_text())["numbers"]
    assert len(numbers) > 100
    for name, number in numbers.items():
        low, value, high = number["low"], number["value"], number["high"]
        assert value is None or low is None or low <= value, name
        assert value is None or high is None or value <= high, name
        assert value is not None or None in (low, high), name
        assert number["n"] > 0, name
        assert 0 < number["confidence"] < 1, name
        assert number["method"], name
        assert number["unit"], name


def test_not_finite_samples_count_as_the_worst(report: Path) -> None:
    """Mutation killed: dropping NaN before a quantile. 12 of 300 never settle, so 99 % never settle either."""
    numbers = json.loads((report / "summary.json").read_text())["numbers"]
    assert numbers["settling_time_s.q99"]["value"] is None
    assert numbers["settling_time_s.q90"]["value"] is not None
    assert all(number["n"] == 300 for name, number in numbers.items() if ".q" in name and name.startswith("settling"))
    assert numbers["settling_time_s.never.share"]["value"] == 12 / 300


def test_a_rebuilt_report_is_byte_identical(report: Path) -> None:
    """Mutation killed: a date, a random id or an unsorted set in the output."""

    def contents() -> dict[str, bytes]:
        made = [*report.glob("report.*"), *report.glob("figures/*"), report / "summary.json"]
        return {path.name: path.read_bytes() for path in made}

    before = contents()
    build(report)
    assert len(before) > 10
    assert contents() == before


def test_page_needs_nothing_beside_itself(report: Path) -> None:
    """Mutation killed: a font, a script, an image or a style sheet by reference; a lost content security policy."""
    whole = (report / "report.html").read_text()
    text = re.sub(r"<script [^>]*>.*?</script>", "", whole, flags=re.DOTALL)  # tests/report/test_page_parts.py looks at these
    page = Page(text)
    assert not page.elements.keys() & {"script", "link", "iframe", "object", "img", "base", "form", "image"}
    assert "default-src 'none'" in text
    assert not [value for name, value in page.attributes if name in ("href", "src", "action") and value[:1] != "#"]
    assert not re.findall(r"url\((?!#)", text)
    assert not re.findall(r"https?:|@import|//", re.sub("'sha256-[^']*'", "", text))  # a hash in base64 may have //
    ids = [value for name, value in page.attributes if name == "id"]
    assert len(ids) == len(set(ids))
    assert {value[1:] for name, value in page.attributes if name == "href"} <= set(ids)
    assert not {name for name, _ in Page(whole).attributes} & {"src", "action", "srcset", "integrity"}


def test_hostile_texts_inject_nothing(made: Make, tmp_path: Path, svg_only: Within) -> None:
    """Mutation killed: autoescape off, text of the campaign in a figure as markup, or data that can end their element."""
    require = f"\n  - {{metric: captured, at_least: 0.9, name: {json.dumps(HOSTILE, ensure_ascii=False)}}}\n"
    description = json.dumps(HOSTILE, ensure_ascii=False)
    folder = made(tmp_path / "<b>&'run'", 40, require=require, description=description)
    with svg_only():
        text = build(folder).read_text()
    page = Page(text)
    assert not page.elements.keys() & {"img", "b", "raw"}
    ids = re.findall(r'<script id="([a-z0-9-]+)"', text)
    known = "|".join((*(f"script-{name}" for name in SCRIPTS), r"(replay|samples)-about", "samples-data", r"(flight|clock)-\d+"))
    assert len(ids) == len(set(ids)) == page.elements["script"] == text.count("<script") > len(SCRIPTS)
    assert all(re.fullmatch(known, name) for name in ids)
    assert page.elements["title"] == page.elements["html"] == page.elements["h1"] == 1
    assert not {name for name, _ in page.attributes if name.startswith("on")}
    assert page.text.count("</title><script>alert(1)</script><img src=x onerror=alert(1)>") >= 2
    data = re.findall(r'type="application/json">(.*?)</script>', text, re.DOTALL)
    assert len(data) == 2
    assert not set("".join(data)) & set("<>&")  # the path of the folder is in it
    markdown = (folder / "report.md").read_text()
    assert not re.search(r"<(?!br>)", re.sub(r"`[^`\n]*`", "", markdown))


@pytest.mark.parametrize(
    ("samples", "shares"),
    [(40, (0, 1, 0)), (40, (0, 0, 1)), (1, (1, 0, 0)), (1, (0, 0, 1))],
    ids=["none captured", "all not finite", "one captured", "one not finite"],
)
def test_extreme_runs_have_a_report(made: Make, tmp_path: Path, samples: int, shares: tuple[float, ...], full: bool) -> None:
    """Mutation killed: an axis, a quantile or a rank that needs a finite value or two samples."""
    if (samples > 1) == (shares[2] == 1) and not full:
        pytest.skip("many that did not settle and one that is not finite by default: --long")
    folder = made(tmp_path / "run", samples, shares, kept=min(samples, 5))
    text = Page(build(folder).read_text()).text
    assert f"= {samples} requested" in text
    assert "nan" not in re.findall(r"\w+", text.lower())


def test_all_captured_without_requirement_or_histories(made: Make, tmp_path: Path, undrawn: Within) -> None:
    with undrawn():
        text = Page(build(made(tmp_path / "run", 40, (1, 0, 0), require="", kept=0)).read_text()).text
    assert "states no requirement" in text
    assert "Flights over time" not in text


def test_the_report_is_built_without_jax(made: Make, tmp_path: Path) -> None:
    """Mutation killed: an import of JAX, direct or not, anywhere below the report."""
    folder = made(tmp_path / "run", 3, kept=0)
    blocked = "import sys; sys.modules['jax'] = None; sys.modules['jaxlib'] = None"
    done = subprocess.run(
        [sys.executable, "-c", f"{blocked}; from rvjax.report import build; build({str(folder)!r})"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert (folder / "report.html").stat().st_size > 10_000


def test_a_damaged_folder_is_refused(made: Make, tmp_path: Path) -> None:
    folder = made(tmp_path / "run", 3, kept=0)
    (folder / "campaign.yaml").write_text("name: other\n")
    with pytest.raises(FolderError, match="damaged or edited"):
        build(folder)


def test_the_audit_is_one_sentence_of_both_reports(made: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In the section on where the samples come from. Kills: a record that nobody gets to see; silence where there is none."""
    monkeypatch.setattr(sections, "SECTIONS", (sections.provenance.section,))
    folder = made(tmp_path / "run", 20)
    build(folder)
    nothing = "This folder has no record of an audit of its dispersions."
    assert nothing in (folder / "report.md").read_text()
    assert nothing in Page((folder / "report.html").read_text()).text
    with RunFolder.open(folder) as opened:
        opened.keep_audit(Audited(dispersions=2, read_back=5, acting=1, idle={"start.nu_m_s": 9}, moved={"start.sigma": "nu.x"}))
    build(folder)
    assert "2 dispersions were audited: 5 drawn columns were read back" in (folder / "report.md").read_text()
    text = Page((folder / "report.html").read_text()).text
    assert "and 1 acted when moved alone; without an effect, as audit.allow permits: start.nu_m_s." in text
    assert nothing not in text


def test_markdown_has_the_same_numbers_as_the_page(report: Path) -> None:
    """Mutation killed: a table written for one format only."""
    markdown, page = ((report / f"report.{kind}").read_text() for kind in ("md", "html"))
    intervals = re.findall(r"\[([^\[\]]* … [^\[\]]*?)\\\]", markdown)
    assert len(intervals) > 100
    assert intervals == re.findall(r'<span class="interval">([^<]*)</span>', page)
