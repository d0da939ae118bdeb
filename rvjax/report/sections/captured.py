"""Section: how the samples ended."""

from __future__ import annotations

from rvjax.columns import OUTCOMES
from rvjax.report import plotting
from rvjax.report.blocks import Drawing, Section
from rvjax.report.metric_tables import shares
from rvjax.report.number_format import count, number, spoken
from rvjax.report.run_view import Run

_MEANING = {
    "captured": "captured: inside the position and attitude tubes over the whole closing window",
    "not_settled": "not settled: flown to the end, but outside a tube at some time in the closing window",
    "collided": "collided: the hulls touched, or contact could not be excluded between two steps",
    "not_finite": "not finite: the flight diverged until a value was no longer finite",
}


def section(run: Run) -> Section:
    """The share of every outcome with its interval, and the account of all requested samples."""
    account = run.account
    captured = run.share("captured", account.captured)
    counts = {
        "captured": account.captured,
        "not_settled": account.not_settled,
        "collided": account.collided,
        "not_finite": account.not_finite,
        "missing": account.missing,
    }
    table = shares(
        run,
        f"Outcomes of {count(run.flown)} flown samples.",
        {outcome: (_MEANING[outcome], counts[outcome]) for outcome in OUTCOMES},
    )
    total = " + ".join(f"{count(value)} {name.replace('_', ' ')}" for name, value in counts.items())
    accounting = (
        f"Account: {total} = {count(account.requested)} requested. "
        "Every flown sample counts in every number below, unless a caption names fewer."
    )
    lead = f"{spoken(captured)} of the flown samples are captured."
    return Section("captured", "Captured share and outcomes", lead, (_bar(counts), table, accounting, *_ends(run)))


def _bar(counts: dict[str, int]) -> Drawing:
    """One bar of all requested samples, divided by outcome."""
    figure, (axis,) = plotting.axes(1, 1, 1.15)
    left = 0
    for name, value in counts.items():
        if value:
            words = f"{name.replace('_', ' ')}: {count(value)}"
            axis.barh(0, value, left=left, color=plotting.OUTCOME_COLOURS[name], label=words, height=0.6)
            left += value
    axis.set_yticks([])
    axis.set_xlim(0, max(left, 1))
    axis.set_xlabel("samples")
    axis.spines["left"].set_visible(False)
    axis.grid(visible=False)
    axis.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=4, borderaxespad=0.2, handlelength=1.2)
    return Drawing("outcomes", "All requested samples by outcome.", figure)


def _ends(run: Run) -> tuple[str, ...]:
    """The times at which flights diverged."""
    lost = run.totals.lost
    if not lost.n:
        return ()
    earliest, latest = number(lost.value(0)), number(lost.value(lost.n - 1))
    return (f"The not finite flights diverged between {earliest} s and {latest} s.",)
