"""The outer shapes of the spacecraft and the zone around the target that a pursuer may enter through the corridor only."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Self

from pydantic import model_validator

from rvjax.campaign.fields import Model, scalar, vector
from rvjax.campaign.problems import Problem, refuse
from rvjax.campaign.quantity import Quantity


class Hull(Model):
    """A ball or a box that holds the whole spacecraft, without its docking mechanism: radius_m or box_m."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = ({"radius_m": 1.2}, {"box_m": [2, 2, 3]})

    radius_m: Quantity | None = scalar("m", default=None, above=0.0, doc="radius of a ball")
    box_m: Quantity | None = vector("m", default=None, above=0.0, doc="edges of a box along the axes of the spacecraft's frame")
    centre_m: Quantity = vector("m", default=0.0, doc="centre of the ball or box in the spacecraft's frame")

    @model_validator(mode="after")
    def _one_shape(self) -> Self:
        if (self.radius_m is None) == (self.box_m is None):
            message = "neither radius_m nor box_m" if self.radius_m is None else "both radius_m and box_m"
            refuse(Problem(message, "accepted: one of the two"))
        return self


class KeepOut(Model):
    """An ellipsoid about the target's centre of mass, with axes along those of the target's frame."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = ({"radii_m": 10},)

    radii_m: Quantity = vector("m", above=0.0, doc="semi-axes of the ellipsoid; one number: a ball")
