"""`rvjax schema`: the JSON Schema of a campaign file."""

from __future__ import annotations

import json

from rvjax.cli._app import Json


def command(as_json: Json = False) -> int:
    """Print the JSON Schema of a campaign file."""
    from rvjax.components.manual import campaign_schema

    del as_json  # the output is JSON in any case
    print(json.dumps(campaign_schema(), indent=2, ensure_ascii=False))
    return 0
