"""The flights that a campaign keeps as traces, in addition to the row of every sample."""

from __future__ import annotations

from rvjax.campaign.fields import Model, count, flag


class Keep(Model):
    """Flights that are replayed and kept step by step. Draws and flights do not depend on it; a resumed run may keep others."""

    worst: int = count(default=10, at_most=10_000, doc="number of the worst samples")
    failed: bool = flag(default=False, doc="every sample that is not captured")
    percentiles: bool = flag(
        default=False, doc="the samples at 5, 25, 50, 75 and 95 % of the settling time among the first 10,400"
    )
    all: bool = flag(default=False, doc="every sample")
