"""What was made from the data (report, summary, figures) and its SHA-256, in the form that `sha256sum -c SHA256SUMS` reads."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

from rvjax.run_folder import atomic_files

NAME = "SHA256SUMS"

_MADE = re.compile(r"report\.html|report\.md|summary\.json|judged\.parquet|search\.json|candidates\.csv|best\.yaml|figures/.+")
_LINE = re.compile(r"([0-9a-f]{64})  (\S.*)")
_ADVICE = "`rvjax report` makes it again"


def seal(root: Path, made: Mapping[str, str]) -> None:
    """Notes the SHA-256 of files by their names; figures of an earlier report that this one does not have are removed."""
    atomic_files.replace(root / NAME, "".join(f"{digest}  {name}\n" for name, digest in sorted(made.items())).encode())
    for name in _there(root) - made.keys():
        with atomic_files.explained(root / name):
            (root / name).unlink()


def complaints(root: Path) -> list[str]:
    """One for each file that is not as it was made; none where nothing was made."""
    path = root / NAME
    there = _there(root)
    if not atomic_files.exists(path):
        return [f"{path}: missing, so nothing says whether the report is whole; {_ADVICE}"] if there else []
    data = atomic_files.read(path)
    lines = [_LINE.fullmatch(line) for line in data.decode(errors="replace").splitlines()]
    noted = {match[2]: match[1] for match in lines if match}
    if None in lines or not data.endswith(b"\n") or any(not _MADE.fullmatch(name) for name in noted):
        return [f"{path}: damaged or edited; {_ADVICE}"]
    found: list[str] = []
    for name in sorted(there | noted.keys()):
        if name not in there:
            found.append(f"{root / name}: missing, but {NAME} names it; {_ADVICE}")
        elif noted.get(name) != atomic_files.sha256(atomic_files.read(root / name)):
            found.append(f"{root / name}: damaged or edited, it is not what {NAME} says; {_ADVICE}")
    return found


def verified(root: Path, name: str) -> bytes | None:
    """A file as it was made; None where it is not there, or is not what was noted."""
    if not atomic_files.exists(root / NAME) or not atomic_files.exists(root / name):
        return None
    data = atomic_files.read(root / name)
    noted = f"{atomic_files.sha256(data)}  {name}"
    return data if noted in atomic_files.read(root / NAME).decode(errors="replace").splitlines() else None


def _there(root: Path) -> set[str]:
    """The names of what was made, by this report or an earlier one."""
    return {name for name in atomic_files.listing(root, ("figures",), sweep=False) if _MADE.fullmatch(name)}
