"""The run folder: everything a run leaves behind, complete or absent, never torn, every byte accounted for."""

from __future__ import annotations

from rvjax.columns import Column
from rvjax.results.datafile import DataFile
from rvjax.results.folder import BASELINES, CAMPAIGN, RunFolder
from rvjax.results.manifest import Audited
from rvjax.results.samples import OUTCOMES, Account, Samples

__all__ = ["BASELINES", "CAMPAIGN", "OUTCOMES", "Account", "Audited", "Column", "DataFile", "RunFolder", "Samples"]
