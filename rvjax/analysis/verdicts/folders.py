"""Verdicts from a run folder, without flying."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rvjax.analysis.run_totals import Ledger
from rvjax.analysis.verdicts.rare import conclude_all
from rvjax.analysis.verdicts.tally import tallies
from rvjax.campaign import load
from rvjax.campaign.named_laws import LAWS
from rvjax.components.samplers import sampling_design_of
from rvjax.errors import FolderError, IncompleteError, UsageError
from rvjax.places import Place
from rvjax.run_folder import Account, RunFolder
from rvjax.run_folder.tuning_record import ORIGINAL, TUNED
from rvjax.stats.other_laws import OtherLaw

if TYPE_CHECKING:
    from rvjax.analysis.verdicts.verdict import Verdict
    from rvjax.campaign import Spec


SEARCH = "tune"
"""The key in the identity of a folder that shows that it belongs to a search (`rvjax.run_folder.tuning_record`)."""

RARE = "rare"
"""The same for a search of rare failures (`rvjax.run_folder.rare_record`)."""


def campaign_of(folder: RunFolder) -> Spec:
    """The campaign of a run folder, with the overrides that its provenance records.

    FolderError if the campaign file was changed; UsageError if the folder belongs to a search, whose flights are of many
    candidates or no samples.
    """
    if SEARCH in folder.identity:
        confirming = ", ".join(str(folder.path / name) for name in (TUNED, ORIGINAL))
        raise UsageError(f"{folder.path}: the folder of a search, whose flights are of many candidates; accepted: {confirming}")
    if RARE in folder.identity:
        raise UsageError(
            f"{folder.path}: the folder of a search of rare failures, whose flights are no samples; "
            f"accepted: {folder.path.parent}"
        )
    spec = load(folder.campaign_source(), [str(item) for item in folder.provenance.get("overrides", ())])
    if not spec.laws:
        return spec
    laws = laws_of(folder)
    return spec.model_copy(update={"require": tuple(requirement.judged_under(laws) for requirement in spec.require)})


def laws_of(folder: RunFolder) -> dict[str, OtherLaw]:
    """The laws that the campaign of a run named before it flew, from the identity of the run. FolderError if they are damaged."""
    try:
        seed = int(folder.identity["seed"])
        return {str(name): OtherLaw.of(laws, seed) for name, laws in folder.identity.get(LAWS, {}).items()}
    except (KeyError, ValueError, TypeError, AttributeError) as error:
        raise FolderError(f"{folder.path}: its identity has a law that cannot be read ({error})") from error


def judge_folder(path: str | Place) -> tuple[Verdict, ...]:
    """The verdict on each requirement of a finished run. Errors as in `account_and_verdicts`."""
    return account_and_verdicts(path)[1]


def account_and_verdicts(path: str | Place) -> tuple[Account, tuple[Verdict, ...]]:
    """The outcomes of the samples of a finished run, and the verdict on each requirement, read in a single pass.

    FolderError if the path is not a run folder or the folder is damaged. IncompleteError if samples are missing: a verdict on
    the others would not keep its promise.
    """
    folder = RunFolder.open(path)
    if missing := folder.requested - folder.chunks.total:
        raise IncompleteError(
            f"{path}: {missing} of {folder.requested} samples are missing; `rvjax run` with the same --out flies them"
        )
    campaign, ledger = campaign_of(folder), Ledger()
    counted, columns = tallies(sampling_design_of(campaign), campaign.require), folder.columns()
    needed = counted.columns(list(columns))
    for chunk, frame, begins in folder.extracted(needed) or folder.some(["sample", "outcome", *needed]):
        ledger.add(chunk, frame, columns)
        counted.add(frame, columns, begins)
    return ledger.account(folder.requested), conclude_all(counted.verdicts(), folder.path)
