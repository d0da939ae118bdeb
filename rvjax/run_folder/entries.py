"""Entries: the entries of a run folder by key, for a million of them: NumPy columns, and the latest changes beside them.

An entry is 64 bytes: part and number of its key in one integer, size, first sample, number of samples, SHA-256. `Entry` objects
are made where one is asked for.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, MutableMapping, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from rvjax.run_folder import atomic_files
from rvjax.run_folder.entry import LARGEST, PARTS, Entry, Key, Part

Numbers = NDArray[np.int64]

CODED = tuple(sorted(PARTS))
"""The parts in the order of their keys."""

RECENT = 8_192
"""The number of changes that are kept as objects before they are merged into the columns."""

_SHIFT = 56
_NUMBER = (1 << _SHIFT) - 1


def code_of(key: Key) -> int:
    """Part and number in one integer; codes are in the order of the keys."""
    return CODED.index(key.part) << _SHIFT | key.number


def codes_of(part: Numbers, number: Numbers) -> Numbers:
    """As `code_of` for many. part: places in `CODED`."""
    return part << _SHIFT | number


@dataclass(frozen=True, eq=False)
class EntryRows(Sequence[Entry]):
    """Entries as columns, ascending by their keys.

    code: (n,) part and number; sha256: (n, 32) bytes; size: (n,) bytes of the file; first: (n,) number of the first sample;
    samples: (n,) number of samples.
    """

    code: Numbers
    sha256: NDArray[np.uint8]
    size: Numbers
    first: Numbers
    samples: Numbers

    @classmethod
    def of(cls, entries: Sequence[Entry]) -> EntryRows:
        """The columns of entries, which must be in ascending order of their keys."""
        columns = (
            [code_of(entry.key) for entry in entries],
            [entry.bytes for entry in entries],
            [entry.first for entry in entries],
            [entry.count for entry in entries],
        )
        code, size, first, count = (np.array(column, dtype=np.int64) for column in columns)
        digests = bytes.fromhex("".join(entry.sha256 for entry in entries))
        return cls(code, np.frombuffer(digests, dtype=np.uint8).reshape(-1, 32), size, first, count)

    @property
    def part(self) -> Numbers:
        """The parts as places in `CODED`."""
        return self.code >> _SHIFT

    @property
    def number(self) -> Numbers:
        """The numbers of the chunks, or of the samples of traces."""
        return self.code & _NUMBER

    @property
    def whole(self) -> bool:
        """Whether the columns are those of entries in ascending order, without a key that is there twice."""
        limits = ((self.number, 0), (self.size, 0), (self.first, 0), (self.samples, 1))
        inside = all(bool(((low <= column) & (column <= LARGEST)).all()) for column, low in limits)
        known = bool(((self.part >= 0) & (self.part < len(CODED))).all())
        return inside and known and bool((np.diff(self.code) > 0).all())

    @property
    def contiguous(self) -> bool:
        """Whether no samples are missing between the first entry and the last."""
        return bool((self.first[1:] == self.first[:-1] + self.samples[:-1]).all())

    @property
    def total(self) -> int:
        """The number of samples in all of them."""
        return int(self.samples.sum())

    @property
    def digest(self) -> str:
        """The SHA-256 over the SHA-256 of all of them, in hexadecimal."""
        return atomic_files.sha256(self.sha256.tobytes().hex().encode())

    def present(self, count: int) -> NDArray[np.bool_]:
        """Which of the numbers 0 .. count - 1 are there."""
        present = np.zeros(count, dtype=np.bool_)
        number = self.number
        present[number[number < count]] = True
        return present

    def holding(self, samples: Numbers) -> tuple[EntryRows, NDArray[np.bool_]]:
        """The entries that hold some samples, and which of the samples are held. The entries must not share samples."""
        order = np.argsort(self.first, kind="stable")
        places = np.searchsorted(self.first[order], samples, side="right") - 1
        held = places >= 0
        rows = order[places[held]]
        held[held] = samples[held] < self.first[rows] + self.samples[rows]
        return self.those(np.unique(order[places[held]])), held

    def at(self, codes: Numbers) -> NDArray[np.intp]:
        """The row of each code; -1 where there is none."""
        if not len(self):
            return np.full(len(codes), -1, dtype=np.intp)
        places = np.minimum(np.searchsorted(self.code, codes), len(self) - 1)
        return np.where(self.code[places] == codes, places, -1)

    def those(self, rows: NDArray[np.bool_] | NDArray[np.intp]) -> EntryRows:
        """Some of the entries, by their rows."""
        return EntryRows(*(column[rows] for column in vars(self).values()))

    def __len__(self) -> int:
        return len(self.code)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Sequence) and len(self) == len(other) and all(a == b for a, b in zip(self, other, strict=True))  # pyright: ignore[reportUnknownArgumentType, reportUnknownVariableType]

    __hash__ = None  # pyright: ignore[reportAssignmentType]

    @overload
    def __getitem__(self, index: int) -> Entry: ...
    @overload
    def __getitem__(self, index: slice) -> EntryRows: ...
    def __getitem__(self, index: int | slice) -> Entry | EntryRows:
        if isinstance(index, slice):
            return EntryRows(*(column[index] for column in vars(self).values()))
        code, sha256 = int(self.code[index]), self.sha256[index].tobytes().hex()
        values: dict[str, Any] = {
            "file": Key(CODED[code >> _SHIFT], code & _NUMBER).file(sha256),
            "sha256": sha256,
            "bytes": int(self.size[index]),
            "first": int(self.first[index]),
            "count": int(self.samples[index]),
        }
        return Entry.model_construct(**values)  # the columns were validated


class Entries(MutableMapping[Key, Entry]):
    """The entries by key, in ascending order. revision: grows with every change."""

    def __init__(self, entries: Iterable[Entry] | EntryRows = ()) -> None:
        self.revision = 0
        self._recent: dict[Key, Entry | None] = {}
        """Latest changes, None for a key that was removed."""
        if isinstance(entries, EntryRows):
            self._rows, self._length = entries, len(entries)
        else:
            self._rows, self._length = EntryRows.of(()), 0
            self.update({entry.key: entry for entry in entries})

    @property
    def rows(self) -> EntryRows:
        """All entries as columns."""
        self._merge()
        return self._rows

    def of_part(self, part: Part) -> EntryRows:
        """The entries of a part in ascending order."""
        rows, place = self.rows, CODED.index(part)
        first, end = np.searchsorted(rows.code, [place << _SHIFT, (place + 1) << _SHIFT])
        return rows[first:end]

    def __len__(self) -> int:
        return self._length

    def __iter__(self) -> Iterator[Key]:
        for code in self.rows.code:
            yield Key(CODED[int(code) >> _SHIFT], int(code) & _NUMBER)

    def __contains__(self, key: object) -> bool:
        return isinstance(key, Key) and (self._recent[key] is not None if key in self._recent else self._place(key) >= 0)

    def __getitem__(self, key: Key) -> Entry:
        if key not in self:
            raise KeyError(key)
        return self._recent.get(key) or self._rows[self._place(key)]

    def __setitem__(self, key: Key, entry: Entry) -> None:
        self._change(key, entry)

    def __delitem__(self, key: Key) -> None:
        if key not in self:
            raise KeyError(key)
        self._change(key, None)

    def update(self, entries: Mapping[Key, Entry]) -> None:  # pyright: ignore[reportIncompatibleMethodOverride]
        """Adds entries, which replace those with the same key."""
        for key, entry in entries.items():
            self._change(key, entry)

    def _change(self, key: Key, entry: Entry | None) -> None:
        self._length += (entry is not None) - (key in self)
        self._recent[key] = entry
        self.revision += 1
        if len(self._recent) > RECENT:
            self._merge()

    def _place(self, key: Key) -> int:
        """The row of a key; -1 if there is none."""
        code = code_of(key)
        place = int(np.searchsorted(self._rows.code, code))
        return place if place < len(self._rows) and self._rows.code[place] == code else -1

    def _merge(self) -> None:
        """Merges the latest changes into the columns."""
        if not self._recent:
            return
        changed = np.sort(np.array([code_of(key) for key in self._recent], dtype=np.int64))
        added = EntryRows.of([self._recent[key] for key in sorted(self._recent) if self._recent[key] is not None])  # pyright: ignore[reportArgumentType]
        replaced = self._rows.at(changed)
        kept = np.ones(len(self._rows), dtype=np.bool_)
        kept[replaced[replaced >= 0]] = False
        code = self._rows.code if kept.all() else self._rows.code[kept]
        places = np.searchsorted(code, added.code)
        columns = [
            np.insert(old if kept.all() else old[kept], places, new, axis=0)
            for old, new in zip(vars(self._rows).values(), vars(added).values(), strict=True)
        ]
        self._rows, self._recent = EntryRows(*columns), {}


TOGETHER = 64
"""The largest number of entries in a group of neighbours."""


def neighbours(entries: EntryRows, most: int = TOGETHER) -> Iterator[EntryRows]:
    """Groups of up to `most` consecutive entries without a gap between their samples."""
    gaps = np.flatnonzero(entries.first[1:] != entries.first[:-1] + entries.samples[:-1]) + 1
    for first, end in zip(chain([0], gaps), chain(gaps, [len(entries)]), strict=True):
        for begin in range(int(first), int(end), most):
            yield entries[begin : min(begin + most, int(end))]
