"""The program `rvjax`: every command is a thin wrapper over a function of the package."""

from __future__ import annotations

from rvjax.cli import about, comparing, flying, measuring, tuning
from rvjax.cli.app import main

__all__ = ["about", "comparing", "flying", "main", "measuring", "tuning"]
