"""The run folder keeps what it is given, says what it lacks, and refuses what is not its own."""

from __future__ import annotations

import json
import math
import os
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rvjax.errors import FolderError, IncompleteError
from rvjax.run_folder import Account, Column, RunFolder, atomic_files, checksums
from rvjax.run_folder.local_storage import LocalStorage
from rvjax.run_folder.parquet import decode, encode

from .conftest import COLUMNS, IDENTITY, chunk, create, history, only

# --- what goes in comes out -----------------------------------------------------------------------------------------


def test_round_trip_keeps_every_bit_and_its_meaning(finished: Path) -> None:
    """NaN, infinities, -0.0, float32, units and descriptions. Kills: NaN as null, lost metadata, unsorted chunks."""
    folder = RunFolder.open(finished)
    expected = pd.concat([chunk(i, 10) for i in range(3)], ignore_index=True)
    found = folder.samples()
    pd.testing.assert_frame_equal(found.frame, expected, check_exact=True, check_dtype=False)
    assert found.frame.dtypes["metric.peak_chi"] == np.float32
    assert {name: found.columns[name] for name in COLUMNS if name in found.frame} == {
        name: column for name, column in COLUMNS.items() if name in found.frame
    }
    assert np.signbit(folder.envelopes()["rho_m"].to_numpy()).tolist() == [True, True, False, False] * 5
    assert folder.trace_samples() == [3]
    assert folder.campaign_text() == "rvjax: 1\n"
    assert (folder.name, folder.identity, folder.requested) == ("small", IDENTITY, 10)
    arrow = pq.read_table(only(finished, "samples/00000"))
    assert arrow["metric.settling_time_s"].null_count == 0
    assert arrow.schema.field("metric.settling_time_s").metadata == {
        b"unit": b"s",
        b"description": b"time to settle",
        b"better": b"lower",
    }


def test_chunks_may_come_in_any_order_and_as_arrow_tables(tmp_path: Path, finished: Path) -> None:
    """Kills: rows in order of arrival, a manifest that depends on it."""
    with create(tmp_path / "other") as folder:
        for index in (2, 0, 1):
            folder.write_envelope(index, history(index), COLUMNS)
            table = chunk(index, 10)
            arrow = pa.table({name: pa.array(table[name].to_numpy()) for name in table.columns})
            folder.commit(index, arrow if index else table, COLUMNS)
        folder.write_traces({3: (history(0).drop(columns="sample"), COLUMNS)})
    assert (tmp_path / "other" / "manifest.json").read_bytes() == (finished / "manifest.json").read_bytes()


def test_rows_come_in_the_order_of_the_samples(tmp_path: Path) -> None:
    """However chunks are numbered. Kills: joining without sorting."""
    with create(tmp_path / "run") as folder:
        folder.commit(0, chunk(1, 10), COLUMNS)
        folder.commit(1, chunk(0, 10), COLUMNS)
        assert folder.samples().frame["sample"].tolist() == list(range(8))


def test_manifest_is_one_document_as_the_contract_says(finished: Path) -> None:
    """Kills: a changed key of the public format."""
    document = json.loads((finished / "manifest.json").read_text())
    told = ["format", "name", "samples", "identity", "provenance", "audit", "campaign", "inputs"]
    assert list(document) == [*told, "files", "sha256"]
    (entry,) = (entry for entry in document["files"] if entry["file"].startswith("samples/00002"))
    data = only(finished, "samples/00002").read_bytes()
    name = f"samples/00002-{atomic_files.sha256(data)[:16]}.parquet"
    assert entry == {"file": name, "sha256": atomic_files.sha256(data), "bytes": len(data), "first": 8, "count": 2}


def test_account_adds_up_over_all_that_was_requested(tmp_path: Path, finished: Path) -> None:
    """Kills: missing samples left out, not-finite ones counted as not settled."""
    assert RunFolder.open(finished).account() == Account(10, captured=5, not_settled=3, collided=0, not_finite=2, missing=0)
    with create(tmp_path / "part") as folder:
        assert folder.account() == Account(10, 0, 0, 0, 0, missing=10)
        folder.commit(1, chunk(1, 10), COLUMNS)
        assert folder.missing(3) == [0, 2]
        assert folder.account() == Account(10, captured=2, not_settled=1, collided=0, not_finite=1, missing=6)
    with pytest.raises(FolderError, match="do not add up"):
        Account(10, 5, 3, 0, 2, 1)


