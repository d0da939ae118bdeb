"""Campaign text from a campaign: other values at some places, parts left out; as it was set beside the file, too."""

from __future__ import annotations

import io
from collections.abc import Collection, Sequence
from typing import Any

from ruamel.yaml import YAML

from rvjax.campaign import Spec
from rvjax.campaign.choice import NAME
from rvjax.campaign.overrides import override
from rvjax.campaign.source import read_text

WIDTH = 110


def campaign_text(spec: Spec, assignments: Sequence[str], without: Collection[str], ending: str, comment: str) -> str:
    """The campaign of a spec with further assignments `place=value`, without some keys, its name with an ending where that can be
    one; comment: the first line. Loads like any campaign that a person writes."""
    named = f"{spec.name}{ending}"
    more = [f"name={named}"] if NAME.fullmatch(named) else []
    source = override(read_text(spec.source.text, spec.source.name), [*assignments, *more])
    assert source.value is not None, "it was read before"
    assert not source.findings, "every value was loaded before"
    values: dict[str, Any] = {key: value for key, value in source.value.items() if key not in without}
    writer: Any = YAML()
    writer.default_flow_style = None
    writer.width = WIDTH
    text = io.StringIO()
    writer.dump(values, text)
    return f"# {comment}\n{text.getvalue()}"
