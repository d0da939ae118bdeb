"""SHA-256 of the files made from the data (report, summary, figures), in the format of `sha256sum -c SHA256SUMS`."""

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
    """Writes the SHA-256 of the files, by name, and removes figures of an earlier report that are not among them."""
    atomic_files.replace(root / NAME, "".join(f"{digest}  {name}\n" for name, digest in sorted(made.items())).encode())
    for name in _existing(root) - made.keys():
        with atomic_files.explained(root / name):
            (root / name).unlink()


def complaints(root: Path) -> list[str]:
    """A message for each file that is missing or was changed; empty if no report was made."""
    path = root / NAME
    existing = _existing(root)
    if not atomic_files.exists(path):
        return [f"{path}: missing, so the report cannot be verified; {_ADVICE}"] if existing else []
    data = atomic_files.read(path)
    text = data.decode(errors="replace").removesuffix("\n")
    lines = [_LINE.fullmatch(line) for line in text.split("\n")]  # splitlines would also split at \v, \f and the like
    noted = {match[2]: match[1] for match in lines if match}
    if None in lines or not data.endswith(b"\n") or any(not _MADE.fullmatch(name) for name in noted):
        return [f"{path}: damaged or edited; {_ADVICE}"]
    messages: list[str] = []
    for name in sorted(existing | noted.keys()):
        if name not in existing:
            messages.append(f"{root / name}: missing, but listed in {NAME}; {_ADVICE}")
        elif noted.get(name) != atomic_files.sha256(atomic_files.read(root / name)):
            messages.append(f"{root / name}: damaged or edited, its SHA-256 is not that in {NAME}; {_ADVICE}")
    return messages


def verified(root: Path, name: str) -> bytes | None:
    """The bytes of a file; None if it is missing or its SHA-256 is not in `SHA256SUMS`."""
    if not atomic_files.exists(root / NAME) or not atomic_files.exists(root / name):
        return None
    data = atomic_files.read(root / name)
    noted = f"{atomic_files.sha256(data)}  {name}"
    return data if noted in atomic_files.read(root / NAME).decode(errors="replace").split("\n") else None


def _existing(root: Path) -> set[str]:
    """The names of all files from this report or an earlier report."""
    return {name for name, _ in atomic_files.listing(root, ("", "figures"), sweep=False) if _MADE.fullmatch(name)}
