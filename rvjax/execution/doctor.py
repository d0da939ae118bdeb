"""The state of this installation: versions, devices, settings, and what is wrong with them."""

from __future__ import annotations

import os
import sys
import warnings
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import rvjax
from rvjax.cores import cores
from rvjax.errors import FolderError
from rvjax.places import Place
from rvjax.run_folder import RunFolder
from rvjax.simulation import jax_config
from rvjax.simulation.engines.llvm.machine_code import host

PACKAGES = (
    "jax",
    "jaxlib",
    "llvmlite",
    "numpy",
    "scipy",
    "pandas",
    "pyarrow",
    "matplotlib",
    "pydantic",
    "ruamel.yaml",
    "typer",
    "rich",
)


@dataclass(frozen=True)
class Health:
    """facts: name → value. complaints: what is wrong and what to do. exit_code: 0, 2, or 5 where a run folder is damaged."""

    facts: dict[str, Any]
    complaints: list[str]
    exit_code: int


def examine(folder: Place | None = None) -> Health:
    """Versions, devices and settings; with a run folder also whether each of its files is intact.

    A damaged manifest or journal is rebuilt from the data files."""
    complaints: list[str] = []
    facts: dict[str, Any] = {"rvjax": rvjax.__version__, "python": sys.version.split()[0], "cores": cores()}
    for name in PACKAGES:
        try:
            facts[name] = version(name)
        except PackageNotFoundError:
            complaints.append(f"{name} is not installed; install rvjax with pip, which installs it")
    with warnings.catch_warnings(record=True) as refused:
        warnings.simplefilter("always", jax_config.SettingsWarning)
        jax_config.configure()
    complaints += [str(warning.message) for warning in refused if issubclass(warning.category, jax_config.SettingsWarning)]
    facts |= jax_config.settings()
    facts["engine llvm"], reason = _llvm()
    complaints += [reason] if reason else []
    facts["devices"] = jax_config.devices()
    facts["terminal"] = "yes" if sys.stdout.isatty() else "no"
    if not os.access(Path.cwd(), os.W_OK):
        complaints.append(f"{Path.cwd()} cannot be written; use --out with a folder that can")
    damaged = False
    if folder is not None:
        try:
            opened = _open(folder, facts)
            opened.verify()
            facts["run folder"] = f"{folder}: every file is intact, {vars(opened.account())}"
            facts["audit"] = str(opened.audit or "no record in this folder")
        except FolderError as error:
            damaged = True
            complaints += str(error).splitlines()
    return Health(facts, complaints, 5 if damaged else 2 if complaints else 0)


def _llvm() -> tuple[str, str]:
    """(whether the engine `llvm` can fly here, what is wrong with it)."""
    if jax_config.settings()["device"] != "cpu":
        return "no, the device is no CPU", ""
    try:
        target = host()
    except (ImportError, OSError, RuntimeError) as error:
        return "no", f"llvmlite cannot be used ({error}); install it with pip"
    return f"yes, {target.lanes} float64 numbers in a vector register ({target.cpu})", ""


def _open(folder: Place, facts: dict[str, Any]) -> RunFolder:
    """The run folder; a damaged manifest is rebuilt."""
    if not RunFolder.begun(folder):
        return RunFolder.open(folder)  # raises: not a run folder
    try:
        return RunFolder.open(folder)
    except FolderError as error:
        with RunFolder.rebuild(folder) as rebuilt:
            count = len(rebuilt.chunks)
            chunks = "1 intact chunk" if count == 1 else f"{count} intact chunks"
            facts["manifest"] = f"{str(error).rpartition('; ')[0]}; rebuilt from {chunks}; the old manifest is in quarantine/"
        return RunFolder.open(folder)
