"""A number with its unit, fixed or drawn: a scalar, three components, six channels, or a number per thruster."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from rvjax.campaign.distributions import Distribution, Fixed, JointDistribution
from rvjax.campaign.distributions.interface import Array
from rvjax.campaign.thruster_layout import MOST, thruster_names
from rvjax.elementary import length

Shape = Literal["scalar", "vector", "channels", "thrusters"]

COMPONENTS: dict[Shape, tuple[str, ...]] = {
    "scalar": (),
    "vector": ("x", "y", "z"),
    "channels": ("fx", "fy", "fz", "tx", "ty", "tz"),
    "thrusters": thruster_names(MOST),
}
"""Of thrusters: as many of them as there are."""

BESIDE = 1e-9
"""How far to both sides of ½ a distribution is read for its median: one with steps may have several."""


@dataclass(frozen=True)
class Quantity:
    """A number or numbers in SI.

    parts: a distribution for each component (a single part for a scalar), none if `joint` is given; unit: SI, "1" without
    dimension; doc: what it means.
    """

    shape: Shape
    parts: tuple[Distribution, ...]
    joint: JointDistribution | None
    unit: str
    doc: str

    @property
    def components(self) -> tuple[str, ...]:
        """() for a scalar; x, y, z; fx, fy, fz, tx, ty, tz; t1, t2, …"""
        names = COMPONENTS[self.shape]
        return names[: len(self.parts)] if self.shape == "thrusters" else names

    def names(self, name: str) -> tuple[str, ...]:
        """Names of the components of a quantity with this name: `start.rho_m.x`; of a scalar the name itself."""
        return tuple(f"{name}.{component}" for component in self.components) or (name,)

    def draw(self, name: str, uniforms: Callable[[str, int], Array], count: int) -> tuple[Array, ...]:
        """The drawn components, each (count,). name: of the quantity. uniforms(name, k): (count, k) numbers in (0, 1)."""
        if self.joint is not None:
            block = self.joint.ppf(uniforms(name, self.joint.uniforms))
            return tuple(block[:, index] for index in range(len(self.components)))
        return tuple(
            part.ppf(uniforms(component, 1)[:, 0]) if part.uniforms else np.full(count, part.low)
            for component, part in zip(self.names(name), self.parts, strict=True)
        )

    @property
    def is_fixed(self) -> bool:
        """Whether nothing of it is drawn."""
        return self.joint is None and all(isinstance(part, Fixed) for part in self.parts)

    @property
    def supports(self) -> tuple[tuple[float, float], ...]:
        """(low, high) of each component: every possible draw lies between them."""
        if self.joint is not None:
            return ((-self.joint.radius, self.joint.radius),) * len(self.components)
        return tuple((part.low, part.high) for part in self.parts)

    @property
    def medians(self) -> tuple[float, ...]:
        """The median of each component; of a joint distribution, the point at the medians of the numbers that it consumes."""
        if self.joint is not None:
            return tuple(map(float, self.joint.ppf(np.full((1, self.joint.uniforms), 0.5))[0]))
        return tuple(
            part.low if not part.uniforms else float(np.mean(part.ppf([0.5 - BESIDE, 0.5 + BESIDE]))) for part in self.parts
        )

    @property
    def largest_norm(self) -> float:
        """sup |X| over every possible draw."""
        if self.joint is not None:
            return self.joint.radius
        return length(*(max(abs(low), abs(high)) for low, high in self.supports))
