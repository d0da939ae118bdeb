"""Ledger: which samples were added to totals, and how they ended."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Mapping, Sequence
from dataclasses import astuple
from itertools import pairwise

import numpy as np
import pandas as pd

from rvjax.columns import OUTCOMES, Column
from rvjax.errors import FolderError
from rvjax.run_folder import Account
from rvjax.run_folder.named_arrays import Record


class Ledger:
    """The samples that were added, and their outcomes. Every sample is there once, and all chunks have the same columns."""

    def __init__(self) -> None:
        self.columns: dict[str, Column] = {}
        self.counts: dict[str, int] = dict.fromkeys(OUTCOMES, 0)
        self.n = 0
        self._chunks: set[int] = set()
        self._spans: list[tuple[int, int]] = []

    def add(self, chunk: int, frame: pd.DataFrame, columns: Mapping[str, Column]) -> None:
        """Enters the samples of a chunk.

        FolderError if its columns differ from the other chunks, or if the chunk or any of its samples was entered before.
        """
        sample = frame["sample"].to_numpy()
        if not sample.size or sample[0] < 0 or not np.array_equal(sample, sample[0] + np.arange(sample.size)):
            raise FolderError(f"chunk {chunk}: its samples are not consecutive numbers from 0 on; fly the campaign again")
        self._compare(chunk, columns)
        first, behind = int(sample[0]), int(sample[-1]) + 1
        place = bisect_left(self._spans, (first, behind))
        neighbours = self._spans[max(place - 1, 0) : place + 1]
        if chunk in self._chunks or any(first < end and start < behind for start, end in neighbours):
            raise _twice(chunk, first, behind)
        self.columns = self.columns or dict(columns)
        self._chunks.add(chunk)
        self._spans.insert(place, (first, behind))
        self.n += sample.size
        self._count({str(outcome): int(count) for outcome, count in frame["outcome"].value_counts().items()})

    def merge(self, other: Ledger) -> None:
        """Enters the samples of another ledger; errors as in `add`, then nothing has changed."""
        if not other.n:
            return
        self._compare(min(other._chunks), other.columns)
        spans = sorted(self._spans + other._spans)
        doubled = [second for first, second in pairwise(spans) if second[0] < first[1]]
        if common := self._chunks & other._chunks:
            raise _twice(min(common), *(doubled or spans)[0])
        if doubled:
            raise _twice(min(other._chunks), *doubled[0])
        self.columns = self.columns or dict(other.columns)
        self._chunks |= other._chunks
        self._spans = spans
        self.n += other.n
        self._count(other.counts)

    def _count(self, counts: Mapping[str, int]) -> None:
        for outcome, count in counts.items():
            self.counts[outcome] = self.counts.get(outcome, 0) + count

    def _compare(self, chunk: int, columns: Mapping[str, Column]) -> None:
        if self._chunks and columns != self.columns:
            odd = sorted(key for key in columns.keys() | self.columns if columns.get(key) != self.columns.get(key))
            advice = "fly the campaign again"
            raise FolderError(f"chunk {chunk}: other columns than in chunk {min(self._chunks)}: {', '.join(odd)}; {advice}")

    def __contains__(self, chunk: int) -> bool:
        """Whether a chunk was entered."""
        return chunk in self._chunks

    @property
    def chunks(self) -> Sequence[int]:
        """The numbers of the chunks, ascending."""
        return sorted(self._chunks)

    @property
    def firsts(self) -> Sequence[int]:
        """The first samples of the chunks, ascending."""
        return [first for first, _ in self._spans]

    def samples(self) -> Sequence[int]:
        """The numbers of all samples, ascending."""
        if self._spans and self._spans[-1][1] == self.n:
            return range(self.n)
        return [sample for first, behind in self._spans for sample in range(first, behind)]

    def account(self, requested: int) -> Account:
        """The outcomes of the requested samples, and how many are missing. FolderError if a sample was never requested."""
        if self._spans and self._spans[-1][1] > requested:
            raise FolderError(
                f"chunk with sample {self._spans[-1][1] - 1}: only {requested} samples were requested; "
                "fly the campaign again with another --out"
            )
        return Account(requested, *(self.counts[outcome] for outcome in OUTCOMES), missing=requested - self.n)

    def record(self) -> Record:
        """All of it, for `Ledger.of`."""
        first, behind = (np.array([span[end] for span in self._spans], np.int64) for end in (0, 1))
        return Record.of_numbers(
            {"chunk": np.array(self.chunks, np.int64), "first": first, "behind": behind},
            columns=[astuple(column) for column in self.columns.values()],
            counts=self.counts,
        )

    @classmethod
    def of(cls, record: Record) -> Ledger:
        """The ledger of a record; ValueError, KeyError or TypeError if the record contradicts itself."""
        ledger = cls()
        chunks, first, behind = (record.numbers(name) for name in ("chunk", "first", "behind"))
        ledger.columns = {column.name: column for column in (Column(*fields) for fields in record.document["columns"])}
        ledger._count(record.document["counts"])
        ledger._chunks, ledger._spans = set(chunks.tolist()), list(zip(first.tolist(), behind.tolist(), strict=True))
        ledger.n = int((behind - first).sum())
        rising = np.all(behind > first) and np.all(first[1:] >= behind[:-1]) and np.all(first >= 0)
        if not rising or len(ledger._chunks) != len(chunks) or len(chunks) != len(first):
            raise ValueError("chunks or samples that are not ascending, or are there twice")
        if min(ledger.counts.values()) < 0 or sum(ledger.counts.values()) != ledger.n:
            raise ValueError(f"{ledger.n} samples, but {ledger.counts} outcomes")
        return ledger


def _twice(chunk: int, first: int, behind: int) -> FolderError:
    return FolderError(
        f"chunk {chunk}: the chunk, or a sample from {first} to {behind - 1}, is there twice; "
        "fly the campaign again with another --out"
    )
