"""Section: the metrics that no other section shows."""

from __future__ import annotations

from rvjax.report.blocks import Section
from rvjax.report.metric_tables import quantiles
from rvjax.report.run_view import Run
from rvjax.report.sections import safety

_ELSEWHERE = (
    r"captured|.*settling_time_s|fault_recovery_s|(final|window)_.*error.*|saturation_duty\..*|longest_saturated_s\..*"
    r"|saturation_depth\..*|peak_chi|peak_estimate_drift"
)


def section(run: Run) -> Section | None:
    """Quantiles of effort, approach and all further metrics of the campaign."""
    elsewhere = set(run.metrics(_ELSEWHERE)) | {*safety.shown(run)}
    names = [name for name in run.metrics(".*") if name not in elsewhere]
    title = "Effort, approach and other metrics"
    if not names:
        return None
    lead = "Propulsive effort, approach, and every metric that no section above shows."
    return Section("others", title, lead, (quantiles(run, "Other metrics.", names),))
