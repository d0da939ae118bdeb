"""`rvjax init`: a starter campaign, and files for your components."""

from __future__ import annotations

from pathlib import Path
from textwrap import indent
from typing import Annotated

import typer

from rvjax.cli._app import Json
from rvjax.cli._output import Output


def _file(what: str) -> typer.models.OptionInfo:
    return typer.Option(metavar="FILE", help=f"Also write FILE.py with {what} of yours, which the campaign flies.")


def command(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder to write to; default: this one.")] = Path(),
    *,
    controller: Annotated[Path | None, _file("a controller")] = None,
    discrete_controller: Annotated[Path | None, _file("a discrete-time controller")] = None,
    actuator: Annotated[Path | None, _file("an actuator")] = None,
    allocation: Annotated[Path | None, _file("an allocation of thrusters")] = None,
    effect: Annotated[Path | None, _file("an effect")] = None,
    fault: Annotated[Path | None, _file("a fault")] = None,
    disturbance: Annotated[Path | None, _file("a disturbance")] = None,
    navigation: Annotated[Path | None, _file("a navigation error")] = None,
    guidance: Annotated[Path | None, _file("a guidance")] = None,
    metric: Annotated[Path | None, _file("a metric")] = None,
    as_json: Json = False,
) -> int:
    """Write a starter campaign, and files for your components."""
    from rvjax.cli._starter import write
    from rvjax.errors import UsageError

    if controller and discrete_controller:
        raise UsageError("--controller and --discrete-controller; accepted: one of them, a campaign flies a single controller")
    given = {
        "controller": controller,
        "discrete-controller": discrete_controller,
        "actuator": actuator,
        "allocation": allocation,
        "effect": effect,
        "fault": fault,
        "disturbance": disturbance,
        "navigation": navigation,
        "guidance": guidance,
        "metric": metric,
    }
    output = Output(as_json)
    components = {option: file for option, file in given.items() if file is not None}
    written, wanted = write(folder, components)
    output.text(*map(str, written))
    for entry in wanted:
        output.note(f"add to {folder / 'campaign.yaml'}\n{indent(entry, '  ')}")
    for option, file in components.items():
        output.note(f"check the {option.replace('-', ' ')} with\n  rvjax check-component {folder / file}")
    output.note(f"fly it with\n  rvjax run {folder / 'campaign.yaml'}")
    output.document({"written": [*map(str, written)], "add": wanted, "campaign": str(folder / "campaign.yaml")})
    return 0
