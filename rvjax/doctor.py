"""What this machine flies with, and what is wrong with it."""

from __future__ import annotations

import os
import sys
import warnings
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import rvjax
from rvjax import process
from rvjax.errors import FolderError
from rvjax.results import RunFolder

PACKAGES = ("jax", "jaxlib", "numpy", "scipy", "pandas", "pyarrow", "matplotlib", "pydantic", "ruamel.yaml", "typer", "rich")


@dataclass(frozen=True)
class Health:
    """facts: name → value. complaints: what is wrong and what to do. exit_code: 0, 2, or 5 where a run folder is damaged."""

    facts: dict[str, Any]
    complaints: list[str]
    exit_code: int


def examine(folder: Path | None = None) -> Health:
    """Versions, devices and settings; with a run folder, also whether each of its files is what was written."""
    complaints: list[str] = []
    facts: dict[str, Any] = {"rvjax": rvjax.__version__, "python": sys.version.split()[0], "cores": process.cores()}
    for name in PACKAGES:
        try:
            facts[name] = version(name)
        except PackageNotFoundError:
            complaints.append(f"{name} is not installed; install rvjax with pip, which brings it")
    with warnings.catch_warnings(record=True) as refused:
        warnings.simplefilter("always", process.SettingsWarning)
        process.configure()
    complaints += [str(warning.message) for warning in refused if issubclass(warning.category, process.SettingsWarning)]
    facts |= process.settings()
    facts["devices"] = process.devices()
    facts["terminal"] = "yes" if sys.stdout.isatty() else "no"
    if not os.access(Path.cwd(), os.W_OK):
        complaints.append(f"{Path.cwd()} cannot be written; runs need --out with a folder that can")
    damaged = False
    if folder is not None:
        try:
            opened = RunFolder.open(folder)
            opened.verify()
            facts["run folder"] = f"{folder}: every file is intact, {vars(opened.account())}"
        except FolderError as error:
            damaged = True
            complaints += str(error).splitlines()
    return Health(facts, complaints, 5 if damaged else 2 if complaints else 0)
