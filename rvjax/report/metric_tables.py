"""Tables that several sections share: quantiles of metrics and shares of samples, with confidence intervals."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from rvjax.columns import metric_and_channel
from rvjax.report.blocks import Cell, Named, Table
from rvjax.report.number_format import capital, channel, count, label, percent
from rvjax.report.run_view import CONFIDENCE, Run

LEVELS = (0.5, 0.9, 0.95, 0.99)
"""The shares of samples that are no worse than the quantiles shown."""


def quantiles(run: Run, caption: str, names: Iterable[str]) -> Table:
    """One row per metric: the values that 50, 90, 95 and 99 % of the samples are no worse than, with intervals.

    If all names are channels of the same metric, the rows are named after the channels, and the caption names the metric.
    """
    head = ("metric", *(f"{percent(level)} of samples" if level > 0.5 else "median" for level in LEVELS))
    names = list(names)
    stems = {metric_and_channel(name)[0] for name in names}
    row_name = _channel if len(stems) == 1 and not stems & set(names) else _named
    return Table(f"{caption} {_reading(run)}", head, tuple((row_name(run, name), *_levels(run, name)) for name in names))


def shares(run: Run, caption: str, events: Mapping[str, tuple[str, int]]) -> Table:
    """One row per event (name → words, number of samples): the number of samples, and their share with its interval."""
    text = caption + run.design.words(f" Clopper–Pearson intervals at {percent(CONFIDENCE)} confidence.")
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
    interval = run.design.words(f"; the interval has {percent(CONFIDENCE)} confidence ({_method(run)}, n = {count(run.flown)})")
    return f"The stated share of samples is no worse than the value{interval}. {run.lost} counts as the worst value."


def _method(run: Run) -> str:
    exact = all(run.metric(name).exact for name in run.metrics(".*"))
    return "order statistics" if exact else "order statistics read from a sketch, see provenance"
