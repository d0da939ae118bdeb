"""rvjax: batched Monte-Carlo robustness analysis of spacecraft rendezvous. Everything that a command does, as a function.

    Campaign, Run      a campaign and a finished run as objects: fly, samples, verdicts, replay, compare
    configure          precision and compiler settings; call it before JAX is used
    load_campaign      the problem that a campaign file states
    fly_campaign       flies a campaign into a run folder, with its report
    export_run         writes tables and traces for other tools
    replay_sample      flies a sample again, with its full trace
    judge_folder       the verdict on each requirement, from a run folder
    build_report       the report, from a run folder
    compare_runs       two runs on the same draws, sample by sample
    tune_campaign      searches better gains and confirms them on fresh draws
    find_worst_case    searches the draws with the smallest margin of a requirement
    plan_samples       the number of samples that a requirement needs

Importing this package does nothing else: it neither imports JAX nor configures it.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from rvjax.analysis.compare import Comparison
    from rvjax.analysis.compare import compare as compare_runs
    from rvjax.analysis.sample_size import plan as plan_samples
    from rvjax.analysis.verdicts import Verdict, judge_folder
    from rvjax.errors import CampaignError, RvjaxError
    from rvjax.execution.exporting import export as export_run
    from rvjax.execution.replay import replay as replay_sample
    from rvjax.execution.run import run as fly_campaign
    from rvjax.notebook import Campaign, Run
    from rvjax.report import build as build_report
    from rvjax.run_folder import RunFolder
    from rvjax.search.tuning.tune import tune as tune_campaign
    from rvjax.search.worst_case import find_worst_case
    from rvjax.simulation.jax_config import configure
    from rvjax.simulation.problem import load as load_campaign

__all__ = [
    "Campaign",
    "CampaignError",
    "Comparison",
    "Run",
    "RunFolder",
    "RvjaxError",
    "Verdict",
    "__version__",
    "build_report",
    "compare_runs",
    "configure",
    "export_run",
    "find_worst_case",
    "fly_campaign",
    "judge_folder",
    "load_campaign",
    "plan_samples",
    "replay_sample",
    "tune_campaign",
]

_ORIGIN = {
    "Campaign": "notebook:Campaign",
    "Run": "notebook:Run",
    "CampaignError": "errors:CampaignError",
    "Comparison": "analysis.compare:Comparison",
    "RunFolder": "run_folder:RunFolder",
    "RvjaxError": "errors:RvjaxError",
    "Verdict": "analysis.verdicts:Verdict",
    "build_report": "report:build",
    "compare_runs": "analysis.compare:compare",
    "configure": "simulation.jax_config:configure",
    "export_run": "execution.exporting:export",
    "find_worst_case": "search.worst_case:find_worst_case",
    "fly_campaign": "execution.run:run",
    "judge_folder": "analysis.verdicts:judge_folder",
    "load_campaign": "simulation.problem:load",
    "plan_samples": "analysis.sample_size:plan",
    "replay_sample": "execution.replay:replay",
    "tune_campaign": "search.tuning.tune:tune",
}
"""Public name → module and attribute."""


def __getattr__(name: str) -> Any:
    """Public names are imported on first use."""
    if name not in _ORIGIN:
        raise AttributeError(f"module 'rvjax' has no attribute {name!r}")
    module, _, attribute = _ORIGIN[name].partition(":")
    return getattr(import_module(f"rvjax.{module}"), attribute)


def __dir__() -> list[str]:
    return __all__
