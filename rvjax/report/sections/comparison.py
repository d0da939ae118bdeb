"""Section: the controller under test compared with the baseline controllers on the same draws."""

from __future__ import annotations

from matplotlib.axes import Axes

from rvjax.analysis.run_totals import Totals
from rvjax.columns import metric_column
from rvjax.report import plotting
from rvjax.report.blocks import Cell, Drawing, Number, Section, Table
from rvjax.report.number_format import count, label, percent, spoken
from rvjax.report.run_view import CONFIDENCE, Run

_QUANTILES = (
    ("settling_time_s", 0.95),
    ("attitude_settling_time_s", 0.95),
    ("window_position_error_m", 0.95),
    ("delta_v_m_s", 0.5),
    ("saturation_duty.any", 0.95),
)
_STYLES = ("-", (0, (4, 1.5)), (0, (1, 1)))


def section(run: Run) -> Section | None:
    """One row for each controller, with intervals; None if the campaign has no baselines."""
    if not run.baselines:
        return None
    controllers = {run.spec.controller.name: run.totals, **run.baselines}
    shares = {name: _captured(run, name, totals) for name, totals in controllers.items()}
    metrics = [(name, q) for name, q in _QUANTILES if all(name in totals.metrics for totals in controllers.values())]
    head = ("controller", "captured", *(f"{label(name)}, {percent(q) if q != 0.5 else 'median'}" for name, q in metrics))
    rows = tuple(
        (name, shares[name], *(_quantile(run, name, totals, *m) for m in metrics)) for name, totals in controllers.items()
    )
    ends = {"collided": "collided", "not_finite": "diverged (not finite)"}
    notes = [
        f"{name}: {count(number)} flights {words}."
        for name, totals in controllers.items()
        for outcome, words in ends.items()
        if (number := totals.counts.get(outcome, 0))
    ]
    intervals = (
        f" Captured: Clopper–Pearson; quantiles: order statistics; {percent(CONFIDENCE)} confidence each. Each interval is for "
        "one controller alone. Because the draws are common, differences between controllers are known more precisely than these "
        "intervals suggest."
    )
    caption = (
        f"Every controller on the same {count(run.flown)} draws of plant, disturbances and faults.{run.design.words(intervals)}"
    )
    body = (_figure(run, controllers, shares), Table(caption, head, rows), *notes)
    return Section("comparison", "Controllers on the same draws", _lead(run, shares), body)


def _lead(run: Run, shares: dict[str, Number]) -> str:
    best = max(shares, key=lambda name: shares[name].estimate.value)
    tested = run.spec.controller.name
    if shares[tested].estimate.value >= shares[best].estimate.value:
        return f"No baseline captures more samples than {tested}: {spoken(shares[tested])}."
    return f"{best} captures the most samples: {spoken(shares[best])}. {tested}: {spoken(shares[tested])}."


def _captured(run: Run, name: str, totals: Totals) -> Number:
    estimate = run.design.share(totals.counts.get("captured", 0), totals.n, CONFIDENCE)
    return Number(f"comparison.{name}.captured", estimate, percent=True)


def _quantile(run: Run, name: str, totals: Totals, metric: str, q: float) -> Cell:
    estimate = run.design.quantile(totals.metrics[metric], q, CONFIDENCE)
    unit = totals.columns[metric_column(metric)].unit
    return Number(f"comparison.{name}.{metric}.q{q * 100:g}", estimate, unit, percent=metric.startswith("saturation_duty"))


def _figure(run: Run, controllers: dict[str, Totals], shares: dict[str, Number]) -> Drawing:
    """Captured share of each controller, and the distribution functions of the settling times."""
    figure, (left, right) = plotting.axes(1, 2, 0.28 * len(controllers) + 2.2, width_ratios=(1, 1.4))
    for row, (name, totals) in enumerate(controllers.items()):
        colour = plotting.SERIES[row % len(plotting.SERIES)]
        estimate = shares[name].estimate
        low, high = plotting.ends(estimate)
        ends = [[100 * (estimate.value - low)], [100 * (high - estimate.value)]]
        face = "white" if row >= len(plotting.SERIES) else colour  # its curve is dashed
        left.errorbar([100 * estimate.value], [row], xerr=ends, fmt="o", ms=5, color=colour, mfc=face, capsize=2, lw=1.4)
        if "settling_time_s" in totals.metrics:
            _curve(run, right, totals, colour, name, _STYLES[row // len(plotting.SERIES) % len(_STYLES)])
    left.set_yticks(range(len(controllers)), list(controllers))
    left.set_ylim(len(controllers) - 0.5, -0.5)
    left.set_xlim(-3, 103)
    left.set_xlabel("captured, %")
    plotting.probability_axis(right)
    right.set_xlabel("settling time, s")
    right.set_xlim(0, run.spec.horizon.duration_s)
    interval = run.design.words(" with its confidence interval")
    text = f"Left: captured share{interval}. Right: share of samples whose position has settled (▸: the others never settle)."
    text += " Dashed curves belong to the hollow dots." if len(controllers) > len(plotting.SERIES) else ""
    return Drawing("comparison", text, figure)


def _curve(run: Run, axis: Axes, totals: Totals, colour: str, name: str, style: object) -> None:
    before = len(axis.lines)
    plotting.distribution(axis, totals.metrics["settling_time_s"], colour, name, run.design.band(totals.n, CONFIDENCE))
    for line in axis.lines[before:]:
        line.set_linestyle(style)  # pyright: ignore[reportArgumentType]
