"""The program `rvjax`: one file is one command, a thin wrapper over a function of the package."""

from __future__ import annotations

from rvjax.cli._app import COMMANDS, main

__all__ = ["COMMANDS", "main"]