def test_a_table_that_is_no_chunk_is_a_programmer_s_error(tmp_path: Path) -> None:
    """Kills: unknown outcomes, holes in the samples, columns without a unit."""
    table = chunk(0, 10)
    with create(tmp_path / "run") as folder:
        with pytest.raises(ValueError, match="consecutive"):
            folder.commit(0, table.assign(sample=[0, 1, 1, 2]), COLUMNS)
        with pytest.raises(ValueError, match=r"outcomes must be of .* found \['lost'\]"):
            folder.commit(0, table.assign(outcome="lost"), COLUMNS)
        with pytest.raises(ValueError, match=r"without unit and description: metric\.new"):
            folder.commit(0, table.assign(**{"metric.new": 1.0}), COLUMNS)
        with pytest.raises(IncompleteError, match="no chunk is finished"):
            folder.samples()


def test_summary_is_strict_json(finished: Path) -> None:
    """Kills: NaN and Infinity, which are not JSON."""
    summary = {"share": np.float64(0.5), "band": (math.nan, math.inf), "list": np.arange(2), "n": np.int64(3)}
    RunFolder.open(finished).write_summary(summary)
    text = (finished / "summary.json").read_text()
    assert json.loads(text, parse_constant=pytest.fail) == {"share": 0.5, "band": [None, None], "list": [0, 1], "n": 3}


# --- damage ---------------------------------------------------------------------------------------------------------


def test_no_damage_goes_unnoticed(finished: Path) -> None:
    """One bit flipped, a block zeroed, the end cut off, the file gone: 50 places in every file of data.

    Kills: trusting sizes or page checksums, a manifest that does not cover itself.
    """
    targets = [path for path in finished.rglob("*") if path.is_file()]
    assert len(targets) == 2 + 1 + 3 + 3 + 1
    generator = np.random.default_rng(1)
    for path in targets:
        good = path.read_bytes()
        damaged: list[bytes | None] = [None, b"", good[: len(good) // 2], good[:-1], bytes(len(good))]
        if path.name != "journal.jsonl":  # there it is a line cut short
            damaged.append(good + b" ")
        for place in generator.integers(len(good), size=44):
            flipped = bytearray(good)
            flipped[place] ^= 1 << int(generator.integers(8))
            damaged.append(bytes(flipped))
        for data in damaged:
            path.unlink(missing_ok=True)
            if data is not None:
                path.write_bytes(data)
            with pytest.raises(FolderError, match=path.name):
                RunFolder.open(finished).verify()
        path.write_bytes(good)
    RunFolder.open(finished).verify()


@pytest.mark.parametrize("other", ["\v", "\f", "\x1c", "\x1e", "\r", "\x85", "\u2028"])
def test_only_a_line_feed_ends_a_line_of_the_sums(tmp_path: Path, other: str) -> None:
    """Kills: sums that are split at whatever Python takes for a line end, so that a changed bit of a line end is silent."""
    checksums.seal(LocalStorage(tmp_path), {"report.md": "a" * 64, "summary.json": "b" * 64})
    sums = tmp_path / checksums.NAME
    text = sums.read_bytes()
    assert not any("damaged" in complaint for complaint in checksums.complaints(LocalStorage(tmp_path)))
    sums.write_bytes(text.replace(b"\n", other.encode(), 1))
    assert "damaged or edited" in checksums.complaints(LocalStorage(tmp_path))[0]


def test_damage_message_says_what_was_expected_found_and_helps(finished: Path) -> None:
    """Through the reader, not only `verify`. Kills: reading without comparing."""
    path = only(finished, "samples/00001")
    good, bad = path.read_bytes(), path.read_bytes()[:-1]
    path.write_bytes(bad)
    with pytest.raises(FolderError) as caught:
        RunFolder.open(finished).samples()
    for part in (str(path), atomic_files.sha256(good), atomic_files.sha256(bad), "rvjax run"):
        assert part in str(caught.value)


def test_pages_carry_checksums() -> None:
    """Every bit flip among the pages is noticed by Parquet itself. Kills: write_page_checksum off, its default."""
    table = pd.DataFrame({"rho_m": np.random.default_rng(0).normal(size=300)})
    data = encode(table, COLUMNS)
    footer = len(data) - 8 - int.from_bytes(data[-8:-4], "little")
    column = pq.ParquetFile(pa.BufferReader(data)).metadata.row_group(0).column(0)
    first = footer - column.total_compressed_size
    for place in range(first + 100, footer, 7):
        flipped = bytearray(data)
        flipped[place] ^= 4
        with pytest.raises((OSError, pa.ArrowException)):
            decode(bytes(flipped))


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "damaged, not a manifest"),
        ("[]", "damaged, not a manifest"),
        ("{}", "damaged, not a manifest"),
        ('{"format": 1}', "format 1; accepted: 2"),
        ("[" * 100_000, "damaged, not a manifest"),
        ('{"format": 2, "files": [{"file": "../x"}], "sha256": ""}', "damaged, not a manifest"),
    ],
)
def test_a_manifest_that_is_none_is_refused(finished: Path, text: str, complaint: str) -> None:
    """Kills: a traceback from the parser, trusting what the file says."""
    (finished / "manifest.json").write_text(text)
    with pytest.raises(FolderError, match=complaint):
        RunFolder.open(finished)


