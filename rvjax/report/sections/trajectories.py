"""Section: the ways of kept flights in the orbital frame and about the docking port, and how near the samples come.

V-bar, R-bar     p = Rᵀρ + δ from T to LVLH: x along V-bar, z along R-bar, toward the Earth        (`physics.orbit_frame`)
port             p − δ along the docking axis n, and along y and z of the port's frame
zone             the silhouette of p_xᵀ diag(r²) p_x = 1 seen along an axis is an ellipse of the matrix V diag(r²) Vᵀ,
                 V: the two directions of the picture, as rows
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from rvjax.analysis.sample_values import docking_axis, numbers, port
from rvjax.analysis.trace_frames import Values, lvlh, quaternions_of_mrp, turned, vectors
from rvjax.columns import metric_column
from rvjax.report import plotting
from rvjax.report.blocks import Drawing, Section
from rvjax.report.number_format import count, label, spoken
from rvjax.report.run_view import CONFIDENCE, Run
from rvjax.report.sections.settling import required

CLOSEST = "closest_approach_m"
_COLOURS = (plotting.BLUE, plotting.ORANGE, plotting.GREEN, plotting.PURPLE, plotting.SKY)
"""Of the flights; red is the zone."""

_FIXED = math.radians(1.0)
"""The docking axis of a target that turns less in LVLH is drawn there."""


def section(run: Run) -> Section | None:
    """Views of the worst kept flights, and the distribution of the closest approach."""
    ways = [way for sample, trace in run.traces.items() if len((way := _way(run, sample, trace)).place)]
    drawings = [*([_views(run, ways)] if ways else []), *([_closest(run)] if run.metrics(CLOSEST) else [])]
    if not drawings:
        return None
    flights = f"The {count(len(ways))} worst kept flights" if len(ways) > 1 else "The worst kept flight"
    lead = f"{flights} on the way to the docking point. " if ways else ""
    if run.metrics(CLOSEST):
        lead += f"99 % of the samples have a {label(CLOSEST)} of at least {spoken(run.quantile(CLOSEST, 0.01))}."
    return Section("trajectories", "Trajectories and closest approach", lead.strip(), tuple(drawings))


@dataclass(frozen=True)
class _Way:
    """place: p in T, (n, 3). orbit: LVLH → T, (n, 3, 3), None where the trace has no orbit. row: of the samples table."""

    sample: int
    place: Values
    orbit: Values | None
    row: Mapping[str, Any]


def _way(run: Run, sample: int, trace: pd.DataFrame) -> _Way:
    rho, sigma = vectors(trace, "rho_{}_m"), vectors(trace, "sigma_{}")
    finite = np.isfinite(rho).all(axis=1) & np.isfinite(sigma).all(axis=1)
    worst = run.totals.worst
    row = next(iter(worst.loc[worst["sample"] == sample].to_dict("records")), {})
    place = turned(quaternions_of_mrp(sigma[finite]), rho[finite]) + np.array(port(run.spec, row)) if finite.any() else rho[:0]
    orbit = None
    if "target_r_x_m" in trace:
        orbit = lvlh(*(vectors(trace, form)[finite] for form in ("target_r_{}_m", "target_v_{}_m_s")))
    return _Way(sample, place, orbit, row)


def _views(run: Run, ways: list[_Way]) -> Drawing:
    """V-bar and R-bar where the orbit is known; along the docking axis and to both sides of it."""
    orbits = all(way.orbit is not None for way in ways)
    figure, panels = plotting.panels(1, 2 + orbits, 3.5)
    sides = panels[orbits:]
    for way, colour in zip(ways, _COLOURS, strict=False):
        if way.orbit is not None and orbits:
            x, _, z = np.einsum("nji,nj->in", way.orbit, way.place)
            _line(panels[0], x, z, colour, way.sample)
        along, *aside = _port_frame(run, way.row) @ (way.place - np.array(port(run.spec, way.row))).T
        for axis, side in zip(sides, aside, strict=True):
            _line(axis, along, side, colour, way.sample)
    turns = _orbit_scene(run, panels[0], ways[0]) if orbits else ""
    for place, (axis, name) in enumerate(zip(sides, "yz", strict=True)):
        _port_scene(run, axis, ways[0], place + 1)
        axis.set_title(f"Port frame, {name}")
        axis.set_xlabel("along the docking axis, m")
        axis.set_ylabel(f"{name}, m")
    if orbits:
        panels[0].set_title("Orbital frame")
        panels[0].set_xlabel("V-bar, m")
        panels[0].set_ylabel("R-bar (toward the Earth), m")
        panels[0].invert_yaxis()
    for axis in panels:
        axis.set_aspect("equal", adjustable="datalim")
    plotting.shared_legend(figure, plotting.labelled(sides[0]), 8)
    rows = " or ".join(count(n) for n in sorted({len(way.place) for way in ways}))
    caption = (
        f"Kept flights by the number of their sample, {rows} instants each; dots: starts. Origin in the orbital frame: the "
        "target's centre of mass; about the port: the docking point. Corridor, zone and hull are silhouettes, of sample "
        f"{ways[0].sample} where they are drawn; a way over one may pass before it or behind it.{turns}"
    )
    return Drawing("trajectories", caption, figure)


def _line(axis: Axes, x: Values, y: Values, colour: str, sample: int) -> None:
    axis.plot(x, y, color=colour, lw=1.2, label=str(sample))
    axis.plot(x[:1], y[:1], color=colour, marker="o", ms=4, ls="")


def _port_frame(run: Run, row: Mapping[str, Any]) -> Values:
    """The axes n, y, z of the port's frame as rows: T → port (`rvjax.physics.orbit_frame.port_axes`)."""
    n = np.array(docking_axis(run.spec, row))
    if n[0] < -1.0 + 1e-12:
        return np.diag([-1.0, -1.0, 1.0])
    k = 1.0 / (1.0 + n[0])
    return np.array([n, [-n[1], 1.0 - k * n[1] ** 2, -k * n[1] * n[2]], [-n[2], -k * n[1] * n[2], 1.0 - k * n[2] ** 2]])


