"""SHA-256 of the files made from the data (report, summary, figures), in the format of `sha256sum -c SHA256SUMS`."""

from __future__ import annotations

import re
from collections.abc import Mapping

from rvjax.run_folder import atomic_files
from rvjax.run_folder.storage import Storage

NAME = "SHA256SUMS"

_MADE = re.compile(
    r"report\.html|report\.md|report\.pdf|summary\.json|judged\.parquet|search\.json|candidates\.csv|best\.yaml|rare\.json|failing\.yaml|failing\.csv|figures/.+"
)
_LINE = re.compile(r"([0-9a-f]{64})  (\S.*)")
_ADVICE = "`rvjax report` makes it again"


def seal(storage: Storage, made: Mapping[str, str]) -> None:
    """Writes the SHA-256 of the files, by name, and removes figures of an earlier report that are not among them."""
    storage.replace(NAME, "".join(f"{digest}  {name}\n" for name, digest in sorted(made.items())).encode())
    for name in _existing(storage) - made.keys():
        storage.remove(name)


def complaints(storage: Storage) -> list[str]:
    """A message for each file that is missing or was changed; empty if no report was made."""
    root, existing = storage.place, _existing(storage)
    path = root / NAME
    if not storage.exists(NAME):
        return [f"{path}: missing, so the report cannot be verified; {_ADVICE}"] if existing else []
    data = storage.read(NAME)
    text = data.decode(errors="replace").removesuffix("\n")
    lines = [_LINE.fullmatch(line) for line in text.split("\n")]  # splitlines would also split at \v, \f and the like
    noted = {match[2]: match[1] for match in lines if match}
    if None in lines or not data.endswith(b"\n") or any(not _MADE.fullmatch(name) for name in noted):
        return [f"{path}: damaged or edited; {_ADVICE}"]
    messages: list[str] = []
    for name in sorted(existing | noted.keys()):
        if name not in existing:
            messages.append(f"{root / name}: missing, but listed in {NAME}; {_ADVICE}")
        elif noted.get(name) != atomic_files.sha256(storage.read(name)):
            messages.append(f"{root / name}: damaged or edited, its SHA-256 is not that in {NAME}; {_ADVICE}")
    return messages


def verified(storage: Storage, name: str) -> bytes | None:
    """The bytes of a file; None if it is missing or its SHA-256 is not in `SHA256SUMS`."""
    if not storage.exists(NAME) or not storage.exists(name):
        return None
    data = storage.read(name)
    noted = f"{atomic_files.sha256(data)}  {name}"
    return data if noted in storage.read(NAME).decode(errors="replace").split("\n") else None


def _existing(storage: Storage) -> set[str]:
    """The names of all files from this report or an earlier report."""
    return {name for name, _ in storage.listing(("", "figures"), sweep=False) if _MADE.fullmatch(name)}
