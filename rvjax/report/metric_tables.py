"""Tables that several sections show: quantiles of metrics with their intervals, shares of samples, definitions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from rvjax.columns import metric_and_channel
from rvjax.report.blocks import Cell, Named, Table
from rvjax.report.number_format import capital, channel, count, label, percent
from rvjax.report.run_view import CONFIDENCE, Run

LEVELS = (0.5, 0.9, 0.95, 0.99)
"""Shares of samples that are no worse than the quantile shown."""


def quantiles(run: Run, caption: str, names: Iterable[str]) -> Table:
    """One row per metric: the values that 50, 90, 95 and 99 % of the samples are no worse than, with intervals.

    Where all are the same metric per channel, the row's name is the channel and the caption says which metric it is.
    """
    head = ("metric", *(f"{percent(level)} of samples" if level > 0.5 else "median" for level in LEVELS))
    names = list(names)
    stems = {metric_and_channel(name)[0] for name in names}
    named = _channel if len(stems) == 1 and not stems & set(names) else _named
    return Table(f"{caption} {_reading(run)}", head, tuple((named(run, name), *_levels(run, name)) for name in names))


def shares(run: Run, caption: str, events: Mapping[str, tuple[str, int]]) -> Table:
    """One row per event (name → words, number of samples): how many samples, and their share with its interval."""
    text = caption + run.basis.words(f" Clopper–Pearson intervals at {percent(CONFIDENCE)} confidence.")
    rows = tuple((words, count(holds), run.share(name, holds)) for name, (words, holds) in events.items())
    return Table(text, ("event", "samples", "share of all samples"), rows)


def _levels(run: Run, name: str) -> Iterable[Cell]:
    higher = run.column(name).better == "higher"
    return (run.quantile(name, round(1 - level, 6) if higher else level) for level in LEVELS)


def _channel(_: Run, name: str) -> Cell:
    return capital(channel(metric_and_channel(name)[1]))


def _named(run: Run, name: str) -> Cell:
    return Named(label(name), run.column(name).description)


def _reading(run: Run) -> str:
    below = run.basis.words(f"; below it, its {percent(CONFIDENCE)} confidence interval ({_method(run)}, n = {count(run.flown)})")
    return f"So many samples are no worse than the value{below}. A sample that ended not finite counts as ∞."


def _method(run: Run) -> str:
    exact = all(run.metric(name).exact for name in run.metrics(".*"))
    return "order statistics" if exact else "order statistics read from a sketch, see provenance"
