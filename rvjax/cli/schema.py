"""`rvjax schema`: the JSON Schema of a campaign file."""

from __future__ import annotations

from rvjax.cli._app import Json
from rvjax.cli._output import Output


def command(as_json: Json = False) -> int:
    """Print the JSON Schema of a campaign file."""
    from rvjax.components.manual import campaign_schema

    del as_json  # the output is JSON in any case
    Output(as_json=True).document(campaign_schema())
    return 0
