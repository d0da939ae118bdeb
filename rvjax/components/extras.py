"""Packages that only an extra of rvjax installs, such as `rvjax[tune]`."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, requires, version
from importlib.util import find_spec

from packaging.requirements import Requirement

MODULES = {"rerun-sdk": "rerun"}
"""The module of a package, where it has another name."""


def lacking(*packages: str) -> str:
    """Those of the packages that are missing here or too old, such as `optuna>=5.0 (4.2 is installed)`; empty if none is."""
    return ", ".join(found for package in packages if (found := _lack(package)))


def _lack(package: str) -> str:
    bounds = {needed.name: needed.specifier for needed in map(Requirement, requires("rvjax") or ())}
    try:
        installed = version(package) if find_spec(MODULES.get(package, package)) is not None else None
    except PackageNotFoundError:
        installed = None
    if installed is None:
        return f"{package}{bounds.get(package, '')} (not installed)"
    if package in bounds and not bounds[package].contains(installed, prereleases=True):
        return f"{package}{bounds[package]} ({installed} is installed)"
    return ""
