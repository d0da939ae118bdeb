"""What the documents promise exists: links, anchors, files, commands, exit codes."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from typer.main import get_command

import rvjax
from rvjax.cli._app import program

ROOT = Path(__file__).parents[2]
PLACES = ("*.md", "docs/*.md", "docs/tutorials/*.md", "reports/*.md", ".github/*.md")
DOCUMENTS = sorted(path for place in PLACES for path in ROOT.glob(place))

each_document = pytest.mark.parametrize("document", DOCUMENTS, ids=[path.name for path in DOCUMENTS])


def anchors(document: Path) -> set[str]:
    """The anchors that GitHub gives to the headings of a document."""
    text = re.sub(r"```.*?```", "", document.read_text(encoding="utf-8"), flags=re.DOTALL)
    headings = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@each_document
def test_links_and_anchors_exist(document: Path) -> None:
    text = document.read_text(encoding="utf-8")
    missing = []
    for target in re.findall(r"\]\(([^)]+)\)", text):
        if "://" in target:
            continue
        file, _, anchor = target.partition("#")
        path = document.parent / file if file else document
        if not path.exists() or (anchor and anchor not in anchors(path)):
            missing.append(target)
    assert missing == []


@each_document
def test_files_exist(document: Path) -> None:
    text = document.read_text(encoding="utf-8")
    named = re.findall(r"(?<![\w/.-])((?:campaigns|tests|rvjax|docs|benchmarks|\.github/workflows)/[\w./-]*\w)", text)
    illustrations = {"campaigns/x.yaml", "campaigns/NAME.yaml", "campaigns/tuning/NAME.yaml", "campaigns/scenes/NAME.yaml"}
    assert [name for name in named if not (ROOT / name).exists() and name not in illustrations] == []


@each_document
def test_modules_exist(document: Path) -> None:
    """Dotted names of this package and of the benchmarks."""
    text = document.read_text(encoding="utf-8")
    named = re.findall(r"(?<![\w./])((?:rvjax|benchmarks)(?:\.[a-z_]+)+)", text)
    groups = re.findall(r"`(rvjax\.\w+)`", text) if document.name in ("CONTRIBUTING.md", "extending.md") else []
    files = ("md", "yaml", "sh", "xml", "html")
    assert [name for name in named if name not in groups and name.split(".")[1] not in files and not resolves(name)] == []


def resolves(name: str) -> bool:
    """Whether a dotted name is a module, or a name that stands in one."""
    parts = name.split(".")
    for length in range(len(parts), 0, -1):
        path = ROOT.joinpath(*parts[:length])
        source = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
        if source.exists():
            rest = parts[length:]
            return not rest or (len(rest) == 1 and rest[0] in re.findall(r"\w+", source.read_text(encoding="utf-8")))
    return False


@each_document
def test_commands_exist(document: Path) -> None:
    known = set(get_command(program()).commands)
    code = re.findall(r"```sh\n.*?```|`[^`\n]+`", document.read_text(encoding="utf-8"), re.DOTALL)
    used = {command for part in code for command in re.findall(r"(?<!--)\brvjax ([a-z]+)", part)}
    assert used <= known


def test_the_index_links_every_document_once() -> None:
    """The navigation of the site is that of the index. Kills: a page that no reader reaches."""
    docs = ROOT / "docs"
    linked = re.findall(r"^- \[.*?\]\(([\w./-]+\.md)\)", (docs / "index.md").read_text(encoding="utf-8"), re.MULTILINE)
    written = [path.relative_to(docs).as_posix() for place in ("*.md", "tutorials/*.md") for path in docs.glob(place)]
    assert sorted(link for link in linked if not link.startswith("../")) == sorted(name for name in written if name != "index.md")


def test_the_readme_is_short_and_leads_to_the_documentation() -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(readme.splitlines()) <= 120
    assert {"(docs/start.md)", "(docs/index.md)", "(docs/approach.svg)"} <= set(re.findall(r"\(docs/[\w.]+\)", readme))


def test_every_campaign_is_described() -> None:
    page = (ROOT / "docs" / "shipped.md").read_text(encoding="utf-8")
    assert [path.name for path in (ROOT / "campaigns").glob("*.yaml") if path.name not in page] == []


def test_ci_runs_the_command_of_the_readme() -> None:
    readme, script = (ROOT / "README.md").read_text(encoding="utf-8"), (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    command = re.search(r'^command="(.*)"$', script, re.MULTILINE)
    assert command is not None
    assert command[1] in readme.splitlines()
    assert command[1] in (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").splitlines()


def test_citation_has_the_version() -> None:
    assert f"\nversion: {rvjax.__version__}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
