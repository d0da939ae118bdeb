"""Texts made to act where they should only be read: none does in a report or on a terminal, none leads out of a run folder."""

from __future__ import annotations

import json
import re
import shutil
import unicodedata
from collections import Counter
from collections.abc import Callable, Sequence
from functools import lru_cache
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
from markdown_it import MarkdownIt  # comes with rich
from markdown_it.token import Token

from rvjax.errors import FolderError, IncompleteError
from rvjax.report import build, html, markdown
from rvjax.report.blocks import Code, Drawing, Headline, Mark, Named, Section, Table
from rvjax.report.figures import Picture
from rvjax.report.interactive.page_parts import SCRIPTS, script
from rvjax.report.number_format import label
from rvjax.report.plotting import axes
from rvjax.run_folder import Audited, Column, RunDescription, RunFolder
from tests.program import Run
from tests.reliability.texts import PATHS, harmless, printable, quoted, texts
from tests.report.browser import Browser, executable
from tests.report.conftest import make

Shape = Counter[tuple[str, tuple[str, ...]]]
"""How often each element with its attributes stands in a page."""

SAMPLES = 60
REQUIRED = 120
"""Requirements on metrics with such names."""

FOLDERS = (
    "<img src=x onerror=alert(1)>", '" onclick=alert(1) x="', "{{ 7*7 }}{% raw %}", "x`<b>`|\\|<b>", "[x](y)", "\x1b[31mred",
    "x\ny", "\u202ex", "--help", "'; id; '", "-->", "<\\title>", "\udcff", " x ",
)  # fmt: skip
"""Names of folders one within the other, in one path."""


