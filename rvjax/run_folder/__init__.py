"""The run folder: everything a run leaves behind, complete or absent, never torn, every byte accounted for."""

from __future__ import annotations

from rvjax.columns import Column
from rvjax.run_folder.data_file import DataFile
from rvjax.run_folder.folder import BASELINES, CAMPAIGN, RunFolder
from rvjax.run_folder.manifest import Audited
from rvjax.run_folder.samples_table import OUTCOMES, Account, Samples

__all__ = ["BASELINES", "CAMPAIGN", "OUTCOMES", "Account", "Audited", "Column", "DataFile", "RunFolder", "Samples"]
