"""Figures of a run as Matplotlib axes: those of the report, made by the same functions.

axis, = run.plot.settling()
axis.set_title("docking"); axis.figure.savefig("settling.pdf")
"""

from __future__ import annotations

import io
from collections.abc import Callable
from typing import Self

import matplotlib
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from rvjax.errors import UsageError
from rvjax.places import Place
from rvjax.report.blocks import Section
from rvjax.report.figures import PIXELS_PER_INCH
from rvjax.report.plotting import STYLE
from rvjax.report.run_view import Run, open_run
from rvjax.report.sections import (
    adaptation,
    captured,
    comparison,
    envelopes,
    evidence,
    safety,
    saturation,
    settling,
    trajectories,
    which_draws,
)

_MADE_BY: dict[str, Callable[[Run], Section | None]] = {
    "outcomes": captured.section,
    "settling-times": settling.section,
    "errors": settling.section,
    "trajectories": trajectories.section,
    "closest-approach": trajectories.section,
    "safety": safety.section,
    "comparison": comparison.section,
    "envelopes": envelopes.section,
    "wrench": envelopes.section,
    "saturation": saturation.section,
    "saturation-severity": saturation.section,
    "adaptation": adaptation.section,
    "drivers": which_draws.section,
    "evidence": evidence.section,
}
"""The section that makes a figure, by the figure's name."""


class Panels(tuple[Axes, ...]):
    """The axes of a figure in reading order, shown as the figure in a notebook."""

    __slots__ = ()

    @property
    def figure(self) -> Figure:
        """The figure of the axes."""
        figure = self[0].get_figure(root=True)
        assert isinstance(figure, Figure)
        return figure

    def _repr_png_(self) -> bytes:
        """The picture, for a notebook."""
        sink, figure = io.BytesIO(), self.figure
        with matplotlib.rc_context(STYLE):
            FigureCanvasAgg(figure)
            figure.savefig(sink, format="png", dpi=PIXELS_PER_INCH)
        return sink.getvalue()


class Plots:
    """The figures of a run. Each call makes new axes. UsageError where the run has nothing for a figure."""

    def __init__(self, run: Run) -> None:
        self._run = run

    @classmethod
    def of(cls, path: str | Place) -> Self:
        """Of a run folder, which is read once."""
        return cls(open_run(path))

    def outcomes(self) -> Panels:
        """All requested samples by outcome."""
        return self._figure("outcomes")

    def settling(self) -> Panels:
        """Distribution functions of the settling and recovery times."""
        return self._figure("settling-times")

    def errors(self) -> Panels:
        """Distribution functions of the remaining errors."""
        return self._figure("errors")

    def trajectories(self) -> Panels:
        """Kept flights in the orbital frame and about the docking port, with corridor and keep-out zone."""
        return self._figure("trajectories")

    def closest_approach(self) -> Panels:
        """Distribution function of the closest approach."""
        return self._figure("closest-approach")

    def safety(self) -> Panels:
        """Clearance of the hulls, and where they were closest."""
        return self._figure("safety")

    def comparison(self) -> Panels:
        """Controllers on the same draws."""
        return self._figure("comparison")

    def flights(self) -> Panels:
        """Errors over time: median, 5–95 % range, full range, worst flights."""
        return self._figure("envelopes")

    def wrench(self) -> Panels:
        """Commanded wrench over time."""
        return self._figure("wrench")

    def saturation(self) -> Panels:
        """Saturation of each channel."""
        return self._figure("saturation")

    def saturation_over_faults(self) -> Panels:
        """Saturation over the severity of the faults."""
        return self._figure("saturation-severity")

    def adaptation(self) -> Panels:
        """Peak values of the adaptive controller."""
        return self._figure("adaptation")

    def drivers(self) -> Panels:
        """Rank correlations of the draws that matter."""
        return self._figure("drivers")

    def evidence(self) -> Panels:
        """Evidence of sequential verdicts over the number of samples."""
        return self._figure("evidence")

    def _figure(self, name: str) -> Panels:
        with matplotlib.rc_context(STYLE):
            section = _MADE_BY[name](self._run)
        drawings = {drawing.name: drawing for drawing in section.drawings} if section is not None else {}
        if name not in drawings:
            raise UsageError(f"{self._run.folder}: nothing for the figure {name}; accepted: a run whose report has it")
        return Panels(drawings[name].figure.axes)
