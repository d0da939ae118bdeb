"""`rvjax list`: the components."""

from __future__ import annotations

from rvjax.cli._app import Json
from rvjax.cli._output import Output


def command(as_json: Json = False) -> int:
    """List the components and the module of each."""
    from rvjax.components import manual
    from rvjax.components.registry import FAMILIES, broken

    output = Output(as_json)
    rows = [(family, name, origin, manual.page(family, name).summary) for family, name, origin in manual.components()]
    for family in dict.fromkeys(row[0] for row in rows):
        table = [(name, f"{summary}\n{origin}") for row_family, name, origin, summary in rows if row_family == family]
        output.table((family, "description and module"), table)
    wrong = {f"{family}.{name}": message for family in FAMILIES for name, message in broken(family).items()}
    for name, message in wrong.items():
        output.note(f"{name} cannot be used: {message}")
    listed = [dict(zip(("family", "name", "from", "summary"), row, strict=True)) for row in rows]
    output.document({"components": listed, "broken": wrong})
    return 0
