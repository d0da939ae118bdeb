"""Section: the share of failures over each epistemic draw, a number that is not known but not random."""

from __future__ import annotations

import math

import numpy as np

from rvjax.analysis import drivers
from rvjax.columns import EPISTEMIC, draw_column
from rvjax.report import plotting
from rvjax.report.blocks import Code, Drawing, Number, Section, Table
from rvjax.report.number_format import count, percent, prefixed
from rvjax.report.run_view import CONFIDENCE, Run
from rvjax.stats import Estimate
from rvjax.stats.reweighting import Class
from rvjax.stats.sampling_design import Exploration

_CLASSES = 10
_COLUMNS = 2
_SHOWN = 6


def section(run: Run) -> Section | None:
    """P(not captured | class of the draw) as a curve, with bars that hold for all classes of all curves together."""
    columns = run.totals.columns
    drawn = drivers.varied(run.head) if len(run.head) >= drivers.FEWEST else {}
    names = [name for name in drawn if draw_column(name) in columns and columns[draw_column(name)].kind == EPISTEMIC]
    if not names or isinstance(run.design, Exploration):
        return None
    (failing,) = drivers.failures(run.head, ())
    each = 1.0 - (1.0 - CONFIDENCE) / len(names)
    curves = {name: drivers.failing_classes(drawn[name], failing.values, run.design, each, _CLASSES) for name in names}
    leading = sorted(names, key=lambda name: (-_range(curves[name]), name))[:_SHOWN]
    widest = curves[leading[0]]
    same = "The share of flights that are not captured is the same in all classes of every epistemic draw."
    changes = (
        f"The share of flights that are not captured changes most over {leading[0]}: from {percent(_least(widest).value)} in one "
        f"tenth of the samples to {percent(_most(widest).value)} in another."
    )
    lead = changes if _range(widest) > 0.0 else same
    shown = f"The {_SHOWN} of {count(len(names))} epistemic draws over which it changes most. " if len(names) > _SHOWN else ""
    caption = (
        f"{shown}Classes of equal size; intervals at {percent(CONFIDENCE)} confidence for all classes of all epistemic draws "
        f"together (Clopper-Pearson).{run.head_note}"
    )
    rows = tuple(
        (
            Code(name),
            count(len(curves[name])),
            Number(f"epistemic.{name}.least", _together(_least(curves[name])), percent=True),
            Number(f"epistemic.{name}.most", _together(_most(curves[name])), percent=True),
        )
        for name in leading
    )
    table = Table(caption, ("draw", "classes", "fewest not captured", "most not captured"), rows)
    return Section("epistemic", "Failures over what is not known", lead, (_figure(run, curves, leading), table))


def _least(curve: list[Class]) -> Estimate:
    return min((part.share for part in curve), key=lambda share: share.value)


def _most(curve: list[Class]) -> Estimate:
    return max((part.share for part in curve), key=lambda share: share.value)


def _range(curve: list[Class]) -> float:
    return _most(curve).value - _least(curve).value


def _together(share: Estimate) -> Estimate:
    """The estimate with the confidence of all classes together."""
    return Estimate(share.value, share.low, share.high, share.n, CONFIDENCE, "Clopper-Pearson, simultaneous")


def _figure(run: Run, curves: dict[str, list[Class]], names: list[str]) -> Drawing:
    """A panel for each draw: a bar over each class."""
    rows = math.ceil(len(names) / _COLUMNS)
    figure, panels = plotting.panels(rows, _COLUMNS, 2.1 * rows + 0.5, legend_above=False)
    for axis, name in zip(panels, names, strict=False):
        factor, unit = prefixed(math.inf, run.totals.columns[draw_column(name)].unit)
        middle = [factor * 0.5 * (part.low + part.high) for part in curves[name]]
        plotting.intervals(axis, np.array(middle), [part.share for part in curves[name]], plotting.RED, name, 100.0)
        axis.set_ylim(0.0, None)
        axis.set_title(name, fontsize="small")
        axis.set_xlabel(unit if unit not in ("", "1") else "value")
        axis.set_ylabel("not captured [%]")
    for axis in panels[len(names) :]:
        axis.set_axis_off()
    text = f"Share of flights that are not captured, by class of each epistemic draw, with simultaneous intervals.{run.head_note}"
    return Drawing("epistemic", text, figure)
