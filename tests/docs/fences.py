"""The fences of the documents, and what is wrong with one: commands are parsed by the program, YAML is validated in a campaign,
imports are looked up. Nothing is flown here; `test_pages_run.py` does that.
"""

from __future__ import annotations

import ast
import importlib
import re
import shlex
import subprocess
import tomllib
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import typer
from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError

from rvjax.campaign import Spec
from rvjax.cli._app import program

ROOT = Path(__file__).parents[2]
PLACES = ("README.md", "CONTRIBUTING.md", "docs/*.md", "docs/tutorials/*.md")
DOCUMENTS = sorted(path for place in PLACES for path in ROOT.glob(place))
SHELL, SHOWN = ("sh", "bash", "console"), ("text", "matlab")
"""Languages of commands; and of what is shown only: outputs, and a program that is not ours."""

INSTALLERS = ("python3 -m venv", ".venv/bin/pip install", "pip install", "source .venv/bin/activate", ".ci/run", "git ", "cd ")
FILE = re.compile(r"`([\w./-]+)`\n\n?$")
END = re.compile(r"at the end of `([\w./-]+)`:\n\n?$")


@dataclass(frozen=True)
class Fence:
    """document: from the root; line: of its beginning; file, tail: the file that it is, or at whose end it is put, or ""."""

    document: str
    line: int
    language: str
    text: str
    file: str = ""
    tail: str = ""

    def __str__(self) -> str:
        return f"{self.document}:{self.line}"


def fences_of(text: str, document: str = "x.md") -> Iterator[Fence]:
    for match in re.finditer(r"^( *)```(\S*)\n(.*?)^\1```$", text, re.DOTALL | re.MULTILINE):
        before, indent = text[: match.start()], len(match[1])
        lines = [line[indent:] for line in match[3].splitlines(keepends=True)]
        tail, file = END.search(before), FILE.search(before)
        alone = file is not None and before[: file.start()].endswith("\n")
        yield Fence(
            document,
            before.count("\n") + 1,
            match[2],
            "".join(lines),
            file[1] if file and alone else "",
            tail[1] if tail else "",
        )


@cache
def all_fences() -> tuple[Fence, ...]:
    return tuple(
        fence for path in DOCUMENTS for fence in fences_of(path.read_text(encoding="utf-8"), path.relative_to(ROOT).as_posix())
    )


def commands(text: str) -> Iterator[str]:
    """The commands of a fence, without comments; a line that ends with \\ goes on."""
    for line in text.replace("\\\n", " ").splitlines():
        bare = re.sub(r"(^|\s)#.*$", "", line) if "'" not in line else _uncommented(line)
        yield from (part.strip() for part in re.split(r"&&|;(?! *do)", bare) if part.strip())


def _uncommented(line: str) -> str:
    """A line without its comment, where quotes may hold a #."""
    quoted = False
    for place, letter in enumerate(line):
        quoted ^= letter == "'"
        if letter == "#" and not quoted and line[place - 1 : place] in ("", " "):
            return line[:place]
    return line


def wrong(fence: Fence, validate: Callable[[str], str], options: Collection[str]) -> str:
    """What is wrong with a fence, "" if nothing is. validate: of the sections of a campaign, the message; options: of pytest."""
    if fence.language in SHELL:
        if fence.text.startswith("#!"):
            return subprocess.run(["bash", "-n"], input=fence.text, text=True, capture_output=True, check=False).stderr
        return "".join(filter(None, (wrong_command(command, options) for command in commands(fence.text))))
    if fence.language == "yaml":
        return wrong_yaml(fence.text, validate, options)
    if fence.language == "python":
        return wrong_python(fence.text)
    return "" if fence.language in SHOWN else f"a fence of the language {fence.language!r}"


def wrong_command(command: str, options: Collection[str]) -> str:
    """A command with the options that its program has."""
    command = command.removeprefix(".venv/bin/")
    name, *words = shlex.split(command)
    if name == "rvjax":
        return _wrong_options(words)
    if name == "pytest":
        unknown = [word for word in words if word.startswith("--") and word.partition("=")[0] not in options]
        return f"pytest does not have {unknown}" if unknown else ""
    if "install" in words:
        return _wrong_extras(words)
    if name == "python" and words[0] == "-m":
        return "" if find_spec(words[1]) else f"no module {words[1]}"
    if name == "python":
        return "" if (ROOT / words[0]).is_file() else f"no file {words[0]}"
    return "" if f"{command} ".startswith(INSTALLERS) else f"an unknown program: {command}"


def _wrong_options(words: list[str]) -> str:
    group: Any = typer.main.get_command(program())
    if words[0].startswith("--"):
        return "" if words[0] in {"--install-completion", "--version", "--help"} else f"rvjax does not have {words[0]}"
    if words[0] not in group.commands:
        return f"rvjax does not have the command {words[0]}"
    command = group.commands[words[0]]
    known = {spelling for parameter in command.params for spelling in (*parameter.opts, *parameter.secondary_opts)}
    unknown = [word for word in words[1:] if word.startswith("-") and word.partition("=")[0] not in {*known, "--help", "-h"}]
    if unknown:
        return f"rvjax {words[0]} does not have {unknown}"
    try:
        command.make_context(words[0], [word for word in words[1:] if not word.startswith("$ARG")])
    except Exception as error:  # noqa: BLE001  (typer may bring its own copy of click, and so of its errors)
        return f"rvjax {' '.join(words)}: {error!r}"
    return ""


def _wrong_extras(words: list[str]) -> str:
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    named = {name for word in words for group in re.findall(r"\[(.*)\]", word) for name in group.split(",")}
    return f"no extra {named - set(extras)}" if named - set(extras) else ""


def wrong_yaml(text: str, validate: Callable[[str], str], options: Collection[str]) -> str:
    """Sections of a campaign; of any other file, its commands."""
    try:
        documents = list(YAML(typ="safe").load_all(text))
    except YAMLError as error:
        return str(error)
    if set(documents[0]) <= set(Spec.keys()):
        return validate(text)
    lines = re.findall(r"^\s*- run: (.*)$", text, re.MULTILINE)
    return "".join(filter(None, (wrong_command(line, options) for line in lines)))


def wrong_python(text: str) -> str:
    """Names that are imported from this package exist."""
    try:
        tree = ast.parse(text)
    except SyntaxError as error:
        return str(error)
    lost = ""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] == "rvjax":
            module = importlib.import_module(node.module or "")
            lost += "".join(f"no {name.name} in {node.module}; " for name in node.names if not hasattr(module, name.name))
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "rvjax":
            lost += "" if hasattr(importlib.import_module("rvjax"), node.attr) else f"no rvjax.{node.attr}; "
    return lost
