"""Section: every metric that no other section shows, so that none is hidden."""

from __future__ import annotations

from rvjax.report.blocks import Section
from rvjax.report.metric_tables import quantiles
from rvjax.report.run_view import Run

_ELSEWHERE = (
    r"captured|.*settling_time_s|fault_recovery_s|(final|window)_.*error.*|saturation_duty\..*|longest_saturated_s\..*"
    r"|saturation_depth\..*|peak_chi|peak_estimate_drift"
)


def section(run: Run) -> Section:
    """Quantiles of effort, approach and whatever further metrics the campaign has."""
    elsewhere = set(run.metrics(_ELSEWHERE))
    names = [name for name in run.metrics(".*") if name not in elsewhere]
    title = "Effort, approach and other metrics"
    if not names:
        return Section("others", title, "All metrics are shown in the other sections.")
    lead = "What the flights cost, how they approached, and every metric not shown above."
    return Section("others", title, lead, (quantiles(run, "Other metrics.", names),))
