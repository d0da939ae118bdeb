"""The run folder: all results of a run. Files are written atomically and verified by their SHA-256."""

from __future__ import annotations

from rvjax.columns import Column
from rvjax.run_folder.data_file import DataFile
from rvjax.run_folder.folder import BASELINES, CAMPAIGN, RunFolder
from rvjax.run_folder.manifest import Audited
from rvjax.run_folder.run_description import RunDescription
from rvjax.run_folder.samples_table import OUTCOMES, Account, Samples

__all__ = [
    "BASELINES",
    "CAMPAIGN",
    "OUTCOMES",
    "Account",
    "Audited",
    "Column",
    "DataFile",
    "RunDescription",
    "RunFolder",
    "Samples",
]
