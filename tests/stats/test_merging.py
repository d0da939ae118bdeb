"""Merged and encoded totals against those of a single pass: the same bytes, whatever was grouped how."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pandas as pd
import pytest

from rvjax.analysis.accumulator import RunAccumulator
from rvjax.analysis.run_totals import HEAD
from rvjax.analysis.verdicts import mean_tally
from rvjax.campaign import Keep, Requirement
from rvjax.errors import DamagedError, FolderError
from rvjax.run_folder import verdict_columns
from rvjax.run_folder.atomic_files import sha256
from rvjax.run_folder.entries import EntryRows
from rvjax.run_folder.entry import Entry, Key
from rvjax.run_folder.named_arrays import Record
from rvjax.run_folder.parquet import decode, encode
from rvjax.run_folder.samples_table import KEYS
from rvjax.stats.quantile_sketch import EXACT
from rvjax.stats.sampling_design import Exploration, Independent
from tests.stats.test_totals import CHUNKS, COLUMNS, EVERYTHING, SIZE, TABLE, chunk

TABLES = [decode(encode(chunk(number), KEYS | COLUMNS)) for number in range(CHUNKS)]
"""As they are read from files: the types are those of a run."""

REQUIRE = (
    Requirement.model_validate({"metric": "captured", "at_least": 0.9}),
    Requirement.model_validate({"metric": "settling_time_s", "quantile": 0.9, "below": 200, "where": {"mass": {"below": 110}}}),
    Requirement.model_validate({"metric": "peak_chi", "above": 5.0, "at_most": 0.5, "method": "sequential"}),
    Requirement.model_validate({"metric": "settling_time_s", "mean": True, "below": 150, "range": [0, 300]}),
    Requirement.model_validate({"metric": "closest_approach_m", "mean": True, "above": -5, "where": {"mass": {"below": 80.3}}}),
    Requirement.model_validate({"metric": "closest_approach_m", "mean": True, "above": -5}),
)
"""A class of few values, whose chunks are often empty, and one of more than are kept."""


def empty(keep: Keep = EVERYTHING) -> RunAccumulator:
    return RunAccumulator(REQUIRE, Independent(), keep)


def added(numbers: Sequence[int]) -> RunAccumulator:
    accumulator = empty()
    for number in numbers:
        accumulator.add(int(number), *TABLES[int(number)])
    return accumulator


def again(accumulator: RunAccumulator) -> RunAccumulator:
    """Through its bytes."""
    return RunAccumulator.decode(accumulator.encode(), REQUIRE, Independent(), EVERYTHING)


def entry(chunk: int) -> Entry:
    digest = sha256(str(chunk).encode())
    return Entry(file=Key("samples", chunk).file(digest), sha256=digest, bytes=1, first=chunk * SIZE, count=SIZE)


ENTRIES = EntryRows.of([entry(number) for number in range(CHUNKS)])


@pytest.fixture(scope="module")
def whole() -> RunAccumulator:
    return added(range(CHUNKS))


@pytest.mark.parametrize("seed", range(4))
def test_order_and_grouping_of_merges_change_no_bit(whole: RunAccumulator, seed: int) -> None:
    """Kills: the head as the chunks that came first, tallies that keep one side, a sketch or a count that is not merged,
    values of a mean that are kept beyond their limit, anything that depends on the order of merging."""
    generator = np.random.Generator(np.random.Philox(key=seed))
    ends = np.sort(generator.integers(0, CHUNKS + 1, generator.integers(1, 9)))
    parts = [added(part.tolist()) for part in np.split(generator.permutation(CHUNKS), ends)]
    while len(parts) > 1:
        first, other = (parts.pop(int(generator.integers(len(parts)))) for _ in range(2))
        first.merge(again(other) if generator.random() < 0.5 else other)
        parts.append(first)
    assert parts[0].encode() == whole.encode()
    assert parts[0].extract(ENTRIES) == whole.extract(ENTRIES)


def test_decoded_totals_say_the_same(whole: RunAccumulator) -> None:
    """Kills: a field that is neither encoded nor compared: verdicts with their units, what the report reads, further chunks."""
    restored = again(whole)
    assert str(restored.verdicts) == str(whole.verdicts)
    assert [verdict.unit for verdict in restored.verdicts] == [verdict.unit for verdict in whole.verdicts]
    for name in ("n", "counts", "columns", "reach", "metrics", "lost"):
        assert getattr(restored.totals, name) == getattr(whole.totals, name), name
    for name in ("worst", "head"):
        pd.testing.assert_frame_equal(getattr(restored.totals, name), getattr(whole.totals, name), check_exact=True)
    assert list(restored.totals.metrics) == list(whole.totals.metrics)
    assert restored.totals.failed.tolist() == whole.totals.failed.tolist()
    assert restored.totals.chunks == list(range(CHUNKS))
    assert len(restored.totals.head) == HEAD * SIZE
    parts = again(added(range(50)))
    for number in range(50, CHUNKS):
        parts.add(number, *TABLES[number])
    assert parts.encode() == whole.encode()


def test_the_few_values_of_a_mean_survive() -> None:
    """Kills: a bootstrap interval that is lost by encoding or merging, so that the verdict depends on who accumulated; values
    that are kept beyond their limit where two tallies with few of them are merged."""
    one, other, together = added(range(3)), added(range(3, 7)), added(range(7))
    one = again(one)
    one.merge(again(other))
    assert "bootstrap" in str(together.verdicts[-1].estimate.method)
    assert str(one.verdicts) == str(together.verdicts)
    many, more = added(range(20)), added(range(20, 40))
    many.merge(more)
    assert many.encode() == added(range(40)).encode()
    assert 7 * SIZE < 20 * SIZE < mean_tally.FEW < 40 * SIZE
    assert CHUNKS * SIZE > 2 * EXACT, "otherwise no sketch rounds"


@pytest.mark.parametrize(("mine", "others"), [((0, 1, 2), (2, 3)), ((0, 5), (5,))])
def test_a_chunk_on_both_sides_is_refused_and_changes_nothing(mine: Sequence[int], others: Sequence[int]) -> None:
    """Kills: samples counted twice; a merge that stops half-way."""
    accumulator = added(mine)
    before = accumulator.encode()
    with pytest.raises(FolderError, match="is there twice"):
        accumulator.merge(added(others))
    assert accumulator.encode() == before


def test_a_sample_in_two_chunks_is_refused() -> None:
    """Two numbers of chunks with common samples. Kills: comparing numbers of chunks only."""
    other = empty()
    other.add(77, *TABLES[2])
    with pytest.raises(FolderError, match=f"chunk 77: .* a sample from {2 * SIZE} to {3 * SIZE - 1}, is there twice"):
        added([0, 1, 2]).merge(other)


def test_two_chunks_of_one_number_are_refused() -> None:
    """Of different samples. Kills: comparing samples only."""
    other = empty()
    other.add(1, *TABLES[9])
    with pytest.raises(FolderError, match=r"chunk 1: the chunk, .* is there twice"):
        added([0, 1]).merge(other)


def test_other_columns_are_refused() -> None:
    """Kills: merging tables of two campaigns."""
    frame, columns = TABLES[4]
    other = RunAccumulator([], Independent(), EVERYTHING)
    other.add(4, frame.drop(columns="draw.turn"), {name: column for name, column in columns.items() if name != "draw.turn"})
    mine = RunAccumulator([], Independent(), EVERYTHING)
    mine.add(3, *TABLES[3])
    with pytest.raises(FolderError, match="chunk 4: other columns than in chunk 3: draw"):
        mine.merge(other)


def test_nothing_is_the_neutral_element() -> None:
    """Kills: an empty side that hides the other one, or is not encoded."""
    for first, second in ((empty(), added([1])), (added([1]), empty()), (again(empty()), again(added([1])))):
        first.merge(second)
        assert first.encode() == added([1]).encode()
        assert str(first.verdicts) == str(added([1]).verdicts)
    nothing = empty()
    nothing.merge(empty())
    assert nothing.encode() == again(empty()).encode()


def test_explorations_are_merged_without_verdicts() -> None:
    """Kills: totals of a plan that cannot be encoded."""
    parts = [RunAccumulator([], Exploration("a plan"), EVERYTHING) for _ in range(3)]
    for part, numbers in zip(parts, ((0,), (1,), (0, 1)), strict=True):
        for number in numbers:
            part.add(number, *TABLES[number])
    parts[0].merge(RunAccumulator.decode(parts[1].encode(), [], Exploration("a plan"), EVERYTHING))
    assert parts[0].encode() == parts[2].encode()


def test_an_extract_that_is_too_large_is_dropped_in_any_order(monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: an extract of some of the chunks; memory that grows by merging."""
    monkeypatch.setattr(verdict_columns, "MOST", 5 * SIZE)
    small, rest = added(range(3)), added(range(3, 6))
    small.merge(rest)
    assert small.extract(ENTRIES[:6]) is None
    assert small.encode() == added(range(6)).encode() == again(small).encode()
    assert added(range(5)).extract(ENTRIES[:5]) is not None


