"""Regions of failure: failing points near each other, the coordinates that moved, and the most probable flight of each.

    S           coordinates whose mean or variance among failing points differs from N(0, 1) (`importance.select`)
    part        of the mixture of round normal laws that `importance.learn` fits in S
    region      the points that a part is most probable for; parts whose means are nearer than NEAR are one region
    distance    |z_S| of the region's point nearest to the origin in S: its most probable failure

Failing points are states of chains, many of them near each other, so the numbers of points are shares, not counts of flights.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components  # pyright: ignore[reportMissingTypeStubs]

from rvjax.campaign.export import campaign_text
from rvjax.components.samplers.uniforms_table import NOISE, columns_of
from rvjax.execution.draw_space import DrawSpace
from rvjax.run_folder import RunFolder, rare_record
from rvjax.run_folder.rare_record import Moved, Region
from rvjax.simulation.batch import LANES
from rvjax.stats.rare import importance
from rvjax.stats.rare.points import Points, joined
from rvjax.stats.rare.splitting import STATES

SHOWN, MOVED = 12, 8
"""Most regions, and most coordinates of a region."""


NEAR = 4.0
"""Distance of two means, in σ, below which their parts are one region."""


@dataclass(frozen=True)
class Found:
    """A region and the point of its most probable flight."""

    record: Region
    nearest: Points


def find(space: DrawSpace, failing: Points, seed: int) -> list[Found]:
    """The regions of failing points, the largest first; none where fewer than two points failed."""
    if len(failing) < 2:
        return []
    proposal = importance.learn(failing.z, max(len(failing) // STATES, 20), seed)
    selected = proposal.selected if len(proposal.selected) else np.arange(failing.z.shape[1])
    x = failing.z[:, selected]
    region_of = merged(proposal.mixture.means)
    member = region_of[np.argmax(proposal.mixture.log_parts(failing.z[:, proposal.selected]), axis=1)]
    rows = [np.flatnonzero(member == region) for region in np.unique(region_of)]
    rows = sorted((part for part in rows if len(part)), key=len, reverse=True)[:SHOWN]
    nearest = [part[int(np.argmin(np.sum(x[part] ** 2, axis=1)))] for part in rows]
    flown = space.fly_chunk(failing.z[nearest], failing.keys[nearest])
    margins = space.failure_margins(flown.frame)
    found: list[Found] = []
    for place, (part, first) in enumerate(zip(rows, nearest, strict=True)):
        mean, deviation = x[part].mean(axis=0), x[part].std(axis=0)
        order = np.argsort(-(np.abs(mean) + np.abs(deviation - 1.0)))[:MOVED]
        region = Region(
            points=len(part),
            share=len(part) / len(failing),
            distance=float(np.linalg.norm(x[first])),
            margin=float(margins[place]),
            outcome=str(flown.frame["outcome"].iloc[place]),
            draws={name: float(values[place]) for name, values in flown.draws.values.items()},
            moved=[
                Moved(name=space.coordinates[selected[k]].name, mean=float(mean[k]), deviation=float(deviation[k])) for k in order
            ],
            sample=place,
        )
        found.append(Found(region, failing.rows(np.array([first]))))
    return found


def merged(means: NDArray[np.float64]) -> NDArray[np.int64]:
    """(K,) the region of each part of a mixture with means (K, q): parts that a chain of near means connects are one region."""
    near = np.linalg.norm(means[:, None] - means[None], axis=2) < NEAR
    return np.asarray(connected_components(near, directed=False)[1], dtype=np.int64)


def export(space: DrawSpace, found: Sequence[Found], folder: RunFolder, overrides: Sequence[object]) -> None:
    """Writes the most probable flight of each region as a campaign that flies it again, with the noise that it had."""
    if not found:
        return
    spec = space.problem.spec
    points = joined([region.nearest for region in found])
    numbers = space.numbers(points.z)
    table = {column: block[:, k] for name, block in numbers.items() for k, column in enumerate(columns_of(name, block.shape[1]))}
    head = ",".join([*table, NOISE])
    lines = [
        ",".join([*(repr(float(values[row])) for values in table.values()), str(int(points.keys[row]))])
        for row in range(len(points))
    ]
    drawn = sorted({name.partition(".")[0] for name in numbers})  # a single flight cannot prove that a draw acts
    sets = [
        *(str(item) for item in overrides),
        f"audit={{allow: [{', '.join(drawn)}]}}",
        f"samples={len(points)}",
        f"sampler={{use: points, csv: {rare_record.POINTS}}}",
        "keep={all: true}",
    ]
    comment = f"{rare_record.FAILING}: the most probable failing flight of each region, as a sample each."
    text = campaign_text(spec, sets, ("require", "laws", "tune", "baselines"), "-failing", comment)
    folder.write_text(rare_record.POINTS, "\n".join([head, *lines]) + "\n")
    folder.write_text(rare_record.FAILING, text)


assert SHOWN <= LANES, "the most probable flights fit in a chunk"
