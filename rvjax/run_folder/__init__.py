"""The run folder: all results of a run. Files are written atomically and verified by their SHA-256.

Public names are imported on first use: what only checks a path needs no pandas.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rvjax.columns import Column
    from rvjax.run_folder.data_file import DataFile
    from rvjax.run_folder.folder import BASELINES, CAMPAIGN, RunFolder
    from rvjax.run_folder.manifest import Audited
    from rvjax.run_folder.run_description import RunDescription
    from rvjax.run_folder.samples_table import Account, Samples

__all__ = [
    "BASELINES",
    "CAMPAIGN",
    "Account",
    "Audited",
    "Column",
    "DataFile",
    "RunDescription",
    "RunFolder",
    "Samples",
]

_ORIGIN = {
    "BASELINES": "run_folder.folder",
    "CAMPAIGN": "run_folder.folder",
    "Account": "run_folder.samples_table",
    "Audited": "run_folder.manifest",
    "Column": "columns",
    "DataFile": "run_folder.data_file",
    "RunDescription": "run_folder.run_description",
    "RunFolder": "run_folder.folder",
    "Samples": "run_folder.samples_table",
}
"""Public name → module."""


def __getattr__(name: str) -> Any:
    if name not in _ORIGIN:
        raise AttributeError(f"module 'rvjax.run_folder' has no attribute {name!r}")
    return getattr(import_module(f"rvjax.{_ORIGIN[name]}"), name)
