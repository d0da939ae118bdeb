"""Which flights a campaign keeps as traces, beside the row that every sample has."""

from __future__ import annotations

from rvjax.campaign.fields import Model, count, flag


class Keep(Model):
    """Flights that are flown again and kept step by step. It changes no draw and no flight, so a resumed run may keep others."""

    worst: int = count(default=10, at_most=10_000, doc="how many of the worst samples")
    failed: bool = flag(default=False, doc="every sample that is not captured")
    percentiles: bool = flag(
        default=False, doc="the samples at 5, 25, 50, 75 and 95 % of the settling time among the first 10,400"
    )
    all: bool = flag(default=False, doc="every sample")
