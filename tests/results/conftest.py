"""A small run to write: 10 samples in chunks of 4, with histories and one trace."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from rvjax.run_folder import Column, RunDescription, RunFolder

LANES = 4
IDENTITY: dict[str, Any] = {"campaign": "ab12", "seed": 7, "device": {"kind": "cpu"}, "lanes": [LANES]}
COLUMNS = {
    column.name: column
    for column in (
        Column("outcome_time_s", "s", "when the outcome was decided"),
        Column("draw.mass_kg", "kg", "mass of the pursuer"),
        Column("metric.settling_time_s", "s", "time to settle", "lower"),
        Column("metric.peak_chi", "1", "largest Nussbaum argument", "lower"),
        Column("t_s", "s", "time"),
        Column("rho_m", "m", "distance of the ports"),
    )
}


def chunk(index: int, requested: int) -> pd.DataFrame:
    """A pure function of the chunk's number, as flights are; the last chunk is cut at the requested samples."""
    sample = np.arange(index * LANES, min(requested, (index + 1) * LANES))
    generator = np.random.default_rng(index)
    outcome = np.array(["captured", "not_settled", "not_finite", "captured"])[sample % 4]
    settling = generator.uniform(50, 150, LANES)[: sample.size]
    settling = np.where(outcome == "not_settled", math.inf, np.where(outcome == "not_finite", math.nan, settling))
    return pd.DataFrame(
        {
            "sample": sample,
            "outcome": outcome,
            "outcome_time_s": np.full(sample.size, 300.0),
            "draw.mass_kg": generator.uniform(80, 120, LANES)[: sample.size],
            "metric.settling_time_s": settling,
            "metric.peak_chi": settling.astype(np.float32),
        }
    )


def history(index: int, requested: int = 10) -> pd.DataFrame:
    """Two instants of a chunk's samples."""
    sample = np.repeat(np.arange(index * LANES, min(requested, (index + 1) * LANES)), 2)
    return pd.DataFrame({"sample": sample, "t_s": np.resize([0.0, 1.0], sample.size), "rho_m": np.where(sample % 2, 5.0, -0.0)})


def lacking(folder: RunFolder, requested: int = 10) -> list[int]:
    """The chunks that are missing, damaged ones among them, as a run finds out."""
    count = -(-requested // LANES)
    folder.quarantine_damaged(["envelopes", "traces"])
    for _ in folder.read_valid_chunks([entry.number for entry in folder.chunks]):
        pass
    return folder.missing(count, envelopes=count)


def fly(folder: RunFolder, requested: int = 10) -> None:
    """Flies what is missing, as a run does."""
    for index in lacking(folder, requested):
        folder.write_envelope(index, history(index, requested), COLUMNS)
        folder.commit(index, chunk(index, requested), COLUMNS)
    folder.write_traces({3: (history(0).drop(columns="sample"), COLUMNS)})


def only(path: Path, stem: str) -> Path:
    """The one file of data whose name begins so."""
    (found,) = path.glob(f"{stem}-*.parquet")
    return found


def described(
    requested: int, identity: dict[str, Any] = IDENTITY, text: str = "rvjax: 1\n", command: str = "rvjax run"
) -> RunDescription:
    """The small run."""
    provenance = {"command": command}
    return RunDescription(identity=identity, provenance=provenance, campaign_text=text, samples=requested, name="small")


def create(path: Path, requested: int = 10) -> RunFolder:
    """A new run folder for that run."""
    return RunFolder.create(path, described(requested))


def resume(
    path: Path, requested: int, identity: dict[str, Any] = IDENTITY, text: str = "rvjax: 1\n", command: str = "rvjax run"
) -> RunFolder:
    """The folder of `create`, resumed."""
    return RunFolder.resume(path, described(requested, identity, text, command), LANES)


@pytest.fixture
def finished(tmp_path: Path) -> Path:
    """A run folder with the whole run in it."""
    with create(tmp_path / "run") as folder:
        fly(folder)
    return tmp_path / "run"
