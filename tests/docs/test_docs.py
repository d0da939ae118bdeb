"""What the documents promise exists: links, files, commands, metrics."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from typer.main import get_command

from rvjax.cli._app import program

ROOT = Path(__file__).parents[2]
DOCUMENTS = [ROOT / "README.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").glob("*.md"))]


@pytest.mark.parametrize("document", DOCUMENTS, ids=[path.name for path in DOCUMENTS])
def test_links_and_files_exist(document: Path) -> None:
    text = document.read_text()
    linked = [target for target in re.findall(r"\]\(([^)#]+)\)", text) if "://" not in target]
    named = re.findall(r"`((?:campaigns|tests|rvjax|docs)/[\w./-]+)`", text)
    missing = [target for target in linked if not (document.parent / target).exists()]
    missing += [name for name in named if not (ROOT / name).exists()]
    assert not missing


@pytest.mark.parametrize("document", DOCUMENTS, ids=[path.name for path in DOCUMENTS])
def test_commands_exist(document: Path) -> None:
    known = set(get_command(program()).commands)
    code = re.findall(r"```sh\n.*?```|`[^`\n]+`", document.read_text(), re.DOTALL)
    used = {command for part in code for command in re.findall(r"(?<!--)\brvjax ([a-z]+)", part)}
    assert used <= known


def test_ci_runs_the_command_of_the_readme() -> None:
    readme, script = (ROOT / "README.md").read_text(), (ROOT / ".ci" / "run").read_text()
    command = re.search(r'^command="(.*)"$', script, re.MULTILINE)
    assert command is not None
    assert command[1] in readme.splitlines()
