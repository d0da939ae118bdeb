"""Plots that the sections share: the style, empirical distribution functions with their band, bands over time.

Figures use `matplotlib.figure.Figure` directly, without pyplot. Mathematical markup is off, so that names from a campaign
file are drawn literally.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.layout_engine import TightLayoutEngine
from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, NullFormatter, NullLocator
from numpy.typing import ArrayLike, NDArray

from rvjax.report.number_format import power_of_ten
from rvjax.stats import Estimate
from rvjax.stats.quantile_sketch import Sketch
from rvjax.stats.sampling_design import Observed

# The palette of Okabe & Ito, which readers with any colour vision can distinguish.
BLUE, ORANGE, GREEN, RED, SKY, PURPLE = "#0072B2", "#E69F00", "#009E73", "#D55E00", "#56B4E9", "#CC79A7"
SERIES = (BLUE, RED, GREEN, PURPLE, SKY, ORANGE)
INK, MUTED, GRID = "#1f2933", "#66727f", "#e3e7eb"
OUTCOME_COLOURS = {"captured": BLUE, "not_settled": ORANGE, "collided": RED, "not_finite": PURPLE, "missing": MUTED}

STYLE: Any = {
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.titleweight": "bold",
    "axes.labelsize": 9.0,
    "axes.edgecolor": MUTED,
    "axes.labelcolor": INK,
    "axes.titlecolor": INK,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.unicode_minus": True,
    "grid.color": GRID,
    "grid.linewidth": 0.7,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "text.color": INK,
    "text.parse_math": False,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "lines.linewidth": 1.6,
    "figure.dpi": 72,
    "svg.fonttype": "path",
}
WIDTH = 9.2
"""The width of every figure in inches."""

_LEGEND = 0.3
"""The height of a legend above all axes, in inches."""

_STEPS = 200  # points of a drawn distribution function

_BEYOND = 2.0**40
"""About 10¹². Only diverging flights have larger values, which would dominate the axis, so they are drawn as infinite. This is a
bucket edge of the sketch."""


def shared_legend(figure: Figure, entries: Mapping[str, Any], columns: int) -> None:
    """A legend above all axes. entries: what is drawn, by label."""
    figure.legend(
        entries.values(), entries.keys(), loc="upper center", bbox_to_anchor=(0.5, 1.0), borderaxespad=0.2, ncols=columns
    )


def labelled(axis: Axes) -> dict[str, Any]:
    """What the axes draw, by label."""
    handles, labels = axis.get_legend_handles_labels()
    return dict(zip(labels, handles, strict=True))


def legend(axis: Axes, **options: Any) -> None:
    """A legend where it hides least; none where nothing is drawn that has a label."""
    if axis.get_legend_handles_labels()[1]:
        axis.legend(loc="best", **options)


def axes(rows: int, columns: int, height: float, legend_above: bool = False, **subplots: Any) -> tuple[Figure, list[Axes]]:
    """A figure with rows × columns axes, in reading order, placed by measuring their labels. height: in inches. legend_above:
    leave room for `shared_legend`."""
    top = 1.0 - (_LEGEND / height if legend_above else 0.0)
    figure = Figure(figsize=(WIDTH, height), layout=TightLayoutEngine(pad=0.3, h_pad=0.8, w_pad=0.8, rect=(0.0, 0.0, 1.0, top)))
    grid = figure.subplots(rows, columns, squeeze=False, **subplots)
    return figure, [axis for row in grid for axis in row]


def panels(
    rows: int,
    columns: int,
    height: float,
    *,
    legend_above: bool = True,
    sharex: bool = False,
    sharey: Literal[False, "row"] = False,
) -> tuple[Figure, list[Axes]]:
    """As `axes`, for panels with titles and numbers along their axes: their margins are fixed, since measuring labels takes half
    of the time of a figure."""
    figure = Figure(figsize=(WIDTH, height))
    left, right, bottom, above = 0.78, 0.1, 0.46, 0.28 + (_LEGEND if legend_above else 0.0)
    beside, below = 0.2 if sharey else 0.78, 0.38 if sharex else 0.76
    wide, high = (WIDTH - left - right - (columns - 1) * beside) / columns, (height - bottom - above - (rows - 1) * below) / rows
    edges = {"left": left / WIDTH, "right": 1.0 - right / WIDTH, "bottom": bottom / height, "top": 1.0 - above / height}
    spaces = {"wspace": beside / wide, "hspace": below / high}
    grid = figure.subplots(rows, columns, squeeze=False, sharex=sharex, sharey=sharey, gridspec_kw=edges | spaces)
    return figure, [axis for row in grid for axis in row]


def distribution(axis: Axes, values: Sketch, colour: str, label: str, half: float | None) -> None:
    """P(X ≤ x) as a step line, with a band of half-width `half` if given. Infinite values keep the line below 1."""
    finite = values.n - values.at_least(_BEYOND)
    if not finite:
        axis.plot([], [], color=colour, label=f"{label}: no finite value")
        return
    kept = _thinned(finite)
    x, share = [values.value(int(rank)) for rank in kept], (kept + 1) / values.n
    left, right = np.repeat(x, 2), np.concatenate([[0.0], np.repeat(share, 2)[:-1]])
    axis.plot(left, right, color=colour, label=label)
    if half is not None:
        axis.fill_between(left, np.clip(right - half, 0, 1), np.clip(right + half, 0, 1), color=colour, alpha=0.18, lw=0)
    if finite < values.n:
        axis.plot([x[-1]], [share[-1]], marker=">", color=colour, markersize=5, clip_on=False)


def probability_axis(axis: Axes) -> None:
    """Sets up the vertical axis of a distribution function, from 0 to 1."""
    axis.set_ylim(-0.02, 1.03)
    axis.yaxis.set_major_locator(FixedLocator([0, 0.25, 0.5, 0.75, 0.9, 1.0]))
    axis.set_ylabel("share of samples ≤ x")


def value_axis(axis: Axis, values: Iterable[Sketch], spread: float = 30.0) -> None:
    """Makes an axis logarithmic if all finite values are positive and their ratio exceeds `spread`."""
    reach = [ends for part in values if (ends := _finite_ends(part))]
    least, most = min((low for low, _ in reach), default=0.0), max((high for _, high in reach), default=0.0)
    if least > 0 and most > spread * least:
        logarithmic(axis, most / least)
    else:
        axis.set_major_formatter(FuncFormatter(_tick))


def _finite_ends(values: Sketch) -> tuple[float, float] | None:
    """The smallest and the largest finite value; None if there is none."""
    finite = values.n - values.at_least(_BEYOND)
    first = bisect_left(range(finite), True, key=lambda rank: values.value(rank) > -_BEYOND)
    return (values.value(first), values.value(finite - 1)) if first < finite else None


def logarithmic(axis: Axis, ratio: float) -> None:
    """Makes an axis logarithmic, labelled at decades; if the ratio of its ends is small, also at 3 times the decades."""
    axis._set_axes_scale("log")  # pyright: ignore[reportAttributeAccessIssue]
    axis.set_major_locator(LogLocator(subs=(1.0, 3.0) if ratio < 300 else (1.0,), numticks=9))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(_tick))
    axis.set_minor_formatter(NullFormatter())


def limit(axis: Axes, x: float, text: str, colour: str = INK) -> None:
    """A vertical dashed line with a text along it."""
    axis.axvline(x, color=colour, lw=1.0, ls=(0, (4, 3)))
    note = axis.annotate(
        text, (x, 0.03), xycoords=("data", "axes fraction"), xytext=(-3, 0), textcoords="offset points",
        rotation=90, annotation_clip=True, ha="right", va="bottom", fontsize=8, color=colour,
        bbox={"facecolor": "white", "alpha": 0.75, "linewidth": 0, "pad": 0.8},
    )  # fmt: skip
    note.set_in_layout(False)  # a note outside the axes is not drawn and takes no space


def bands(axis: Axes, t: NDArray[np.float64], values: NDArray[np.float64], lost: float, colour: str = BLUE) -> None:
    """Median, 5–95 % range and full range of values (samples, times) over t in seconds.

    NaN is the value of a flight that diverged. The quantiles use `lost` instead (+inf: the worst value; NaN: left out). The
    full range is that of the finite values.
    """
    finite = np.isfinite(values).any(axis=0)
    t, values = t[finite], values[:, finite]
    if not t.size:
        empty(axis, "no finite value")
        return
    least, most = np.nanmin(values, axis=0), np.nanmax(values, axis=0)
    filled = np.where(np.isnan(values), lost, values)
    low, middle, high = np.nanquantile(filled, (0.05, 0.5, 0.95), axis=0, method="inverted_cdf")
    axis.fill_between(t, least, most, color=colour, alpha=0.13, lw=0, label="full range")
    axis.fill_between(t, np.minimum(low, most), np.minimum(high, most), color=colour, alpha=0.28, lw=0, label="5–95 % range")
    axis.plot(t, np.where(np.isfinite(middle), middle, np.nan), color=colour, label="median")


def ends(number: Estimate | Observed) -> tuple[float, float]:
    """The ends of the interval of a number; without an interval, the number twice."""
    return (number.low, number.high) if isinstance(number, Estimate) else (number.value, number.value)


def intervals(axis: Axes, x: ArrayLike, estimates: Sequence[Estimate | Observed], colour: str, label: str, scale: float) -> None:
    """Estimates × scale over x as a line with error bars; infinite ends are not drawn."""
    y = scale * np.array([[estimate.value, *ends(estimate)] for estimate in estimates])
    y = np.where(np.isfinite(y), y, np.nan)
    axis.plot(x, y[:, 0], "o-", color=colour, ms=3.5, lw=1.2, label=label)
    axis.vlines(x, np.fmin(y[:, 1], y[:, 0]), np.fmax(y[:, 2], y[:, 0]), color=colour, lw=1.2)


def empty(axis: Axes, text: str) -> None:
    """Replaces axes without data by a text."""
    axis.set_axis_off()
    axis.text(0.5, 0.5, text, ha="center", va="center", color=MUTED, transform=axis.transAxes)


def _thinned(n: int) -> NDArray[np.int_]:
    """Up to about 200 of the indices 0 … n − 1, with both ends and dense tails."""
    if n <= _STEPS:
        return np.arange(n)
    edge = 25
    middle = np.linspace(edge, n - 1 - edge, _STEPS - 2 * edge).round().astype(int)
    return np.unique(np.concatenate([np.arange(edge), middle, np.arange(n - edge, n)]))


def _tick(value: float, _: object = None) -> str:
    """A tick label: 0.001, 200, 10⁻⁵."""
    if value and (abs(value) < 1e-3 or abs(value) >= 1e5):
        exponent = math.floor(math.log10(abs(value)) + 1e-9)
        lead = value / 10.0**exponent
        return power_of_ten(exponent) if abs(lead - 1) < 1e-6 else f"{lead:.3g}·{power_of_ten(exponent)}"
    return f"{value:.6g}".replace("-", "−")
