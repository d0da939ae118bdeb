"""Identity: everything that the bits of a run are a function of. Provenance: what else is worth knowing about the run."""

from __future__ import annotations

import hashlib
import json
import platform
import sys
from collections.abc import Collection, Mapping, Sequence
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

import rvjax
from rvjax.campaign.fixed_values import fixed_values
from rvjax.campaign.named_laws import LAWS
from rvjax.campaign.python_files import PythonFile
from rvjax.components import installed_code
from rvjax.components.registry import component, foreign
from rvjax.cores import cores
from rvjax.simulation.batch import LANES
from rvjax.simulation.draws import Draws
from rvjax.simulation.engines.choice import engine_of
from rvjax.simulation.problem import Problem

COMPUTING = ("numpy", "scipy")
"""Packages with which code that is not of this package may compute its constants. Draws and constants of this package are plain
arithmetic (`rvjax.elementary`), and NumPy's has the same bits in every version."""

COMPILING = ("jax", "jaxlib")
"""Packages whose version may change the last bits of flights with the engine `xla`. That of `llvm` hashes the whole program."""

FLYING = (
    *("campaign", "elementary", "physics", "simulation", "stats/random_streams.py"),
    "components/user_code.py",
    *(f"components/{family}" for family in ("actuators", "allocations", "controllers", "disturbances", "effects")),
    *(f"components/{family}" for family in ("faults", "forms", "guidance", "metrics", "navigation", "samplers", "saturations")),
)
"""Parts of this package that a flight depends on: their source is part of the identity. A test walks the imports of what flies
and finds nothing outside of them."""

PLAN = "plan"
"""Key of an identity: the sampler and the number of samples, where another number of samples is another plan."""


def identity(problem: Problem) -> dict[str, Any]:
    """Everything that decides the bits of a chunk, apart from its number. Needs a configured process; starts JAX and traces the
    flight."""
    engine = engine_of(problem)
    others = _foreign(problem)
    packages = {
        *(() if engine.name == "llvm" else COMPILING),
        *component("samplers", problem.spec.sampler.use).packages,
        *(COMPUTING if others else ()),
    }
    return {
        "campaign": problem.fingerprint,
        "seed": problem.spec.seed,
        "rvjax": rvjax.__version__,
        "code": source_digest(FLYING),
        "components": others,
        "packages": {name: version(name) for name in sorted(packages)},
        **({} if problem.dispersions.extends else {PLAN: {"use": problem.spec.sampler.use, "samples": problem.spec.samples}}),
        "lanes": LANES,
        **({LAWS: {name: law.laws() for name, law in problem.laws.items()}} if problem.laws else {}),
        **engine.identity(Draws.of(problem, np.arange(1, dtype=np.int64))[1]),
    }


def short(identity: Mapping[str, Any]) -> str:
    """Twelve characters of its SHA-256: the name of the run folder."""
    return hashlib.sha256(json.dumps(identity, sort_keys=True).encode()).hexdigest()[:12]


def provenance(command: Sequence[str], overrides: Sequence[str]) -> dict[str, Any]:
    """When, with which packages and by which command the run started; which values of the campaign file were replaced."""
    return {
        "started": datetime.now(UTC).isoformat(timespec="seconds"),
        "command": list(command),
        "overrides": list(overrides),
        "python": sys.version.split()[0],
        "system": f"{platform.system()} {platform.machine()}",
        "cores": cores(),
        "packages": packages(),
    }


def fixed(problem: Problem) -> dict[str, Any]:
    """The fixed values of the campaign with those of its components, for the report, which knows no component."""
    models = {part.place: part.parameters for part in problem.parts if part.parameters is not None}
    return {name: list(value) for name, value in fixed_values(problem.spec, models).items()}


def packages() -> dict[str, str]:
    """The versions of the packages that fly samples, write tables and draw figures."""
    return {name: version(name) for name in ("jax", "jaxlib", "matplotlib", "numpy", "pandas", "pyarrow", "scipy")}


def _foreign(problem: Problem) -> dict[str, Any]:
    """The code of every component that is not of this package: the digest of each file beside the campaign that is executed; of
    an installed package its version and the digest of its code."""
    code: dict[str, Any] = {}
    for part in foreign(problem.spec):
        code |= part.digests if isinstance(part, PythonFile) else {part: installed_code.identity(part)}
    return code


def source_digest(parts: Collection[str]) -> str:
    """SHA-256 of the source of folders and files of this package, given by their paths in it."""
    root = Path(rvjax.__file__).parent
    files = {path for part in parts for path in ((root / part).rglob("*.py") if (root / part).is_dir() else (root / part,))}
    digest = hashlib.sha256()
    for path in sorted(files):
        digest.update(path.relative_to(root).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:16]
