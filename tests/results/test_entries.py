"""Entries as columns are the mapping that a dictionary would be; stock is taken as by comparing every name."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from rvjax.errors import FolderError
from rvjax.run_folder import atomic_files
from rvjax.run_folder.entries import Entries, EntryRows, neighbours
from rvjax.run_folder.entries_file import decode, encode
from rvjax.run_folder.entry import LARGEST, PARTS, Entry, Key, Part
from rvjax.run_folder.journal import _decode, _line
from rvjax.run_folder.stock import compare


def entry(part: Part, number: int, first: int = 0, count: int = 4, salt: str = "") -> Entry:
    """An entry whose SHA-256 is that of a few words."""
    sha256 = atomic_files.sha256(f"{part} {number} {salt}".encode())
    return Entry(file=Key(part, number).file(sha256), sha256=sha256, bytes=100 + number % 7, first=first, count=count)


def rows(*numbers: int) -> EntryRows:
    """Chunks of four samples."""
    return Entries(entry("samples", number, 4 * number) for number in numbers).rows


@pytest.mark.parametrize("recent", [1, 5, 1_000])
def test_entries_are_what_a_dictionary_would_be(recent: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Thousands of changes in random order, merged now and then. Kills: a change lost in a merge, a key that is there twice, a
    removed key that comes back, an order other than that of the keys, a length that drifts."""
    monkeypatch.setattr("rvjax.run_folder.entries.RECENT", recent)
    generator = np.random.default_rng(recent)
    entries, expected = Entries(), dict[Key, Entry]()
    for step in range(2_000):
        key = Key(PARTS[generator.integers(3)], int(generator.integers(40)) * int(generator.choice([1, 10**12])))
        if generator.uniform() < 0.4:
            revision = entries.revision
            assert entries.pop(key, None) == expected.pop(key, None), step
            assert (key in entries, entries.get(key)) == (False, None)
            assert entries.revision >= revision
        else:
            revision = entries.revision
            entries[key] = expected[key] = entry(*key, salt=str(step))
            assert entries.revision > revision
        other = Key(PARTS[generator.integers(3)], int(generator.integers(40)))
        assert (other in entries, entries.get(other)) == (other in expected, expected.get(other)), step
        assert len(entries) == len(expected)
        if not step % 50:
            assert list(entries.items()) == sorted(expected.items())
            for part in PARTS:
                of_part = {key.number: value for key, value in expected.items() if key.part == part}
                assert entries.of_part(part).number.tolist() == sorted(of_part)
                assert list(entries.of_part(part)) == [of_part[number] for number in sorted(of_part)]
    with pytest.raises(KeyError):
        del entries[Key("samples", 41)]


def test_rows_are_a_sequence() -> None:
    """Kills: slices and negative places that differ from a list's; columns of other entries."""
    chunks = rows(0, 1, 2, 5, 6)
    listed = list(chunks)
    assert [one.number for one in listed] == [0, 1, 2, 5, 6]
    assert (chunks[-1], chunks[1:3], chunks[:0], len(chunks)) == (listed[-1], listed[1:3], [], 5)
    assert chunks != listed[:-1]
    assert chunks != [*listed[:-1], entry("samples", 9)]
    assert chunks.total == 20
    assert chunks.digest == atomic_files.sha256("".join(one.sha256 for one in listed).encode())
    assert chunks.present(7).tolist() == [True, True, True, False, False, True, True]
    assert chunks.present(2).tolist() == [True, True]
    with pytest.raises(IndexError):
        chunks[5]


def test_the_chunks_of_samples() -> None:
    """Kills: the chunk before or behind, a sample between two chunks that counts as held."""
    chunks = rows(0, 1, 5, 6)
    held, which = chunks.holding(np.array([3, 4, 7, 8, 19, 20, 27, 28]))
    assert held.number.tolist() == [0, 1, 5, 6]
    assert which.tolist() == [True, True, True, False, False, True, True, False]
    held, which = chunks.holding(np.array([21]))
    assert (held.number.tolist(), which.tolist()) == ([5], [True])
    held, which = rows().holding(np.array([0]))
    assert (len(held), which.tolist()) == (0, [False])


