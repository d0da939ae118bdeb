"""`rvjax list`: the components."""

from __future__ import annotations

from rvjax.cli._app import Json
from rvjax.cli._output import Output


def command(as_json: Json = False) -> int:
    """List the components and the module of each."""
    from rvjax.components import manual

    output = Output(as_json)
    rows = [(family, name, origin, manual.page(family, name).summary) for family, name, origin in manual.components()]
    for family in dict.fromkeys(row[0] for row in rows):
        table = [(name, f"{summary}\n{origin}") for row_family, name, origin, summary in rows if row_family == family]
        output.table((family, "description and module"), table)
    output.document({"components": [dict(zip(("family", "name", "from", "summary"), row, strict=True)) for row in rows]})
    return 0
