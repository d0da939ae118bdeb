"""Writes the reference pages of the site into docs/generated: from the manual pages, the commands and the docstrings.

`conf.py` calls it before Sphinx looks for pages. Nothing here is kept in git, so no page can be older than the program.
"""

from __future__ import annotations

import inspect
import re
import shutil
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
GENERATED = ROOT / "docs" / "generated"
FAMILIES = (
    *("controllers", "faults", "disturbances", "navigation", "guidance", "saturations", "actuators", "allocations"),
    *("effects", "metrics", "samplers", "searches"),
)
PROJECT = {"changelog": "CHANGELOG.md", "contributing": "CONTRIBUTING.md", "security": "SECURITY.md"}
"""Page of the site → file at the root of the repository."""


def cell(text: str) -> str:
    """Text in a cell of a Markdown table, as it stands; `code` stays code."""
    parts = re.split(r"(`[^`]*`)", text.replace("\n", " "))
    escaped = [part if part[:1] == "`" else re.sub(r"([\\*_<>\[\]$#~{}])", r"\\\1", part) for part in parts]
    return "".join(escaped).replace("|", "\\|") or " "


def table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table. The first column holds names; the others hold text."""
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    for name, *rest in rows:
        lines.append(f"| {cell(f'`{name}`')} | " + " | ".join(map(cell, rest)) + " |")
    return "\n".join(lines)


def fence(language: str, text: str) -> str:
    return f"```{language}\n{text.rstrip()}\n```"


def entry(page: Any) -> Iterator[str]:
    """A manual page as Markdown: equations as they stand in the source, keys, examples."""
    yield f"## {page.name}"
    if "." in page.origin:
        yield f"`{page.origin}`"
    if page.text:
        yield fence("text", page.text)
    if page.members:
        yield table(("member", "description"), page.members)
    for heads, rows in page.tables:
        yield table(heads, rows)
    for example in page.examples:
        yield fence("yaml", example.yaml)
        for name, text in example.files.items():
            yield f"`{name}`:"
            yield fence("text", text)


def component_pages() -> Iterator[tuple[str, str]]:
    """(file, text) of a page for each family."""
    from rvjax.components import manual
    from rvjax.components.manual_lookup import pages_called

    for family in FAMILIES:
        names = [page.name for page in manual.component_pages() if page.family == family]
        parts = [
            f"# {family.capitalize()}",
            f"The same on a terminal: `rvjax explain {names[0]}`. Units are SI unless a key says so.",
        ]
        for name in names:
            for page in pages_called(name):
                if (page.family, page.name) == (family, name):
                    parts.extend(entry(page))
        yield f"{family}.md", "\n\n".join(parts)


def equation_pages() -> Iterator[tuple[str, str]]:
    """(file, text) of the pages of equations and of distributions."""
    from rvjax.campaign.distribution_notation import forms
    from rvjax.components import manual

    chapters = [
        "# Equations",
        "Modules that hold equations and belong to no family. The same on a terminal: `rvjax explain dynamics`.",
    ]
    for name in manual.CHAPTERS:
        chapters.extend(entry(manual.chapter(name)))
    yield "equations.md", "\n\n".join(chapters)
    laws = ["# Distributions", "How a draw is written in a campaign. The same on a terminal: `rvjax explain weibull`."]
    for name in forms():
        laws.extend(entry(manual.distribution(name)))
    yield "distributions.md", "\n\n".join(laws)


def keys_page() -> Iterator[tuple[str, str]]:
    """Every key of a campaign file, a section after the other."""
    from rvjax.campaign import Spec
    from rvjax.components.manual_lookup import CAMPAIGN_FILE, FAMILY, pages_called

    parts = ["# Campaign keys", "Every key of a campaign file. [Campaigns](../campaigns.md) explains how they work together."]
    for section in list(Spec.keys()):
        pages = [page for page in pages_called(section) if page.family in (CAMPAIGN_FILE, FAMILY)]
        for page in pages[:1]:
            parts.extend([f"## {section}", page.text, *list(entry(replace(page, text="")))[1:]])
    yield "keys.md", "\n\n".join(parts)


def commands_page() -> Iterator[tuple[str, str]]:
    """Every command with its arguments and options."""
    from typer.main import get_command

    from rvjax.cli._app import COMMANDS, program

    group: Any = get_command(program())
    parts = ["# Commands", "`rvjax COMMAND --help` says the same.", group.epilog or ""]
    for name in COMMANDS:
        command = group.commands[name]
        arguments = [_spelling(parameter) for parameter in command.params if _is_argument(parameter)]
        usage = " ".join(["rvjax", name, "[OPTIONS]", *arguments])
        parts += [f"## rvjax {name}", inspect.cleandoc(command.help or ""), fence("text", usage)]
        rows = [(_spelling(p), p.help or "", _default(p)) for p in command.params if not getattr(p, "hidden", False)]
        parts.append(table(("argument or option", "meaning", "default"), rows))
    yield "commands.md", "\n\n".join(parts)


def _is_argument(parameter: Any) -> bool:
    return parameter.param_type_name == "argument"


def _spelling(parameter: Any) -> str:
    if _is_argument(parameter):
        return parameter.metavar or parameter.name.upper()
    return ", ".join(sorted((*parameter.opts, *parameter.secondary_opts), key=len))


def _default(parameter: Any) -> str:
    value = parameter.default
    plain = value is not None and not callable(value) and value not in (False, ()) and "Sentinel" not in type(value).__name__
    return str(value) if plain else ""


def python_page() -> Iterator[tuple[str, str]]:
    """The public names with signatures and docstrings."""
    import rvjax
    import rvjax.components
    import rvjax.testing

    parts = ["# Python", "Everything else may move. [From Python](../python.md) shows how to use it."]
    for module in (rvjax, rvjax.components, rvjax.testing):
        parts.append(f"## {module.__name__}")
        for name in module.__all__:
            if not name.startswith("__"):
                parts.extend(_documented(f"{module.__name__}.{name}", getattr(module, name)))
    yield "api.md", "\n\n".join(parts)


def _documented(name: str, value: Any) -> Iterator[str]:
    yield f"### {name}"
    yield fence("python", f"{name.rpartition('.')[2]}{signature(value)}")
    yield fence("text", inspect.getdoc(value) or "")
    if inspect.isclass(value):
        rows = [
            (f"{key}{signature(member) if callable(member) else ''}", (inspect.getdoc(member) or "").partition("\n\n")[0])
            for key, member in vars(value).items()
            if not key.startswith("_") and (inspect.isfunction(member) or isinstance(member, property))
        ]
        if rows:
            yield table(("member", "meaning"), rows)


def signature(value: Any) -> str:
    """As the source has it, without the quotes of annotations and without self."""
    try:
        text = str(inspect.signature(value))
    except (TypeError, ValueError):
        return ""
    return re.sub(r" at 0x[0-9a-f]+", "", text.replace("'", "").replace("(self, ", "(").replace("(self)", "()"))


def project_pages() -> Iterator[tuple[str, str]]:
    """The changelog and its neighbours, whose links point from the root of the repository."""
    for page, file in PROJECT.items():
        text = (ROOT / file).read_text(encoding="utf-8")
        text = re.sub(r"\]\(docs/", "](../", text)
        for other, name in PROJECT.items():
            text = text.replace(f"]({name}", f"]({other}.md")
        yield f"{page}.md", text


MAKERS: tuple[Callable[[], Iterator[tuple[str, str]]], ...] = (
    *(keys_page, commands_page, python_page, component_pages, equation_pages, project_pages),
)


def pages() -> dict[str, str]:
    """File below docs/generated → text."""
    return {file: f"{text.rstrip()}\n" for make in MAKERS for file, text in make()}


def write() -> None:
    """Replaces docs/generated. A page that has not changed keeps its time, so that Sphinx does not read it again."""
    made = pages()
    GENERATED.mkdir(exist_ok=True)
    for path in GENERATED.iterdir():
        if path.name not in made:
            shutil.rmtree(path) if path.is_dir() else path.unlink()
    for name, text in made.items():
        path = GENERATED / name
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    write()
