"""What a search leaves for others: the best campaign, ready to fly, and the table of all candidates."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence

from rvjax.campaign import Spec
from rvjax.campaign.export import campaign_text
from rvjax.campaign.tuning_parameters import Value
from rvjax.run_folder.tuning_record import Searched
from rvjax.search.tuning.space import Space


def best_campaign(spec: Spec, space: Space, values: Mapping[str, Value], overrides: Sequence[str], *, met: bool = True) -> str:
    """The campaign with the best values, what was set beside the file, and the draws of its confirmation; without `tune`.

    met: whether a candidate meets the requirements.
    """
    assert spec.tune is not None, "it was tuned"
    fresh = {"samples": spec.tune.confirm.samples, "seed": spec.tune.confirm.seed}
    more = [f"{name}={value}" for name, value in fresh.items() if value is not None]
    kept = "no candidate of the search was better" if met else "no candidate of the search meets the requirements"
    which = "Values by `rvjax tune`." if values else f"Original values: {kept}."
    comment = f"{which} `rvjax run` with this file flies the draws that confirmed them."
    return campaign_text(spec, [*overrides, *more, *space.assignments(values)], ("tune",), "-tuned", comment)


def candidates_table(record: Searched) -> str:
    """One row a candidate, as CSV: where it was proposed, how far it came, its objectives and values."""
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    objectives = [
        f"{objective.text} [{objective.unit}]" if objective.unit not in ("", "1") else objective.text
        for objective in record.objectives
    ]
    names = [parameter.name for parameter in record.parameters]
    rows.writerow(["candidate", "batch", "rounds", "samples", "left", "violation", *objectives, *names])
    for row in record.rows:
        shown = row.objectives or [""] * len(objectives)
        values = [row.values.get(name, "") for name in names]
        rows.writerow([row.candidate, row.batch, row.round + 1, row.samples, row.left, row.violation, *shown, *values])
    return text.getvalue()
