"""What a search leaves for others: the best campaign, ready to fly, and the table of all candidates."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from typing import Any

from ruamel.yaml import YAML

from rvjax.searched import Searched
from rvjax.spec import Spec
from rvjax.spec.choice import NAME
from rvjax.spec.overrides import override
from rvjax.spec.parameters import Value
from rvjax.spec.source import read_text
from rvjax.tuning.space import Space

ENDING = "-tuned"


def best_campaign(spec: Spec, space: Space, values: Mapping[str, Value], overrides: Sequence[str]) -> str:
    """The campaign with the best values, what was set beside the file, and the draws of its confirmation; without `tune`."""
    assert spec.tune is not None, "it was tuned"
    named = f"{spec.name}{ENDING}"
    fresh = {"samples": spec.tune.confirm.samples, "seed": spec.tune.confirm.seed}
    more = [f"{name}={value}" for name, value in fresh.items() if value is not None]
    more += [f"name={named}"] if NAME.fullmatch(named) else []
    source = override(read_text(spec.source.text, spec.source.name), [*overrides, *more, *space.assignments(values)])
    assert not source.findings and source.value is not None, "every value was loaded before"
    said: dict[str, Any] = {key: value for key, value in source.value.items() if key != "tune"}
    writer: Any = YAML()
    writer.default_flow_style = None
    writer.width = 110
    text = io.StringIO()
    writer.dump(said, text)
    which = "Values as they were: none that the search tried was better." if not values else "Values found by `rvjax tune`."
    return f"# {which} `rvjax run` with this file flies the draws that confirmed them.\n{text.getvalue()}"


def candidates_table(found: Searched) -> str:
    """One row a candidate, as CSV: where it was proposed, how far it came, its objectives and values."""
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    objectives = [f"{one.text} [{one.unit}]" if one.unit not in ("", "1") else one.text for one in found.objectives]
    names = [one.name for one in found.parameters]
    rows.writerow(["candidate", "batch", "rounds", "samples", "left", "violation", *objectives, *names])
    for row in found.rows:
        shown = row.objectives or [""] * len(objectives)
        values = [row.values.get(name, "") for name in names]
        rows.writerow([row.candidate, row.batch, row.round + 1, row.samples, row.left, row.violation, *shown, *values])
    return text.getvalue()