@pytest.mark.parametrize("numbers", [(), (0,), (0, 1, 2, 3, 4), (0, 1, 5, 6), (0, 2, 4)])
def test_neighbours_are_groups_without_gaps(numbers: tuple[int, ...]) -> None:
    """Kills: a group over a gap, an entry lost at a border, groups larger than asked for."""
    chunks = rows(*numbers)
    assert chunks.contiguous == (len(numbers) < 2 or numbers[-1] - numbers[0] == len(numbers) - 1)
    groups = [group.number.tolist() for group in neighbours(chunks, 2)]
    assert list(itertools.chain(*groups)) == list(numbers)
    assert all(len(group) <= 2 and group == list(range(group[0], group[-1] + 1)) for group in groups)
    assert len(groups) == sum(-(-run // 2) for run in runs(numbers))


def runs(numbers: tuple[int, ...]) -> list[int]:
    """Lengths of the runs of consecutive numbers."""
    return [len(list(run)) for _, run in itertools.groupby(enumerate(numbers), lambda pair: pair[1] - pair[0])]


@pytest.mark.parametrize("block", [2, 100])
def test_the_entries_file_keeps_every_bit(block: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: rows lost between two groups, a part for another one, digests shifted."""
    monkeypatch.setattr("rvjax.run_folder.entries_file._BLOCK", block)
    entries = [entry(part, number, 3 * number) for part in PARTS for number in (0, 1, 7, 10**6, LARGEST // 3)]
    whole = Entries(entries).rows
    reference, data = encode(whole)
    assert (reference.count, reference.sha256) == (15, atomic_files.sha256(data))
    assert list(decode(data, 15)) == sorted(entries, key=lambda one: one.key)
    assert encode(whole)[1] == data
    with pytest.raises(ValueError, match="another number of them"):
        decode(data, 14)


@pytest.mark.parametrize(
    "wrong",
    [
        {"code": np.array([3, 2, 4])},
        {"code": np.array([2, 2, 4])},
        {"code": np.array([1, 2, -4])},
        {"code": np.array([1, 2, LARGEST + 1])},
        {"code": np.array([1, 2, 3 << 56])},
        {"size": np.array([1, -1, 1])},
        {"first": np.array([0, 1, LARGEST + 1])},
        {"samples": np.array([1, 0, 1])},
    ],
    ids=["order", "twice", "negative", "number", "part", "size", "first", "samples"],
)
def test_rows_that_are_no_entries_are_refused(wrong: dict[str, np.ndarray]) -> None:
    """Kills: columns that are believed."""
    good = rows(0, 1, 2)
    assert good.whole
    assert not replace(good, **wrong).whole


def test_a_file_whose_rows_are_no_entries_is_refused() -> None:
    """Although its SHA-256 is right. Kills: two rows of one chunk."""
    twice = replace(rows(0, 1, 2), code=rows(0, 1, 2).code[[0, 1, 1]])
    with pytest.raises(ValueError, match="not in ascending order, or a number"):
        decode(encode(twice)[1], 3)


def test_stock_is_that_of_every_name(monkeypatch: pytest.MonkeyPatch) -> None:
    """Against a comparison of names in Python. Kills: a file of another chunk, of other bytes or of another size that counts."""
    monkeypatch.setattr("rvjax.run_folder.stock._BLOCK", 7)
    generator = np.random.default_rng(3)
    for _ in range(50):
        entries = Entries(entry(PARTS[generator.integers(3)], int(n)) for n in generator.integers(200, size=30))
        files = [(one.file, one.bytes) for one in entries.values() if generator.uniform() < 0.8]
        files = [(name, size + int(generator.uniform() < 0.1)) for name, size in files]
        files += [(entry("samples", int(n), salt="other").file, 100) for n in generator.integers(200, size=5)]
        files += [
            ("samples/x", 1),
            ("samples/0000001-0123456789abcdef.parquet", 1),
            ("samples/００００１-0123456789abcdef.parquet", 2),
        ]
        files = [files[place] for place in generator.permutation(len(files))]
        absent, others = compare(entries.rows, files)
        sizes, names = dict(files), {one.file for one in entries.values()}
        assert [one.file for one in absent] == [one.file for one in entries.values() if sizes.get(one.file) != one.bytes]
        assert others == [name for name, _ in files if name not in names]
    assert compare(Entries().rows, [("samples/x", 1)])[1] == ["samples/x"]


@pytest.mark.parametrize(
    "name",
    [
        "samples/1234567890123456-0123456789abcdef.parquet",
        "samples/000001-0123456789abcdef.parquet",
        "samples/00001-0123456789abcdeF.parquet",
        "samples/0000１-0123456789abcdef.parquet",
        "samples/sample-0000001-0123456789abcdef.parquet",
        "traces/0000001-0123456789abcdef.parquet",
        "traces/sample-00000001-0123456789abcdef.parquet",
    ],
)
def test_other_names_are_not_those_of_data_files(name: str) -> None:
    """Kills: two names of one chunk, numbers that no column holds."""
    assert Key.of(name) is None


def test_a_name_gives_its_key() -> None:
    """Kills: numbers of more digits than the padding, a part for another one."""
    for key in (Key("samples", 0), Key("samples", 123_456), Key("envelopes", 99_999), Key("traces", 3), Key("traces", LARGEST)):
        assert Key.of(key.file("0123456789abcdef")) == key


def test_a_line_with_a_number_that_no_column_holds_is_damage(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Kills: an OverflowError from NumPy."""
    path = tmp_path_factory.mktemp("x") / "journal.jsonl"
    line = entry("samples", 1).model_dump()
    head = {"base": "", "head": {"name": "", "samples": 1, "identity": {}, "provenance": {}, "campaign": "0" * 64}}
    assert len(_decode(path, _line(head) + _line(line))[2]) == 1
    for name in ("bytes", "first", "count"):
        with pytest.raises(FolderError, match="damaged, not a journal"):
            _decode(path, _line(head) + _line(line | {name: 2**63}))
