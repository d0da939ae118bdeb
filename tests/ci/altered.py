"""A run folder with other columns than it had."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from pathlib import Path

import pandas as pd

from rvjax.run_folder import RunDescription, RunFolder

Change = Callable[[pd.DataFrame], Mapping[str, object]]


def after(before: Path, place: Path, change: Change) -> Path:
    """The same run with other columns."""
    old = RunFolder.open(before)
    shutil.rmtree(place, ignore_errors=True)
    text = old.campaign_text()
    description = RunDescription(
        identity=old.identity, provenance=old.provenance, campaign_text=text, samples=old.requested, name=old.name
    )
    with RunFolder.create(place, description) as folder:
        for chunk, frame, columns in old.tables():
            folder.commit(chunk, frame.assign(**change(frame)), columns)
    return place
