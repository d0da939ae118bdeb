"""`rvjax reweigh`: a finished run under other laws, without a flight."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated

import typer

from rvjax.cli._app import Folder, Json, Quiet, Sets
from rvjax.cli._output import Output
from rvjax.cli._slopes import show_slopes
from rvjax.errors import UsageError

if TYPE_CHECKING:
    from rvjax.execution.reweigh import Reweighed
    from rvjax.stats import Estimate

EXPLORATION, NAMED = "exploration", "named before flying"
"""Status of the laws."""


def command(
    folder: Folder,
    *,
    sets: Sets = None,
    law: Annotated[str | None, typer.Option("--law", metavar="NAME", help="A law that the campaign names.")] = None,
    slopes: Annotated[bool, typer.Option("--slopes", help="How failures change with every parameter of the laws.")] = False,
    shown: Annotated[int, typer.Option("--show", min=1, metavar="N", help="Slopes shown for each requirement, up to N.")] = 10,
    confidence: Annotated[float, typer.Option("--confidence", min=0.5, max=0.9999, help="Of the intervals.")] = 0.95,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Show a finished run under other laws of its draws."""
    from rvjax.execution.reweigh import reweigh

    output = Output(as_json, quiet)
    if slopes:
        if sets or law is not None:
            raise UsageError("reweigh: --slopes with other laws; accepted: --slopes alone, which is about the laws of the run")
        show_slopes(folder, confidence, shown, output)
        return 0
    if not sets and law is None:
        accepted = "--set PATH=LAW, such as --set 'pursuer.mass_kg={uniform: [90, 110]}', --law NAME or --slopes"
        raise UsageError(f"reweigh: no other law; accepted: {accepted}")
    if sets and law is not None:
        raise UsageError("reweigh: both --set and --law; accepted: one of them")
    found = reweigh(folder, sets or (), confidence, named=law)
    _show(found, output)
    output.document(
        {
            "folder": str(folder),
            "status": EXPLORATION if law is None else NAMED,
            "law": law,
            "laws": found.law.record(),
            "samples": found.n,
            "kept": found.kept,
            "beyond": found.law.beyond,
            "effective_samples": found.quality.effective,
            "largest_weight": found.quality.largest,
            "tail_shape": found.quality.k,
            "shares": [asdict(share) for share in found.shares],
            "refused": list(found.refusals),
            "pinned": list(found.pinned),
            "fresh_run": found.fresh,
        }
    )
    return 0


def _show(found: Reweighed, output: Output) -> None:
    from rvjax.campaign.law_words import in_words

    for change in found.law.changes:
        output.text(f"{', '.join(change.draws)}: {in_words(change.old)} → {in_words(change.new)}")
    effective = f"effective sample size of the weights {found.quality.effective:,.0f}"
    output.text(f"{found.kept:,} of {found.n:,} samples are independent samples of the new law; {effective}")
    if found.pinned:
        output.text(f"as flown, although they follow from a changed law by default: {', '.join(found.pinned)}")
    if found.law.beyond:
        output.text(
            f"{100 * found.law.beyond:.3g} % of the new law lies where the run has no sample: every interval allows for both"
        )
    rows = [(share.name, _text(share.flown), _text(share.thinned), _text(share.weighted)) for share in found.shares]
    output.table(("complies", "as flown", "new law, exact", "new law, by weights (nominal)"), rows)
    for refusal in found.refusals:
        output.text(f"not shown: {refusal}")
    if found.named is None:
        output.text(f"{EXPLORATION}: laws that are chosen after the flights give no verdict")
    elif found.law.beyond > 0.0 or not math.isfinite(found.law.log_sup):
        output.text(f"{NAMED}, but no verdict: not all of {found.named} lies within the laws of the run, with a bounded ratio")
    else:
        output.text(f"{NAMED}: a requirement with under: {found.named} is judged by the kept samples")
    output.text(f"a fresh run: {found.fresh}")


def _text(estimate: Estimate | None) -> str:
    if estimate is None:
        return "–"
    return f"{100 * estimate.value:.2f} % [{100 * estimate.low:.2f}, {100 * estimate.high:.2f}]"