class Page(HTMLParser):
    """What is in a page: elements outside of figures, kinds of elements within, references, words, and scripts that run."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.shape: Shape = Counter()
        self.drawn: set[tuple[str, tuple[str, ...]]] = set()
        self.references: list[str] = []
        self.words: list[str] = []
        self.scripts: list[str] = []
        self.policy = ""
        self.runs = False
        self.depth = 0
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.depth += tag == "svg"
        element = (tag, tuple(sorted(name for name, _ in attrs)))
        if self.depth:
            self.drawn.add(element)
        else:
            self.shape[element] += 1
        given = dict(attrs)
        self.runs = tag == "script" and "type" not in given
        self.scripts += [""] * self.runs
        self.policy += (given.get("content") or "") if given.get("http-equiv") == "Content-Security-Policy" else ""
        self.references += [value or "" for name, value in attrs if name in ("href", "src", "action", "data", "xlink:href")]

    def handle_endtag(self, tag: str) -> None:
        self.depth -= tag == "svg"
        self.runs = self.runs and tag != "script"

    def handle_comment(self, data: str) -> None:
        self.shape[("!--", (data,))] += 1

    def handle_decl(self, decl: str) -> None:
        self.shape[("!", (decl,))] += 1

    def unknown_decl(self, data: str) -> None:
        self.shape[("![", (data,))] += 1

    def handle_pi(self, data: str) -> None:
        self.shape[("?", (data,))] += 1

    def handle_data(self, data: str) -> None:
        if self.runs:
            self.scripts[-1] += data
        elif self.cdata_elem != "script":
            self.words.append(data)

    @property
    def text(self) -> str:
        return "".join(self.words)


def check_page(found: Page, twin: Page) -> None:
    """A page of hostile texts has the elements of its twin, and nothing in it acts or refers to elsewhere."""
    assert found.shape == twin.shape, found.shape - twin.shape
    assert found.drawn <= twin.drawn, found.drawn - twin.drawn
    everything = found.shape.keys() | found.drawn
    assert found.scripts == twin.scripts in ([], [script(name) for name in SCRIPTS])
    assert found.policy == twin.policy
    assert not {tag for tag, _ in everything} & {"iframe", "object", "embed", "img", "image", "link", "base", "form"}
    assert not {name for _, names in everything for name in names if name.startswith("on") or name in ("src", "srcdoc")}
    assert all(re.fullmatch("#[a-zA-Z][a-zA-Z0-9-]*", value) for value in found.references)


@lru_cache(maxsize=2)
def tokens(text: str) -> tuple[Token, ...]:
    """What a reader of CommonMark with tables makes of a text, in order; a page and its twin are read once."""
    blocks = MarkdownIt("commonmark").enable("table").parse(text)
    return tuple(part for token in blocks for part in (token, *(token.children or ())))


def check_markdown(text: str, twin: str) -> None:
    """Markdown of hostile texts has the blocks, marks and pictures of its twin, and no address that a reader makes a link."""
    found, expected = (Counter((one.type, one.tag) for one in tokens(part) if one.nesting >= 0) for part in (text, twin))
    for several in ("text", "text_special", "code_inline"):  # code that would not stay code is text
        for counted in (found, expected):
            counted.pop((several, "code" if several == "code_inline" else ""), None)
    assert found == expected, found - expected
    assert not {"link_open", "html_block", "fence", "code_block"} & {kind for kind, _ in found}
    assert {one.content for one in tokens(text) if one.type == "html_inline"} <= {"<br>"}
    assert all(re.fullmatch(r"figures/[a-z-]+\.svg", str(one.attrs["src"])) for one in tokens(text) if one.type == "image")
    prose = re.sub(r"`[^`\n]+`", "", text)
    assert not re.search(r"(?<!\\)(://|www\.)|<(?!br>)|(?<!\\)\]\((?!figures/)", re.sub(r"\\\\", "", prose), re.IGNORECASE)


def shown(text: str) -> Counter[str]:
    """The pieces of text and code that a reader of Markdown shows."""
    return Counter(one.content.strip() for one in tokens(text) if one.type in ("text", "code_inline"))


def acting(text: str) -> set[str]:
    """Characters that a terminal acts on, other than line ends: controls, line separators, turned directions, surrogates."""
    turning = {"LRE", "RLE", "LRO", "RLO", "PDF", "LRI", "RLI", "FSI", "PDI"}
    return {
        one
        for one in set(text) - {"\n"}
        if unicodedata.category(one) in {"Cc", "Cs", "Zl", "Zp"} or unicodedata.bidirectional(one) in turning
    }


def words(text: str) -> str:
    """As Markdown shows it: blanks as one blank, but for those that keep words together; none around."""
    return re.sub(r"[^\S\u00a0]+", " ", text).strip().replace("\0", "\ufffd")


def required(names: Sequence[str]) -> list[str]:
    """Names of metrics to require something of, first those that a regular expression would read otherwise, or not at all."""
    return sorted((name for name in names if "." not in name), key=lambda name: not set(name) & set("[(*+?"))[:REQUIRED]


def reported(place: Path, all_texts: Sequence[str], file_texts: Sequence[str], names: Sequence[str]) -> Path:
    """A run folder with texts wherever one can be, and its report.

    all_texts: identity, provenance and the recorded command; file_texts, which a campaign file can hold: description, names of
    requirements, overrides; names, of one line: metrics with their units and meanings, some of them required, and draws.
    """
    named = [f"{{metric: captured, at_least: 0.9, name: {quoted(text)}}}" for text in file_texts]
    named += [f"{{metric: {quoted(text)}, below: 1, at_least: 0.5}}" for text in required(names)]
    require = "".join(f"\n  - {requirement}" for requirement in named)
    description = quoted(" ".join(file_texts))
    whole = RunFolder.open(make(place.parent / f"{place.name} (made)", SAMPLES, require=require, description=description))
    frame, columns = whole.samples().frame.copy(), dict(whole.samples().columns)
    noise = np.random.Generator(np.random.Philox(key=7)).uniform(0, 1, (len(names), SAMPLES))
    settling = np.nan_to_num(frame["metric.settling_time_s"].to_numpy(), nan=1e3, posinf=1e3)
    frames: dict[str, Any] = {}
    for number, text in enumerate(names):
        frames[f"metric.{text}"] = noise[number]
        columns[f"metric.{text}"] = Column(f"metric.{text}", text, text, "lower")
        if number < 24:  # such as drive the result: their names are drawn in a figure
            frames[f"draw.{text}"] = settling * (1 + 1e-3 * noise[number])
            columns[f"draw.{text}"] = Column(f"draw.{text}", text, text)
    frame = pd.concat([frame, pd.DataFrame(frames)], axis=1)
    first = all_texts[0]
    identity = {**dict.fromkeys(("seed", "device", "precision", "rvjax"), first), "texts": {text: text for text in all_texts}}
    overrides = [f"description={quoted(text)}" for text in (*file_texts[::16], " ".join(file_texts))]
    provenance = {"started": first, "command": ["rvjax", *all_texts], "overrides": overrides, "host": list(all_texts)}
    text = whole.campaign_text()
    description = RunDescription(identity=identity, provenance=provenance, campaign_text=text, samples=SAMPLES, name="made-up")
    with RunFolder.create(place, description) as folder:
        idle = dict.fromkeys(all_texts, 1)
        folder.keep_audit(Audited(dispersions=len(idle), read_back=1, acting=0, idle=idle, moved={}))
        folder.commit(0, frame, columns)
        histories = whole.envelopes()
        folder.write_envelope(0, histories, {name: Column(name, first, first) for name in histories.columns})
        for sample, trace in ((sample, whole.trace(sample)) for sample in whole.trace_samples()):
            folder.write_traces({sample: (trace, {name: Column(name, first, first) for name in trace.columns})})
    build(place)
    return place


def test_there_are_enough_texts_of_every_kind() -> None:
    assert len(texts()) >= 500
    assert len(printable()) >= 500
    assert len(set(texts())) == len(texts())
    for mark in (
        "<script",
        "onerror=",
        "javascript:",
        "{{",
        "{%",
        "](",
        "../",
        "/etc/passwd",
        "\x1b[",
        "\u202e",
        "\x00",
        "<![CDATA[",
    ):
        assert any(mark in text for text in texts()), mark


def test_a_report_of_hostile_texts_is_one_of_words(tmp_path: Path, rvjax: Run, figure: Callable[[str], None]) -> None:
    """The report has the elements of its twin with harmless texts, and shows every text as it was given.

    Kills: `autoescape=False`; `| safe` at any text; `text` or `_code` of Markdown without one of its escapes; a name from the
    campaign in a figure as text, not as paths, or with its comment left in; a required metric taken for a pattern; a text that
    is cut or changed on its way to summary.json; output of `rvjax check` that is not made visible.
    """
    given = printable()
    names = [text for text in given if words(label(text)) and "\n" not in text]
    hostile = reported(tmp_path.joinpath(*FOLDERS), texts(), given, names)
    twin = reported(tmp_path.joinpath(*harmless(len(FOLDERS))), *(harmless(len(part)) for part in (texts(), given, names)))

    page, like = (Page((folder / "report.html").read_bytes().decode()) for folder in (hostile, twin))
    check_page(page, like)
    assert [text for text in given if text not in page.text] == []
    if executable() is not None:
        with Browser(tmp_path / "profile") as browser:  # an alert would stop it
            browser.open(hostile / "report.html")
            assert browser.console == []
            assert [urlsplit(url).scheme for url in browser.requests] == ["file"]
            shape = "[...document.querySelectorAll('body *')].map((e) => e.tagName)"
            elements = browser.run(f"{shape}.filter((name) => /^(iframe|object|embed|img|link|base|form|meta)$/i.test(name))")
            assert elements == []
    drawings = [ElementTree.parse(path) for path in sorted(hostile.glob("figures/*.svg"))]
    kinds = {element.tag.rpartition("}")[2] for drawing in drawings for element in drawing.iter() if isinstance(element.tag, str)}
    assert kinds <= {"svg", "defs", "g", "path", "use", "style", "clipPath", "rect", "metadata", "RDF", "Work", "title"}, kinds

    document, other = ((folder / "report.md").read_text(encoding="utf-8") for folder in (hostile, twin))
    check_markdown(document, other)
    everything = "\n".join(shown(document))
    assert [text for text in given if words(text) not in everything] == []

    summary = json.loads((hostile / "summary.json").read_bytes(), parse_constant=pytest.fail)
    assert all(
        f": {text}: captured" in requirement["text"] for text, requirement in zip(given, summary["requirements"], strict=False)
    )
    assert summary["requirements"][len(given)]["metric"] == required(names)[0]
    for command in (
        ["check", hostile],
        ["check", hostile, "--json"],
        ["doctor", hostile],
        ["validate", hostile / "campaign.yaml"],
    ):
        code, out, err = rvjax(*command)
        assert code in (0, 1, 2, 3), err
        assert "Traceback" not in err
        assert not acting(out + err), command
    figure(f"injected texts in a report: {len(texts())}, {len(given)} of them in the campaign file; 0 elements injected")


def test_every_text_in_every_place_of_a_page_stays_a_text() -> None:
    """Also texts that no campaign file holds, in captions, heads, labels and cells of every kind.

    Kills: one place of the template, or one kind of cell in Markdown, whose text is not escaped.
    """

    def document(given: Sequence[str]) -> tuple[Headline, list[Section]]:
        everything = "".join(given)
        rows = tuple((text, Code(text), Named(text, text), Mark(text)) for text in given)
        table = Table(everything, ("words", "code", "name", "mark"), rows)
        heads = Table(everything, tuple(given), (tuple(given),))
        drawing = Drawing("drawing", everything, axes(1, 1, 1.0)[0])
        facts = ((everything, Code(everything)), *((text, text) for text in given))
        sections = [Section("first", everything, everything, (table, heads, drawing, *given)), *_titled(given)]
        outcomes = ((everything, 1), ("missing", 0))
        return Headline(everything, everything, Mark(everything), everything, facts, outcomes), sections

    def _titled(given: Sequence[str]) -> list[Section]:
        return [Section(f"s{number}", text, text) for number, text in enumerate(given)]

    encodable = [text for text in texts() if text != "\0\0"]
    pictures = {"drawing": Picture("<svg></svg>", "<svg></svg>", b"")}
    hostile, twin = (html.page(*document(given), pictures) for given in (encodable, harmless(len(encodable))))
    page = Page(hostile)
    check_page(page, Page(twin))
    assert [text for text in encodable if text not in page.text] == []


def test_markdown_shows_every_text_as_it_is() -> None:
    """Each text by itself in each place, read by a reader of Markdown: the words that come out are those that went in.

    Kills: a mark of Markdown that is not escaped, a list or a line at the start of a paragraph, code that a backtick ends,
    a cell that a bar ends.
    """

    def document(given: str) -> str:
        row = (given, Code(given), Named(given, given))
        body = (given, Drawing("drawing", given, drawing), Table(given, ("head", given, "tail"), (row,)))
        top = Headline("campaign", given, Mark("mark"), given, ((given, given),), ())
        return markdown.page(top, [Section("key", given, given, body)])

    drawing = axes(1, 1, 1.0)[0]
    twin = document("word")
    times = shown(twin)["word"]
    for given in texts():
        if expected := words(given):
            found = document(given)
            check_markdown(found, twin)
            code = words(" ".join(given.split()))  # blanks that keep words together are blanks there
            assert sum(shown(found)[one] for one in {expected, code}) == times, given


def tree(root: Path, but: Path) -> dict[Path, bytes]:
    """Every file and folder under a root with its contents, but for one folder."""
    outside = (path for path in root.rglob("*") if but not in (path, *path.parents))
    return {path: path.read_bytes() if path.is_file() else b"" for path in outside}


def test_no_path_leads_out_of_the_run_folder(tmp_path: Path, figure: Callable[[str], None]) -> None:
    """Every text as the name of a file to write, plain and below a folder. Kills: `..`, absolute paths, a name that is a path."""
    run = make(tmp_path / "around" / "run", 20, kept=0)
    before, refused = tree(tmp_path, run), 0
    for text in texts():
        for name in (text, f"figures/{text}"):
            try:
                RunFolder.open(run).write_text(name, "x")
            except (FolderError, IncompleteError):  # a name that leads out, or one that the file system does not take
                refused += 1
    assert tree(tmp_path, run) == before
    assert not Path("/x").exists()
    shutil.rmtree(run / "figures")  # of which no report has noted anything
    for name in ("report.html", "report.md", "summary.json"):
        (run / name).unlink(missing_ok=True)
    RunFolder.open(run).verify()
    assert len(PATHS) < refused < 2 * len(texts())
    figure(f"names of files: {2 * len(texts())}; {refused} refused; 0 written outside the run folder")


@pytest.mark.parametrize("part", ["figures", "quarantine"])
def test_nothing_is_written_through_a_link(tmp_path: Path, part: str) -> None:
    """A folder in the run folder that is a link to elsewhere. Kills: following it."""
    run = make(tmp_path / "run", 20, kept=0)
    outside = tmp_path / "outside"
    outside.mkdir()
    (run / part).symlink_to(outside)
    damaged = next(run.glob("samples/*.parquet"))
    damaged.write_bytes(damaged.read_bytes()[:-1])
    opened = RunFolder.open(run)
    again = RunDescription(
        identity=opened.identity,
        provenance=opened.provenance,
        campaign_text="rvjax: 1\n",
        samples=opened.requested,
        name=opened.name,
    )
    write = {"figures": lambda: opened.write_text("figures/x.svg", "x"), "quarantine": lambda: RunFolder.resume(run, again, 256)}
    with pytest.raises(FolderError, match="leads out of the run folder"):
        write[part]()
    assert list(outside.iterdir()) == []
