"""The flights that a campaign keeps as traces, in addition to the row of every sample."""

from __future__ import annotations

import math

from rvjax.campaign.fields import Model, count, flag

TRACE_ROWS = 600
"""A kept flight of more steps is thinned to every n-th step and the last, so that it has at most one row more than this."""


def steps_per_row(steps: int) -> int:
    """Steps between two rows of a kept flight of `steps` steps. Its first and last instant always have a row."""
    return math.ceil(steps / TRACE_ROWS)


class Keep(Model):
    """Flights that are replayed and kept as traces of at most 601 rows; `rvjax replay` gives every step of a flight.

    Draws and flights do not depend on it; a resumed run may keep others.
    """

    worst: int = count(default=10, at_most=10_000, doc="number of the worst samples")
    failed: bool = flag(default=False, doc="every sample that is not captured")
    percentiles: bool = flag(
        default=False, doc="the samples at 5, 25, 50, 75 and 95 % of the settling time among the first 10,400"
    )
    all: bool = flag(default=False, doc="every sample")