def _port_scene(run: Run, axis: Axes, way: _Way, side: int) -> None:
    """Corridor, zone and hull seen from the side. side: which axis of the port's frame is up."""
    frame, corridor, delta = _port_frame(run, way.row), run.spec.corridor, np.array(port(run.spec, way.row))
    farthest = float(np.max(np.linalg.norm(way.place - delta, axis=1)))
    end = farthest if corridor.length_m is None else min(corridor.length_m, farthest)
    slope = math.tan(corridor.half_angle_rad)
    along = np.array([-corridor.radius_m / slope if corridor.radius_m else 0.0, end])
    for sign, words in ((1.0, "corridor"), (-1.0, None)):
        axis.plot(along, sign * (corridor.radius_m + along * slope), color=plotting.MUTED, lw=1.1, ls="--", label=words)
    axis.plot([0.0], [0.0], marker="+", color=plotting.INK, ls="", ms=9)
    _bodies(run, axis, way, frame[[0, side]], -delta)


def _orbit_scene(run: Run, axis: Axes, way: _Way) -> str:
    """The scene in LVLH, as far as it does not turn there; what the caption says of it."""
    assert way.orbit is not None
    outward = np.einsum("nji,j->ni", way.orbit, np.array(docking_axis(run.spec, way.row)))
    turn = float(np.arccos(np.clip(outward @ outward[0], -1.0, 1.0)).max())
    if turn < _FIXED and run.spec.target.has_docking_axis:
        view, slope, corridor = way.orbit[0].T[[0, 2]], math.tan(run.spec.corridor.half_angle_rad), run.spec.corridor
        n, delta = view @ np.array(docking_axis(run.spec, way.row)), view @ np.array(port(run.spec, way.row))
        if (seen := float(np.linalg.norm(n))) > 0.99:  # the corridor lies in the plane of the picture
            end = corridor.length_m or float(np.max(np.linalg.norm(way.place, axis=1)))
            n, aside = n / seen, np.array([-n[1], n[0]]) / seen
            for sign in (1.0, -1.0):
                ends = [delta + d * n + sign * (corridor.radius_m + d * slope) * aside for d in (0.0, end)]
                axis.plot(*np.transpose(ends), color=plotting.MUTED, lw=1.1, ls="--")
    _bodies(run, axis, way, way.orbit[0].T[[0, 2]], np.zeros(3))
    return "" if turn < _FIXED else " The target turns in the orbital frame: there the corridor is left out."


def _bodies(run: Run, axis: Axes, way: _Way, view: Values, centre: Values) -> None:
    """The keep-out zone and the ball that holds the target's hull. view: the directions of the picture as rows, in T. centre: of
    the target from the picture's origin, in T."""
    target, row = run.spec.target, way.row
    if target.keep_out is not None:
        radii = np.array(numbers(target.keep_out.radii_m, "target.keep_out.radii_m", row)) * np.ones(3)
        _silhouette(axis, view, centre, radii, plotting.RED, "keep-out zone")
    if target.hull is not None:
        middle = np.array(numbers(target.hull.centre_m, "target.hull.centre_m", row))
        if target.hull.radius_m is not None:
            radius = numbers(target.hull.radius_m, "target.hull.radius_m", row)[0]
        else:
            assert target.hull.box_m is not None
            radius = 0.5 * float(np.linalg.norm(numbers(target.hull.box_m, "target.hull.box_m", row)))
        _silhouette(axis, view, centre + middle, np.full(3, radius), plotting.INK, "target's hull")


def _silhouette(axis: Axes, view: Values, centre: Values, radii: Values, colour: str, words: str) -> None:
    turn = np.linspace(0.0, 2.0 * math.pi, 121)
    edge = np.linalg.cholesky(view @ np.diag(radii**2) @ view.T) @ np.array([np.cos(turn), np.sin(turn)])
    axis.plot(*(edge + (view @ centre)[:, None]), color=colour, lw=1.0, label=words)


def _closest(run: Run) -> Drawing:
    """The distribution function of the closest approach."""
    figure, (axis,) = plotting.axes(1, 1, 2.9)
    values = run.metric(CLOSEST)
    plotting.distribution(axis, values, plotting.BLUE, label(CLOSEST), run.band)
    required(axis, run, CLOSEST, plotting.BLUE)
    plotting.value_axis(axis.xaxis, [values])
    plotting.probability_axis(axis)
    axis.set_xlabel(f"{label(CLOSEST)}, m")
    shaded = f" Shaded: {CONFIDENCE * 100:g} % confidence band (Dvoretzky–Kiefer–Wolfowitz, n = {count(run.flown)})."
    meaning = run.totals.columns[metric_column(CLOSEST)].description
    text = f"Distribution function of the {label(CLOSEST)}, the {meaning[:1].lower()}{meaning[1:]}.{run.design.words(shaded)}"
    return Drawing("closest-approach", text, figure)
