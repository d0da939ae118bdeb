"""Python files that a campaign names as components: `use: ./my_law.py`, or `use: ./laws.py:SlidingPid` for an object in it.

The file, and every module that it imports from beside it, are read once. These bytes are what is digested, kept in the run
folder, sent to other machines and executed (`rvjax.components.user_code`). Nothing is executed here.
"""

from __future__ import annotations

import ast
import hashlib
import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path, PurePosixPath
from types import MappingProxyType
from typing import Any, Self

from rvjax.campaign.csv_files import mappings_with
from rvjax.campaign.named_files import NamedFiles, RefusedFile, plain_path
from rvjax.campaign.plain_values import Place
from rvjax.campaign.short_choices import short_choices
from rvjax.campaign.source import Source
from rvjax.errors import CampaignError, Finding

KEY = "use"
ACCEPTED = "accepted: the name of a component, or ./FILE.py with a component, in the campaign's folder or below it"
_CELL = re.compile(r"cell_[0-9a-f]{8}\.py")
ACCEPTED_PATH = "accepted: a Python file, FILE.py, or FILE.py:NAME for an object in it"
_FORM = re.compile(r"(?P<file>.*\.py)(?::(?P<member>[A-Za-z_][A-Za-z0-9_]*))?")
_WORD = re.compile(r"(?<=[a-z0-9])(?=[A-Z])|[^A-Za-z0-9]+")


class PythonFile(str):
    """The value of `use` with the file that it names.

    file: its name in the campaign's folder. member: the object in it, "" for its only component. folder: of the campaign.
    sources: the bytes of the file and of the modules that it imports from beside it, by name.
    """

    file: str
    member: str
    folder: str
    sources: Mapping[str, bytes]

    def __new__(
        cls, text: str, file: str = "", member: str = "", folder: str = "", sources: Mapping[str, bytes] | None = None
    ) -> Self:
        made = super().__new__(cls, text)
        made.file, made.member, made.folder = file, member, folder
        made.sources = MappingProxyType(dict(sources or {}))
        return made

    @property
    def digests(self) -> dict[str, str]:
        """The first 16 digits of the SHA-256 of each source, by name."""
        return {name: hashlib.sha256(data).hexdigest()[:16] for name, data in sorted(self.sources.items())}

    @property
    def digest(self) -> str:
        """One digest of all sources."""
        return hashlib.sha256(repr((self.file, self.digests)).encode()).hexdigest()[:16]

    def path(self, source: str) -> str:
        """Where a source is, for people."""
        return NamedFiles(Path(self.folder), {}).path(source)


def is_python_file(use: str) -> bool:
    """Whether a value of `use` is meant as a file."""
    return "/" in use or _FORM.fullmatch(use) is not None


def short_name(use: str) -> str:
    """The name of a component from a file: `./my_law.py` → my-law, `./laws.py:SlidingPid` → sliding-pid."""
    match = _FORM.fullmatch(use)
    word = (match["member"] or PurePosixPath(match["file"]).stem) if match else use
    return "-".join(part.lower() for part in _WORD.split(word) if part)


def read_file(path: str | Path) -> PythonFile:
    """A file by its path, `my_law.py` or `my_law.py:NAME`, with what it imports. Errors: CampaignError."""
    text = str(path)
    match = _FORM.fullmatch(text)
    place = Path(match["file"] if match else text)
    use = f"./{place.name}" + (f":{match['member']}" if match and match["member"] else "")
    return _refusing(use, NamedFiles(place.parent, {}), text)


def _refusing(use: str, files: NamedFiles, shown: str) -> PythonFile:
    """`_read`, with CampaignError instead of RefusedFile. shown: the file, for people."""
    try:
        return _read(use, files, ACCEPTED_PATH)
    except RefusedFile as refused:
        raise CampaignError([Finding(refused.where or shown, "", refused.message, refused.accepted)]) from None


def read_cell(text: str, member: str, folder: Path) -> PythonFile:
    """The source of a notebook cell as a file of a folder, named by its bytes, with what it imports from there. Errors:
    CampaignError."""
    data = text.encode()
    name = f"cell_{hashlib.sha256(data).hexdigest()[:8]}.py"
    return _refusing(f"./{name}:{member}", NamedFiles(folder, {name: data}), name)


def is_cell(name: str) -> bool:
    """Whether a file is a cell, by its name."""
    return _CELL.fullmatch(name) is not None


def attach_code(source: Source, files: NamedFiles) -> list[Finding]:
    """Replaces the name of every component that means a file by a `PythonFile`; returns a finding for each file that cannot be
    read. Such a value stays a text."""
    findings: list[Finding] = []
    for place, mapping in _choices(source.value):
        use = mapping[place[-1]]
        if not isinstance(use, str) or not is_python_file(use):
            continue
        try:
            mapping[place[-1]] = _read(use, files)
        except RefusedFile as refused:
            finding = source.finding(place, refused.message, refused.accepted)
            findings.append(Finding(refused.where, "", refused.message, refused.accepted) if refused.where else finding)
    return findings


def _choices(campaign: Any) -> list[tuple[Place, dict[Any, Any]]]:
    """(place, the mapping that holds it) of every name of a component: the values of `use`, and the names that stand alone."""
    return [*(((*place, KEY), mapping) for place, mapping in mappings_with(KEY, campaign)), *short_choices(campaign)]


def _read(use: str, files: NamedFiles, accepted: str = ACCEPTED) -> PythonFile:
    """The file and all modules that it imports from beside it. accepted: where it cannot be read."""
    match = _FORM.fullmatch(use)
    if match is None:
        raise RefusedFile(f"found {use!r}, which does not end in .py", accepted)
    file = plain_path(match["file"], accepted)
    root = PurePosixPath(file).parent
    sources: dict[str, bytes] = {}
    todo = [file]
    while todo:
        name = todo.pop()
        if name not in sources:
            sources[name] = files.read(name, accepted)
            path = files.path(name)
            todo += _beside(_parsed(sources[name], path), PurePosixPath(name), root, files)
    return PythonFile(str(use), file, match["member"] or "", str(files.folder), sources)


def _parsed(data: bytes, path: str) -> ast.Module:
    try:
        return ast.parse(data, filename=path)
    except SyntaxError as error:
        raise RefusedFile(f"syntax error: {error.msg}", "accepted: Python", f"{path}:{error.lineno or 1}") from None
    except (ValueError, RecursionError, MemoryError) as error:
        raise RefusedFile(f"not Python: {error}", "accepted: Python", f"{path}:1") from None


def _beside(tree: ast.Module, name: PurePosixPath, root: PurePosixPath, files: NamedFiles) -> Iterator[str]:
    """Names of the files beside a module that its import statements may execute, wherever they stand in it."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            wanted = [(root, alias.name) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = root if not node.level else name.parents[node.level - 1] if node.level <= len(name.parents) else root
            module = f"{node.module}." if node.module else ""
            wanted = [(base, node.module)] if node.module else []
            wanted += [(base, f"{module}{alias.name}") for alias in node.names]
        else:
            continue
        for base, dotted in wanted:
            yield from _files_of(base, str(dotted), files)


def _files_of(base: PurePosixPath, dotted: str, files: NamedFiles) -> Iterator[str]:
    """The file of a module and the `__init__.py` of every package around it, as far as they exist."""
    steps = dotted.split(".")
    for length in range(1, len(steps) + 1):
        place = base.joinpath(*steps[:length])
        for candidate in (place / "__init__.py", place.with_name(f"{place.name}.py")):
            if files.exists(os.path.normpath(candidate.as_posix())):
                yield os.path.normpath(candidate.as_posix())
                break
