"""What the shell offers after a Tab: names and places, read from files as text.

Nothing of rvjax is imported: a Tab must not wait.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

_PACKAGE = Path(__file__).parents[1]
_TABLES = (
    *((folder / "__init__.py", "MEMBERS") for folder in sorted((_PACKAGE / "components").iterdir()) if folder.is_dir()),
    (_PACKAGE / "components" / "manual.py", "CHAPTERS"),
    (_PACKAGE / "campaign" / "distribution_notation.py", "LAWS"),
    (_PACKAGE / "campaign" / "distribution_notation.py", "RADIAL"),
)
"""(module, its table whose keys are names of manual pages)."""

_MOST_BYTES = 128 * 1024


def topics(incomplete: str) -> list[str]:
    """Pages of `rvjax explain`: components, sections of a campaign file, chapters."""
    names = [name for path, table in _TABLES if path.exists() for name in _keys(path, table)]
    names += [entry.name for group in entry_points().groups if group.startswith("rvjax.") for entry in entry_points(group=group)]
    return _starting([*names, *_fields(_PACKAGE / "campaign" / "model.py", "Spec")], incomplete)


def settings(ctx: Any, incomplete: str) -> list[str]:
    """`path=` for --set: the values of the campaign file of the command, else of the starter campaign."""
    file = _given(ctx, ("file", "place", "files")) or _PACKAGE / "cli" / "starter.yaml"
    return _starting((f"{path}=" for path in _paths(_value(file))), incomplete)


def campaigns(incomplete: str) -> list[str]:
    """Campaign files, and folders that may hold some."""
    return _starting(_entries(incomplete, lambda path: path.suffix in (".yaml", ".yml")), incomplete)


def run_folders(incomplete: str) -> list[str]:
    """Run folders below `reports`, and other folders."""
    runs = (str(manifest.parent) for manifest in sorted(Path("reports").glob("*/*/manifest.json")))
    return _starting((*runs, *_entries(incomplete, lambda path: False)), incomplete)


def places(incomplete: str) -> list[str]:
    """Run folders and campaign files."""
    return [*dict.fromkeys((*run_folders(incomplete), *campaigns(incomplete)))]


def samples(ctx: Any, incomplete: str) -> list[str]:
    """The samples of a run folder whose traces are kept."""
    kept = (re.match(r"sample-(\d+)-", path.name) for path in sorted(_run(ctx).glob("traces/sample-*")))
    return _starting((str(int(name[1])) for name in kept if name), incomplete)


def baselines(ctx: Any, incomplete: str) -> list[str]:
    """The baselines inside a run folder."""
    return _starting((path.name for path in sorted(_run(ctx).glob("baselines/*")) if path.is_dir()), incomplete)


def _run(ctx: Any) -> Path:
    return _given(ctx, ("folder",)) or Path()


def _given(ctx: Any, names: tuple[str, ...]) -> Path | None:
    """The argument of the command; it is still among the plain words where the line ends in an option without its value."""
    values = [ctx.params[name] for name in names if ctx.params.get(name)] + [word for word in ctx.args if word[:1] != "-"]
    first = values[0] if values else None
    return Path(first[0] if isinstance(first, (list, tuple)) else first) if first else None


def _starting(names: Any, incomplete: str) -> list[str]:
    return [name for name in dict.fromkeys(names) if name.startswith(incomplete)]


def _entries(incomplete: str, fits: Any) -> Iterator[str]:
    """Folders, with a slash, and the files that fit, in the folder that has been typed."""
    typed = incomplete[: incomplete.rfind("/") + 1]
    try:
        found = sorted(Path(typed or ".").iterdir())
    except OSError:
        return
    for path in found:
        if path.is_dir():
            yield f"{typed}{path.name}/"
        elif fits(path):
            yield f"{typed}{path.name}"


def _keys(path: Path, table: str) -> Iterator[str]:
    """The keys of a dictionary that a module assigns, without running the module."""
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        targets = node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
        if any(isinstance(target, ast.Name) and target.id == table for target in targets):
            value = getattr(node, "value", None)
            for key in value.keys if isinstance(value, ast.Dict) else ():
                if isinstance(key, ast.Constant):
                    yield str(key.value)


def _fields(path: Path, name: str) -> Iterator[str]:
    """The fields that a class declares."""
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.ClassDef) and node.name == name:
            for line in node.body:
                if isinstance(line, ast.AnnAssign) and isinstance(line.target, ast.Name) and line.target.id[0] != "_":
                    yield line.target.id


def _value(file: Path) -> Any:
    """The plain values of a campaign file; None where it cannot be read."""
    from ruamel.yaml import YAML
    from ruamel.yaml.error import YAMLError

    try:
        return YAML(typ="safe").load(file.read_bytes()[:_MOST_BYTES])
    except (OSError, YAMLError, ValueError):
        return None


def _paths(value: Any, before: str = "") -> Iterator[str]:
    """The path of each value: keys, and the name of an entry of a list or else its number."""
    if isinstance(value, dict):
        steps = [(str(key), item) for key, item in value.items()]
    elif isinstance(value, list):
        steps = [*zip(_entry_names(value), value, strict=True)]
    else:
        return
    for step, item in steps:
        yield f"{before}{step}"
        yield from _paths(item, f"{before}{step}.")


def _entry_names(entries: list[Any]) -> Iterator[str]:
    """As `rvjax.campaign.choice.entry_names`; the number of an entry without a name."""
    uses: list[str] = []
    for number, entry in enumerate(entries):
        named = entry if isinstance(entry, dict) else {}
        use = str(named.get("use", ""))
        if named.get("name"):
            yield str(named["name"])
            continue
        uses.append(use)
        yield (use if uses.count(use) == 1 else f"{use}-{uses.count(use)}") if use else str(number)
