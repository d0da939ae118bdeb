"""Verdicts of a run folder alone."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from rvjax.analysis.run_totals import Ledger
from rvjax.analysis.verdicts.tally import tallies
from rvjax.campaign import load
from rvjax.components.samplers import sampling_design_of
from rvjax.errors import IncompleteError, UsageError
from rvjax.run_folder import CAMPAIGN, Account, RunFolder

if TYPE_CHECKING:
    from rvjax.analysis.verdicts.verdict import Verdict
    from rvjax.campaign import Spec


SEARCH = "tune"
"""Of the identity of a folder: it is that of a search (`rvjax.run_folder.tuning_record`)."""


def campaign_of(folder: RunFolder) -> Spec:
    """The campaign of a run folder, with what was set beside the file (`overrides` of its provenance).

    FolderError where the file was changed since; UsageError where it is the folder of a search, whose flights are of many
    candidates.
    """
    if SEARCH in folder.identity:
        place = folder.path
        accepted = f"accepted: {place / 'tuned'}, {place / 'own'}"
        raise UsageError(f"{place}: the folder of a search, whose flights are of many candidates; {accepted}")
    folder.campaign_text()  # verifies the file that is parsed next
    return load(folder.path / CAMPAIGN, [str(item) for item in folder.provenance.get("overrides", ())])


def judge_folder(path: str | Path) -> tuple[Verdict, ...]:
    """The verdict of a finished run on each requirement of its campaign; errors as of `account_and_verdicts`."""
    return account_and_verdicts(path)[1]


def account_and_verdicts(path: str | Path) -> tuple[Account, tuple[Verdict, ...]]:
    """How the samples of a finished run ended, and the verdict on each requirement of its campaign, in one pass.

    FolderError where the folder is none or is damaged. IncompleteError where samples are missing: a verdict on those
    that happen to be there would not keep its promise.
    """
    folder = RunFolder.open(path)
    if missing := folder.requested - sum(chunk.count for chunk in folder.chunks):
        raise IncompleteError(
            f"{path}: {missing} of {folder.requested} samples are missing; `rvjax run` with the same --out flies them"
        )
    campaign, ledger = campaign_of(folder), Ledger()
    counted, columns = tallies(sampling_design_of(campaign), campaign.require), folder.columns()
    needed = counted.columns(list(columns))
    for chunk, frame, begins in folder.extracted(needed) or folder.some(["sample", "outcome", *needed]):
        ledger.add(chunk, frame, columns)
        counted.add(frame, columns, begins)
    return ledger.account(folder.requested), counted.verdicts()