def test_totals_of_another_purpose_are_refused() -> None:
    """Kills: counts of one requirement read as those of another."""
    data = added([0]).encode()
    for require, design, keep in (
        (REQUIRE[:-1], Independent(), EVERYTHING),
        ((REQUIRE[1], REQUIRE[0], *REQUIRE[2:]), Independent(), EVERYTHING),
        (REQUIRE, Independent("other"), EVERYTHING),
        (REQUIRE, Independent(), Keep()),
    ):
        with pytest.raises(DamagedError, match="made for other requirements"):
            RunAccumulator.decode(data, require, design, keep)
        with pytest.raises(ValueError, match="cannot be merged"):
            RunAccumulator(require, design, keep).merge(added([0]))


def damaged(record: Record) -> list[tuple[str, bytes]]:
    """Records that lack an array, have one of another length, type or contents, or contradict themselves."""
    cases: list[tuple[str, bytes]] = []
    for name, array in record.arrays.items():
        rest = {key: other for key, other in record.arrays.items() if key != name}
        cases.append((f"without {name}", Record(record.document, rest).encode()))
        if len(array) > 1:
            cases.append((f"{name} is too short", Record(record.document, rest | {name: array.slice(1)}).encode()))
    for part in record.document["parts"]:
        document = record.document | {"parts": {k: v for k, v in record.document["parts"].items() if k != part}}
        cases.append((f"without {part}", Record(document, record.arrays).encode()))
    return cases


