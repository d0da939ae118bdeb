"""What a sampler is: it gives, for the name of a variable and some samples, the numbers that decide their draws."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.float64]
Samples = NDArray[np.int64]


class Points(Protocol):
    """Some samples of a campaign, before their draws."""

    def uniforms(self, name: str, count: int) -> Values:
        """(samples, count) numbers in (0, 1) of a variable, which its law turns into its draws."""
        ...


class Sampler(Protocol):
    """Gives the points of any samples, in any order and number."""

    def at(self, samples: Samples) -> Points:
        """The points of some samples."""
        ...
