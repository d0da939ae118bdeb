"""Totals against brute force on the whole table; order and grouping of the chunks change no bit."""

from __future__ import annotations

import math
import weakref
from collections.abc import Iterable
from typing import Any

import numpy as np
import pandas as pd
import pytest

from rvjax.analysis import run_totals as module
from rvjax.analysis.ledger import Ledger
from rvjax.analysis.run_totals import AT_ONCE, HEAD, Totals, wanted, worst_first
from rvjax.campaign import Keep
from rvjax.columns import Column
from rvjax.errors import FolderError
from rvjax.run_folder.named_arrays import Record
from rvjax.stats.quantile_sketch import EXACT, RELATIVE_ERROR

SIZE, CHUNKS = 200, 100
N = SIZE * CHUNKS
METRICS = {
    "captured": "higher",
    "settling_time_s": "lower",
    "window_position_error_m": "lower",
    "closest_approach_m": "higher",
    "peak_chi": "",
}
COLUMNS = {f"metric.{name}": Column(f"metric.{name}", "1", name, better) for name, better in METRICS.items()}
COLUMNS |= {name: Column(name, "1", name) for name in ("outcome_time_s", "draw.mass", "draw.kind", "draw.turn")}
EVERYTHING = Keep(worst=30, failed=True, percentiles=True)


def table() -> pd.DataFrame:
    """20,000 samples with many ties, infinite times, and NaN where not finite; the worst are anywhere."""
    generator = np.random.Generator(np.random.Philox(key=11))
    outcome = generator.choice(["captured", "not_settled", "collided", "not_finite"], N, p=[0.95, 0.043, 0.002, 0.005])
    failed, lost = outcome == "not_settled", outcome == "not_finite"
    values = {
        "captured": (outcome == "captured").astype(float),
        "settling_time_s": np.where(failed, math.inf, generator.lognormal(4, 0.5, N).round(1)),
        "window_position_error_m": generator.lognormal(-6, 1, N).round(4),
        "closest_approach_m": generator.normal(0, 1, N),
        "peak_chi": generator.lognormal(0, 3, N).astype(np.float32),
    }
    return pd.DataFrame(
        {
            "sample": np.arange(N),
            "outcome": outcome,
            "outcome_time_s": np.where(lost, generator.uniform(5, 50, N).round(), generator.uniform(5, 300, N)),
            "draw.mass": generator.uniform(80, 120, N),
            "draw.kind": generator.choice(["a", "b"], N),
            "draw.turn": generator.choice([0.0, -0.0], N),
        }
        | {f"metric.{name}": np.where(lost & (name != "captured"), math.nan, x) for name, x in values.items()}
    )


TABLE = table()


def chunk(number: int, frame: pd.DataFrame = TABLE) -> pd.DataFrame:
    return frame.iloc[number * SIZE : (number + 1) * SIZE].reset_index(drop=True)


def folded(chunks: Iterable[int] = range(CHUNKS), keep: Keep = EVERYTHING, frame: pd.DataFrame = TABLE) -> Totals:
    found = Totals(keep)
    for number in chunks:
        found.add(int(number), chunk(int(number), frame), COLUMNS)
    return found


@pytest.fixture(scope="module")
def whole() -> Totals:
    return folded()


def filled(name: str, frame: pd.DataFrame = TABLE) -> np.ndarray:
    """A metric with NaN as the worst value."""
    x = frame[f"metric.{name}"].to_numpy(dtype=float)
    return np.where(np.isnan(x), -math.inf if METRICS[name] == "higher" else math.inf, x)


def ranked(frame: pd.DataFrame = TABLE) -> list[int]:
    """Samples from the worst to the best, by a plain sort of all of them."""
    window, settling = (filled(name, frame).tolist() for name in ("window_position_error_m", "settling_time_s"))
    outcomes, times, samples = (frame[name].tolist() for name in ("outcome", "outcome_time_s", "sample"))

    def key(place: int) -> tuple[float, ...]:
        if outcomes[place] == "not_finite":
            return 0, times[place], -settling[place], samples[place]
        if outcomes[place] == "collided":
            return 1, times[place], -settling[place], samples[place]
        if outcomes[place] == "not_settled":
            return 2, -window[place], -settling[place], samples[place]
        return 3, -settling[place], samples[place]

    return [samples[place] for place in sorted(range(len(frame)), key=key)]


SAID = ("n", "counts", "columns", "metrics", "reach", "lost", "failed", "samples", "worst", "head")
LISTS = ("failed", "samples", "wanted")


def state_of(found: Totals, name: str) -> Any:
    """One thing that totals say, where the sign of a zero counts."""
    said = found.account(N + 5) if name == "account" else wanted(found) if name == "wanted" else getattr(found, name)
    if isinstance(said, pd.DataFrame):
        return [(key, repr(said[key].tolist()), said[key].dtype) for key in said]
    return repr(said) if name == "reach" else said.copy() if isinstance(said, dict) else list(said) if name in LISTS else said