def refusal(data: bytes) -> str:
    """What is said of damaged bytes; empty if they are accepted."""
    try:
        RunAccumulator.decode(data, REQUIRE, Independent(), EVERYTHING)
    except DamagedError as error:
        return str(error)
    return ""


def test_damaged_totals_are_refused() -> None:
    """Kills: part of the totals missing unnoticed; a traceback of Arrow or of JSON."""
    data = added(range(3)).encode()
    record = Record.decode(data)
    for what, altered in damaged(record):
        assert refusal(altered).startswith("encoded totals cannot be used: "), what
    for altered in (b"", b"nonsense", data[: len(data) // 2], Record({"format": "rvjax totals 0"}).encode()):
        assert refusal(altered).endswith("; accumulate the chunks again")


def test_numbers_keep_every_bit() -> None:
    """Kills: NaN as a gap or with other bits, a zero without its sign, float32 as float64."""
    odd = np.array([0x7FF8000000000001, 0xFFF0000000000000, 0x8000000000000000, 0x7FF0000000000000], np.uint64).view(np.float64)
    frame = pd.DataFrame(
        {"a": odd, "b": odd.astype(np.float32), "c": [1, 2, 3, 4], "d": ["x", "", "y", "é"], "e": [True, False] * 2}
    )
    record = Record.joined({"numbers": Record.of_numbers({"x": odd}), "frame": Record.of_frame(frame)})
    restored = Record.decode(record.encode())
    assert restored.part("numbers").numbers("x", np.float64).tobytes() == odd.tobytes()
    table = restored.part("frame").frame()
    for name in "abce":
        assert table[name].to_numpy().tobytes() == frame[name].to_numpy().tobytes(), name
        assert table[name].dtype == frame[name].dtype
    assert table["d"].tolist() == frame["d"].tolist()
    with pytest.raises(ValueError, match="accepted: int64 without gaps"):
        restored.part("numbers").numbers("x")
    with pytest.raises(KeyError):
        restored.part("nothing")


def test_the_table_has_what_makes_merging_hard() -> None:
    """The premise of this module."""
    metric = TABLE["metric.settling_time_s"].to_numpy()
    assert np.isnan(metric).any()
    assert math.inf in metric
    assert {"captured", "not_settled", "collided", "not_finite"} == set(TABLE["outcome"])
