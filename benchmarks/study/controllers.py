"""The controllers of the study, from `controllers.yaml` beside this file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from ruamel.yaml import YAML

CAMPAIGN = Path(__file__).parents[2] / "campaigns" / "study" / "docking.yaml"
CONTROLLERS = Path(__file__).with_name("controllers.yaml")


class Entry(NamedTuple):
    """name: in tables and folders. controller: its section. parameters: the searched range of each gain, as in `tune`. tied:
    gains that follow another by a factor.
    """

    name: str
    controller: Mapping[str, Any]
    parameters: Mapping[str, Any]
    tied: Mapping[str, Any]

    def searched(self) -> dict[str, Any]:
        """The section `tune.parameters`."""
        ranges = {f"controller.gains.{gain}": span for gain, span in self.parameters.items()}
        tied = {
            f"controller.gains.{gain}": {"product": [f"controller.gains.{other}", factor]}
            for gain, (other, factor) in self.tied.items()
        }
        return ranges | tied

    def named(self, gains: Mapping[str, float]) -> dict[str, Any]:
        """The controller with these gains, under its name."""
        return {**self.controller, "name": self.name, "gains": {**self.controller.get("gains", {}), **gains}}


def entries(path: Path = CONTROLLERS) -> list[Entry]:
    """Of the study, in the order of the file."""
    table = YAML(typ="safe").load(path.read_text(encoding="utf-8"))
    return [Entry(name, row["controller"], row["parameters"], row.get("tied", {})) for name, row in table.items()]
