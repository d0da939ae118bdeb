"""The value that a metric must stay below or above."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


@dataclass(frozen=True)
class Bound:
    """x < value where the side is below, x > value where it is above. value: in the metric's unit."""

    side: Literal["below", "above"]
    value: float

    @property
    def sign(self) -> float:
        """+1 below, −1 above: the smaller sign · x, the better."""
        return 1.0 if self.side == "below" else -1.0

    @property
    def worst(self) -> float:
        """The worst value that a metric can have: ∞ below, −∞ above."""
        return self.sign * math.inf

    def met_by(self, x: NDArray[np.float64]) -> NDArray[np.bool_]:
        """(n,) which values meet the bound; NaN never does."""
        return x < self.value if self.side == "below" else x > self.value

    def excess(self, x: float) -> float:
        """How far x is on the wrong side; negative where it meets the bound."""
        return x - self.value if self.side == "below" else self.value - x


def bound_of(below: float | None, above: float | None) -> Bound | None:
    """The bound of a campaign's keys `below` and `above`, of which at most one is set; None where neither is."""
    if below is not None:
        return Bound("below", below)
    return None if above is None else Bound("above", above)
