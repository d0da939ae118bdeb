"""What the bits of a run are a function of (identity), and what else is worth knowing about it (provenance)."""

from __future__ import annotations

import hashlib
import inspect
import json
import platform
import sys
from collections.abc import Callable, Collection, Mapping, Sequence
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

import rvjax
from rvjax.components.registry import FAMILY_OF, members, module_of
from rvjax.cores import cores
from rvjax.simulation import jax_config
from rvjax.simulation.batch import LANES
from rvjax.simulation.problem import Problem

DECIDING = ("jax", "jaxlib", "numpy", "scipy")
"""Packages whose version may change the last bits."""

NOT_FLYING = ("analysis", "cli", "execution", "report", "run_folder", "search", "pytest_plugin.py")
"""Parts of this package that no number of a flight depends on."""


PLAN = "plan"
"""Of an identity: the sampler and the number of samples, where another number is another plan."""


def identity(problem: Problem) -> dict[str, Any]:
    """Everything that decides the bits of a chunk, apart from its number. Needs a configured process; starts JAX."""
    return {
        "campaign": problem.fingerprint,
        "seed": problem.spec.seed,
        "rvjax": rvjax.__version__,
        "code": _code(),
        "components": _foreign(problem),
        "packages": {name: version(name) for name in DECIDING},
        **({} if problem.dispersions.extends else {PLAN: {"use": problem.spec.sampler.use, "samples": problem.spec.samples}}),
        "lanes": LANES,
        **jax_config.settings(),
    }


def short(identity: Mapping[str, Any]) -> str:
    """Twelve characters that tell one identity from another: the name of a run's folder."""
    return hashlib.sha256(json.dumps(identity, sort_keys=True).encode()).hexdigest()[:12]


def provenance(command: Sequence[str], overrides: Sequence[str]) -> dict[str, Any]:
    """When, with what and by which command; which values of the campaign file were replaced."""
    return {
        "started": datetime.now(UTC).isoformat(timespec="seconds"),
        "command": list(command),
        "overrides": list(overrides),
        "python": sys.version.split()[0],
        "system": f"{platform.system()} {platform.machine()}",
        "cores": cores(),
        "packages": packages(),
    }


def packages() -> dict[str, str]:
    """The versions of the packages that fly, tabulate and draw."""
    return {name: version(name) for name in ("jax", "jaxlib", "matplotlib", "numpy", "pandas", "pyarrow", "scipy")}


def _foreign(problem: Problem) -> dict[str, str]:
    """SHA-256 over the module of every component that another package brings."""
    found: dict[str, str] = {}
    for choice in problem.spec.components:
        family = FAMILY_OF.get(str(choice.path[0]), "")
        if not family:
            continue
        origin = members(family)[choice.use]
        if not origin.startswith("rvjax."):
            source = inspect.getsource(module_of(family, choice.use))
            found[origin] = hashlib.sha256(source.encode()).hexdigest()[:16]
    return found


def _code() -> str:
    """SHA-256 over the source of everything that flies."""
    return _source(lambda name: name not in NOT_FLYING)


def source_digest(parts: Collection[str]) -> str:
    """SHA-256 over the source of some parts of this package."""
    return _source(lambda name: name in parts)


def _source(chosen: Callable[[str], bool]) -> str:
    root = Path(rvjax.__file__).parent
    digest = hashlib.sha256()
    for path in sorted(root.rglob("*.py")):
        name = path.relative_to(root)
        if chosen(name.parts[0]):
            digest.update(str(name).encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:16]
