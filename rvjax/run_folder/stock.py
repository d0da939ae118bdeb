"""Taking stock: the files on the disk are compared with the entries, by name and size, a block of names at a time."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import islice

import numpy as np

from rvjax.run_folder.entries import EntryRows, code_of
from rvjax.run_folder.entry import parsed

_BLOCK = 8_192
"""Names that are compared together."""


def compare(entries: EntryRows, files: Iterable[tuple[str, int]]) -> tuple[EntryRows, list[str]]:
    """The entries without a file of their name and size, and the names of the files that no entry names.

    files: names and sizes of all files in the folders of data files.
    """
    if not len(entries):
        return entries, [file for file, _ in files]
    absent, others, rest = np.ones(len(entries), dtype=np.bool_), list[str](), iter(files)
    while block := list(islice(rest, _BLOCK)):
        others += _compare_block(entries, absent, block)
    return entries.those(absent), others


def _compare_block(entries: EntryRows, absent: np.ndarray, block: Sequence[tuple[str, int]]) -> list[str]:
    """Notes in `absent` the entries whose files are in the block; returns the names of the files that no entry names."""
    named = [parsed(file) for file, _ in block]
    codes = np.fromiter((code_of(name[0]) if name else -1 for name in named), dtype=np.int64, count=len(block))
    digits = "".join(name[1] if name else "0" * 16 for name in named)
    rows = entries.at(codes)
    same = np.frombuffer(bytes.fromhex(digits), dtype=np.uint8).reshape(-1, 8) == entries.sha256[rows, :8]
    listed = (rows >= 0) & same.all(axis=1)
    sizes = np.fromiter((size for _, size in block), dtype=np.int64, count=len(block))
    absent[rows[listed & (sizes == entries.size[rows])]] = False
    return [block[place][0] for place in np.flatnonzero(~listed).tolist()]
