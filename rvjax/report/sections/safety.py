"""Section: collisions, clearance, and times in the keep-out zone and outside of the corridor."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle

from rvjax.campaign import Spec
from rvjax.campaign.hulls import Hull
from rvjax.columns import metric_column
from rvjax.report import plotting
from rvjax.report.blocks import Drawing, Section
from rvjax.report.metric_tables import quantiles, shares
from rvjax.report.number_format import count, label, number, spoken
from rvjax.report.run_view import CONFIDENCE, Run

CLEARANCE, AXIAL, LATERAL = "hull_clearance_m", "closest_axial_m", "closest_lateral_m"
TIME, SPEED = "collision_time_s", "collision_speed_m_s"
HULLS = "|".join((CLEARANCE, AXIAL, LATERAL, TIME, SPEED))
TIMES = "keep_out_violation_s|corridor_violation_s"
SHOWN = 3_000
"""Closest approaches that are drawn; those of collided flights come first."""


def section(run: Run) -> Section | None:
    """Clearance and collisions where there are hulls; times of violation where the campaign says a zone or a corridor."""
    hulls, measured = bool(run.metrics(CLEARANCE)), [name for name in shown(run) if name not in (AXIAL, LATERAL, TIME, SPEED)]
    if not measured:
        return None
    events = {f"{name}.some": (f"{label(name)}: more than 0 s", _positive(run, name)) for name in run.metrics(TIMES)}
    if hulls:
        collided = "collided: the hulls touched, or contact could not be excluded between two steps"
        events = {"collided": (collided, run.account.collided), **events}
    body = (
        *((_figure(run), *_collisions(run)) if hulls else ()),
        shares(run, "Safety of the flown samples.", events),
        quantiles(run, "Distances and times of violation.", measured),
    )
    return Section("safety", "Safety of the approach", _lead(run, hulls), body)


def shown(run: Run) -> list[str]:
    """The metrics that this section shows; none where it is left out."""
    said = run.spec.source.value or {}
    if not run.metrics(f"{CLEARANCE}|keep_out_violation_s") and not said.get("corridor"):
        return []
    return [*run.metrics(HULLS), *run.metrics("closest_approach_m"), *run.metrics(TIMES)]


def _lead(run: Run, hulls: bool) -> str:
    if hulls:
        least = run.quantile(CLEARANCE, 0.01)
        return (
            f"{spoken(run.share('collided', run.account.collided))} of the samples collide. 99 % keep a clearance of at least "
            f"{spoken(least)} between the hulls."
        )
    name = run.metrics(TIMES)[0]
    return f"95 % of the samples have a {label(name)} of at most {spoken(run.quantile(name, 0.95))}."


def _positive(run: Run, name: str) -> int:
    return run.metric(name).at_least(math.ulp(0.0))


def _collisions(run: Run) -> tuple[str, ...]:
    """When and how fast the hulls met, of all samples that collided."""
    collided = run.account.collided
    if not collided:
        return ("No sample collided.",)
    times, speeds = run.metric(TIME), run.metric(SPEED)
    lost = speeds.at_least(math.inf)  # not finite samples: their times come first, their speeds last
    first, last = (number(times.value(lost + rank)) for rank in (0, collided - 1))
    slow, middle, fast = (number(speeds.value(speeds.n - lost - 1 - back)) for back in (collided - 1, collided // 2, 0))
    return (
        f"The {count(collided)} samples collided between {first} s and {last} s, with {slow} m/s to {fast} m/s (median {middle} "
        "m/s) relative to the target.",
    )


def _figure(run: Run) -> Drawing:
    """Left: distribution function of the clearance. Right: where the hulls were closest."""
    figure, (left, right) = plotting.axes(1, 2, 3.6)
    plotting.distribution(left, run.metric(CLEARANCE), plotting.BLUE, label(CLEARANCE), run.band)
    plotting.limit(left, 0.0, "contact", plotting.RED)
    plotting.probability_axis(left)
    left.set_xlabel("hull clearance, m")
    places = _places(run, right)
    band = run.design.words(
        f" Shaded: {CONFIDENCE * 100:g} % confidence band (Dvoretzky–Kiefer–Wolfowitz, n = {count(run.flown)})."
    )
    caption = (
        f"Left: distribution function of the clearance, a lower bound over the whole flight.{band} Right: the pursuer's place "
        f"where the hulls were closest, of {count(places)} samples, with the approach cone and the ball that holds the target's "
        "hull, from medians where they are drawn. A flight goes on after a collision, so its place may lie inside."
    )
    return Drawing("safety", caption, figure)


def _places(run: Run, axis: Axes) -> int:
    """Draws the closest approaches of the first samples, and returns their number."""
    frame = run.head if len(run.head) else run.totals.worst
    frame = frame.loc[np.isfinite(frame[metric_column(CLEARANCE)].to_numpy(dtype=float))]
    hit = (frame["outcome"] == "collided").to_numpy(dtype=bool)
    first = np.sort(np.argsort(~hit, kind="stable")[:SHOWN])
    frame, hit = frame.iloc[first], hit[first]
    along, aside = (frame[metric_column(name)].to_numpy(dtype=float) for name in (AXIAL, LATERAL))
    for chosen, colour, words in ((~hit, plotting.BLUE, "apart"), (hit, plotting.RED, "collided")):
        if chosen.any():
            axis.plot(along[chosen], aside[chosen], ls="", marker=".", ms=4, alpha=0.6, color=colour, label=words)
    _scene(run.spec, axis, float(np.max(along, initial=0.0)))
    axis.set_ylim(bottom=0.0)
    axis.set_aspect("equal", adjustable="box")
    axis.set_xlabel("along the docking axis from the docking point, m")
    axis.set_ylabel("from the docking axis, m")
    axis.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, fontsize=8)
    return len(frame)


def _scene(spec: Spec, axis: Axes, farthest: float) -> None:
    """The approach cone, the docking point and the ball that holds the target's hull."""
    corridor, port = spec.corridor, np.array(spec.target.port_m.medians)
    end = max(farthest, 1.0) if corridor.length_m is None else corridor.length_m
    end = min(end, max(2.0 * farthest, 1.0))
    along = np.array([-corridor.radius_m / math.tan(corridor.half_angle_rad) if corridor.radius_m else 0.0, end])
    axis.plot(along, corridor.radius_m + along * math.tan(corridor.half_angle_rad), color=plotting.GREEN, label="approach cone")
    axis.plot([0.0], [0.0], marker="+", color=plotting.INK, ls="", ms=9, label="docking point", clip_on=False)
    out = np.array(port if spec.target.port_axis is None else spec.target.port_axis)
    if spec.target.hull is not None and np.any(out != 0.0):
        centre = float((np.array(spec.target.hull.centre_m.medians) - port) @ out) / float(np.linalg.norm(out))
        ball = Circle((centre, 0.0), _radius(spec.target.hull), fill=False, color=plotting.INK, lw=1.0, label="target's hull")
        axis.add_patch(ball)


def _radius(hull: Hull) -> float:
    """Of the smallest ball about the hull's centre that holds it [m]; of the medians."""
    if hull.radius_m is not None:
        return hull.radius_m.medians[0]
    assert hull.box_m is not None
    return 0.5 * float(np.linalg.norm(hull.box_m.medians))