def test_manifest_cannot_point_out_of_the_folder(finished: Path) -> None:
    """Even with a matching SHA-256, also through a link. Kills: joining paths without looking."""
    path = finished / "manifest.json"
    document = json.loads(path.read_text())
    del document["sha256"]
    document["files"][0]["file"] = "samples/../../secret.parquet"
    body = (json.dumps(document, indent=1) + "\n").encode()
    path.write_text(json.dumps(document | {"sha256": atomic_files.sha256(body)}, indent=1) + "\n")
    with pytest.raises(FolderError, match="not a manifest"):
        RunFolder.open(finished)


# --- places ---------------------------------------------------------------------------------------------------------

HOSTILE = ["", ".", "..", "/etc/x", "../x", "figures/../../x", "a/../../x", "//x", "..\\x", "C:\\x", "x\0y", "link/x", "a/../b"]


@pytest.mark.parametrize("name", HOSTILE)
def test_names_that_lead_out_are_refused(finished: Path, name: str) -> None:
    """Kills: `..`, absolute paths and links followed out of the folder."""
    outside = finished.parent / "outside"
    outside.mkdir()
    (finished / "link").symlink_to(outside)
    with pytest.raises(FolderError, match="leads out of the run folder"):
        RunFolder.open(finished).write_text(name, "x")
    assert list(outside.iterdir()) == []
    assert sorted(path.name for path in finished.parent.iterdir()) == ["outside", "run"]


@settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(name=st.text(st.sampled_from("./\\ab\0~ \n%ü"), max_size=12))
def test_no_name_writes_outside(finished: Path, name: str) -> None:
    """Kills: a spelling that the list above lacks."""
    try:
        path = RunFolder.open(finished).write_text(name, "x")
    except FolderError:
        return
    except IncompleteError as error:
        pytest.fail(str(error))
    assert os.path.realpath(path).startswith(os.path.realpath(finished) + os.sep)
    assert [entry.name for entry in finished.parent.iterdir()] == ["run"]


@pytest.mark.parametrize(
    "name", ["manifest.json", "./manifest.json", "samples/x", "traces/x", "journal.jsonl", "SHA256SUMS", "campaign.yaml"]
)
def test_data_are_never_overwritten_by_a_report(finished: Path, name: str) -> None:
    """Kills: a figure that replaces a chunk."""
    with pytest.raises(FolderError, match="holds data of the run"):
        RunFolder.open(finished).write_bytes(name, b"x")
    RunFolder.open(finished).verify()


def test_wrong_places_are_explained(tmp_path: Path, finished: Path) -> None:
    """Kills: a traceback, or starting over in a folder that has something in it."""
    (tmp_path / "file").write_text("x")
    for place in ("nowhere", "file", "file/below", "."):
        with pytest.raises(FolderError, match=r"not a run folder|Not a directory"):
            RunFolder.open(tmp_path / place)
    for place in (finished, tmp_path / "file", tmp_path / "file" / "below", tmp_path):
        with pytest.raises(FolderError, match="--out"):
            create(place)
    assert RunFolder.open(finished).account().missing == 0
    (tmp_path / "empty").mkdir()
    create(tmp_path / "empty").close()


def test_columns_that_change_between_chunks_are_named(tmp_path: Path) -> None:
    """Kills: a table with holes."""
    with create(tmp_path / "run") as folder:
        folder.commit(0, chunk(0, 10), COLUMNS)
        folder.commit(1, chunk(1, 10).drop(columns="draw.mass_kg"), COLUMNS)
        changed = COLUMNS | {"outcome_time_s": Column("outcome_time_s", "ms", "when")}
        with pytest.raises(FolderError, match=r"00001-.*: other columns than in .*00000-.*: draw.mass_kg"):
            folder.samples()
        folder.commit(2, chunk(2, 10), changed)


def test_samples_that_are_twice_or_were_not_requested_are_refused(tmp_path: Path) -> None:
    """Kills: counting a sample double."""
    with create(tmp_path / "run") as folder:
        folder.commit(0, chunk(0, 10), COLUMNS)
        folder.commit(1, chunk(0, 10), COLUMNS)
        with pytest.raises(FolderError, match="8 rows of 4 different samples"):
            folder.samples()
        with pytest.raises(FolderError, match="chunks share samples"):
            folder.account()
    with create(tmp_path / "more") as folder:
        folder.commit(3, chunk(3, 16), COLUMNS)
        with pytest.raises(FolderError, match="up to number 15, but 10 were requested"):
            folder.samples()
    with create(tmp_path / "one more", 15) as folder:
        folder.commit(3, chunk(3, 16), COLUMNS)
        with pytest.raises(FolderError, match="up to number 15, but 15 were requested"):
            folder.samples()