def state(found: Totals) -> dict[str, Any]:
    """All that totals say."""
    return {name: state_of(found, name) for name in (*SAID, "account", "wanted")}


def test_order_and_grouping_of_the_chunks_change_no_bit(whole: Totals, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: rows kept by the order in which they came, ties broken by it, the first 25 chunks that came as the head, a zero
    whose sign depends on it, tables that are left waiting."""
    expected = state(whole)
    generator = np.random.Generator(np.random.Philox(key=12))
    for at_once in (AT_ONCE, 1, 7, 10 * CHUNKS):
        monkeypatch.setattr(module, "AT_ONCE", at_once)
        found = folded(generator.permutation(CHUNKS))
        assert state(found) == expected


def test_reading_in_between_changes_nothing(whole: Totals) -> None:
    """Kills: a table taken in twice, or not at all once totals have been read."""
    found = Totals(EVERYTHING)
    for number in range(CHUNKS):
        found.add(number, chunk(number), COLUMNS)
        if number % 9 == 0:
            state(found)
    assert state(found) == state(whole)
    for name, said in state(folded(range(3))).items():
        assert state_of(folded(range(3)), name) == said


def test_counts_and_ends_are_those_of_the_table(whole: Totals) -> None:
    """Kills: NaN that is dropped, or counts as the best; a label taken for a number; times of flights that were not lost."""
    assert whole.n == N
    assert whole.counts == TABLE["outcome"].value_counts().to_dict()
    assert list(whole.metrics) == list(METRICS)
    assert whole.reach == {"mass": (TABLE["draw.mass"].min(), TABLE["draw.mass"].max()), "turn": (0.0, 0.0)}
    for name, sketch in whole.metrics.items():
        x = filled(name)
        assert sketch.n == N
        assert sketch.positive == np.count_nonzero(x > 0)
        assert sketch.at_least(math.inf) == np.count_nonzero(np.isposinf(x))
        assert sketch.at_least(-math.inf) == N
    assert whole.metrics["peak_chi"].at_least(10.0) == np.count_nonzero(filled("peak_chi") >= 10.0)
    times = np.sort(TABLE.loc[TABLE["outcome"] == "not_finite", "outcome_time_s"])
    assert [whole.lost.value(rank) for rank in range(whole.lost.n)] == times.tolist()
    assert whole.failed.tolist() == TABLE.loc[TABLE["outcome"] != "captured", "sample"].tolist()


def test_totals_from_before_there_were_collisions_are_read() -> None:
    """Their record counts three outcomes. Kills: an outcome that every record must have."""
    record = Ledger.of(folded([0, 1]).record().part("ledger")).record()
    counts = {name: count for name, count in record.document["counts"].items() if name != "collided"}
    lost = record.document["counts"]["collided"]
    counts["not_settled"] += lost
    old = Ledger.of(Record({**record.document, "counts": counts}, record.arrays))
    account = old.account(2 * SIZE)
    assert (account.collided, account.not_settled, account.missing) == (0, counts["not_settled"], 0)


def test_a_flight_lost_at_no_known_time_was_lost_last() -> None:
    """Kills: NaN among the times."""
    frame = TABLE.assign(outcome="not_finite", outcome_time_s=np.where(np.arange(N) % SIZE == 3, math.nan, 7.0))
    lost = folded([0, 1], frame=frame).lost
    assert [lost.value(rank) for rank in (0, 2 * SIZE - 3, 2 * SIZE - 2)] == [7.0, 7.0, math.inf]
    assert folded([1, 0], frame=frame).worst["outcome_time_s"].tolist() == [7.0] * 30


def test_order_statistics_are_those_of_the_table(whole: Totals) -> None:
    """Within the stated error, exact in the tails. Kills: a chunk sketched twice, single precision rounded again."""
    for name, sketch in whole.metrics.items():
        x = np.sort(filled(name))
        for rank in [*range(0, N, 61), EXACT - 1, N - EXACT, N - 1]:
            found, truth = sketch.value(rank), x[rank]
            tail = rank < EXACT or rank >= N - EXACT
            assert found == truth or (not tail and abs(found - truth) <= RELATIVE_ERROR * abs(truth) * (1 + 1e-12))


def test_worst_rows_are_those_of_a_full_sort(whole: Totals) -> None:
    """With ties and NaN. Kills: the worst of the last tables only, ties cut off by place, rows that lose a column."""
    best_known = ranked()
    assert whole.worst["sample"].tolist() == best_known[:30]
    pd.testing.assert_frame_equal(whole.worst, TABLE.iloc[best_known[:30]].reset_index(drop=True), check_exact=True)
    assert folded(keep=Keep(worst=3)).worst["sample"].tolist() == best_known[:10]
    assert [int(TABLE["sample"].iloc[place]) for place in worst_first(TABLE, COLUMNS)] == best_known
    same = TABLE.assign(**{"metric.settling_time_s": 7.0, "metric.window_position_error_m": math.nan, "outcome_time_s": 1.0})
    assert folded(range(CHUNKS - 1, -1, -1), frame=same).worst["sample"].tolist() == ranked(same)[:30]


def test_the_head_is_the_first_chunks_by_number(whole: Totals) -> None:
    """Kills: the head of what came first, or of what is there."""
    pd.testing.assert_frame_equal(whole.head, TABLE.iloc[: HEAD * SIZE], check_exact=True)
    few = folded([60, 24, 25, 3])
    assert few.head["sample"].tolist() == [*range(3 * SIZE, 4 * SIZE), *range(24 * SIZE, 25 * SIZE)]
    none = folded([60])
    assert len(none.head) == 0
    assert list(none.head.columns) == list(TABLE.columns)


def test_what_is_wanted_is_what_was_asked_for(whole: Totals) -> None:
    """Kills: a percentile of all samples or one rank off, the failed of the head only, a policy that hides another."""
    worst, failed = ranked()[:10], TABLE.loc[TABLE["outcome"] != "captured", "sample"].tolist()
    head = TABLE.iloc[: HEAD * SIZE]
    order = sorted(head["sample"], key=lambda sample: (filled("settling_time_s")[sample], sample))
    typical = [order[math.ceil(q * len(order) / 100) - 1] for q in (5, 25, 50, 75, 95)]
    for keep, samples in (
        (Keep(), worst),
        (Keep(worst=0), []),
        (Keep(worst=0, failed=True), failed),
        (Keep(worst=0, percentiles=True), typical),
        (Keep(percentiles=True), {*worst, *typical}),
        (EVERYTHING, {*ranked()[:30], *failed, *typical}),
        (Keep(all=True), range(N)),
    ):
        assert list(wanted(folded(keep=keep))) == sorted(samples)
    assert list(wanted(folded([4, 1], Keep(all=True)))) == [*range(SIZE, 2 * SIZE), *range(4 * SIZE, 5 * SIZE)]
    assert list(wanted(Totals(EVERYTHING))) == []


def test_memory_is_bounded() -> None:
    """Kills: keeping what was taken in: beside the head, no more tables than wait."""
    found = Totals(EVERYTHING)
    kept = []
    for number in range(CHUNKS):
        frame = chunk(number)
        kept.append(weakref.ref(frame))
        found.add(number, frame, COLUMNS)
        del frame
        assert sum(one() is not None for one in kept) <= HEAD + AT_ONCE
    assert len(found.worst) == EVERYTHING.worst


@pytest.mark.parametrize(
    ("number", "start", "behind"),
    [(3, 600, 800), (9, 600, 800), (9, 750, 900), (9, 590, 601), (9, 650, 660), (9, 590, 900), (3, 0, 9)],
    ids=["again", "another number", "the end", "the start", "inside", "around", "another chunk's number"],
)
def test_a_sample_that_is_there_twice_is_refused(number: int, start: int, behind: int) -> None:
    """Whatever came in between. Kills: a comparison of neighbours in time, of first samples, of chunk numbers alone."""
    found = folded([5, 3, 7])
    before = found.n
    with pytest.raises(FolderError, match=rf"chunk {number}: .* is there twice"):
        found.add(number, TABLE.iloc[start:behind], COLUMNS)
    assert found.n == before
    found.add(4, chunk(4), COLUMNS)
    with pytest.raises(FolderError, match="chunk 4"):
        found.add(4, chunk(4), COLUMNS)


def test_chunks_that_do_not_fit_are_refused() -> None:
    """Kills: a column that appears, goes or changes its unit unnoticed; gaps inside a chunk."""
    other = {**COLUMNS, "metric.peak_chi": Column("metric.peak_chi", "m", "peak_chi")}
    for columns in (other, {**COLUMNS, "metric.more": Column("metric.more", "1", "")}, dict(list(COLUMNS.items())[:-1])):
        found = folded([3])
        with pytest.raises(FolderError, match=r"chunk 4: other columns than in chunk 3: (metric\.(peak_chi|more)|draw\.turn);"):
            found.add(4, chunk(4), columns)
    for rows in ([0, 2], [1, 0], [0, 0], []):
        with pytest.raises(FolderError, match="not consecutive"):
            folded([3]).add(0, TABLE.iloc[rows], COLUMNS)


def test_the_account_adds_up(whole: Totals) -> None:
    """Kills: missing samples that are not counted, a sample that nobody requested."""
    account = whole.account(N + 7)
    assert (account.requested, account.missing) == (N + 7, 7)
    assert account.captured + account.not_settled + account.collided + account.not_finite == N
    assert whole.account(N).missing == 0
    with pytest.raises(FolderError, match=f"sample 1999: only {10 * SIZE - 1} samples were requested"):
        folded([9]).account(10 * SIZE - 1)
    with pytest.raises(FolderError, match="do not add up"):
        folded([3], frame=TABLE.assign(outcome="eaten")).account(N)
