"""rvjax: batched Monte-Carlo robustness analysis of spacecraft rendezvous. What the commands do, as functions.

Importing this package does nothing else: it neither imports JAX nor configures it.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from rvjax.analysis.verdicts import judge_folder
    from rvjax.execution.replay import replay as replay_sample
    from rvjax.execution.run import run as fly_campaign
    from rvjax.report import build as build_report
    from rvjax.simulation.jax_config import configure
    from rvjax.simulation.problem import load as load_campaign

__all__ = ["__version__", "build_report", "configure", "fly_campaign", "judge_folder", "load_campaign", "replay_sample"]

_HOME = {
    "build_report": ("rvjax.report", "build"),
    "configure": ("rvjax.simulation.jax_config", "configure"),
    "fly_campaign": ("rvjax.execution.run", "run"),
    "judge_folder": ("rvjax.analysis.verdicts", "judge_folder"),
    "load_campaign": ("rvjax.simulation.problem", "load"),
    "replay_sample": ("rvjax.execution.replay", "replay"),
}


def __getattr__(name: str) -> Any:
    """Public names are imported on first use."""
    if name not in _HOME:
        raise AttributeError(f"module 'rvjax' has no attribute {name!r}")
    module, attribute = _HOME[name]
    return getattr(import_module(module), attribute)
