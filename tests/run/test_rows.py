"""Rows of single samples come from the chunks that hold them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from rvjax.errors import UsageError
from rvjax.execution.replay import recorded
from rvjax.run_folder import Column, RunDescription, RunFolder

COLUMNS = {"metric.x": Column("metric.x", "1", "made up")}


@pytest.fixture
def folder(tmp_path: Path) -> RunFolder:
    """40 samples in chunks of 10, the third one missing."""
    description = RunDescription(identity={}, provenance={}, campaign_text="name: made-up\n", samples=40, name="made-up")
    with RunFolder.create(tmp_path / "run", description) as made:
        for chunk in (3, 0, 1):
            sample = np.arange(10 * chunk, 10 * chunk + 10)
            made.commit(chunk, pd.DataFrame({"sample": sample, "outcome": "captured", "metric.x": sample / 7}), COLUMNS)
    return RunFolder.open(tmp_path / "run")


@pytest.mark.parametrize(("samples", "chunks"), [([7], [0]), ([39, 0, 9, 30], [0, 3]), ([10, 19], [1]), ([5, 5], [0])])
def test_only_the_chunks_of_the_samples_are_read(folder: RunFolder, samples: list[int], chunks: list[int]) -> None:
    """In the order asked for, also where others are damaged. Kills: the whole table, a row of another sample, a chunk's ends."""
    for number in {0, 1, 3} - set(chunks):
        (folder.path / f"samples/{number:05d}.parquet").write_bytes(b"damaged")
    rows = recorded(folder, samples)
    assert rows["sample"].tolist() == samples
    assert rows["metric.x"].tolist() == [sample / 7 for sample in samples]
    assert rows.index.tolist() == list(range(len(samples)))


def test_a_sample_that_is_not_there_is_named(folder: RunFolder) -> None:
    """Kills: a sample of a missing chunk, or beyond the last, that gives no row or another one's."""
    with pytest.raises(UsageError, match="no sample 20, 29, 40; accepted: 0 to 39, if flown"):
        recorded(folder, [3, 40, 29, 20])
