"""The law of a table: what was measured, drawn again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from rvjax.campaign.distributions.interface import Array, array


@dataclass(frozen=True)
class Empirical:
    """P(X = x_i) = 1/n for each of n numbers of a table; a campaign calls it `table`.

    interpolate: F⁻¹(u) is x_(1) at u = 0, x_(n) at u = 1 and linear between the x_(i) at u = (i − 1)/(n − 1), so that numbers
    between those of the table are drawn as well. values: in rising order.
    """

    values: tuple[float, ...]
    interpolate: bool = False
    uniforms: ClassVar[int] = 1

    @classmethod
    def of(cls, values: Sequence[float], interpolate: bool = False) -> Empirical:
        """The law of some numbers, in any order."""
        if not values:
            raise ValueError("there is nothing to draw from")
        return cls(tuple(sorted(values)), interpolate)

    @property
    def low(self) -> float:
        return self.values[0]

    @property
    def high(self) -> float:
        return self.values[-1]

    @cached_property
    def _sorted(self) -> Array:
        return array(self.values)

    def ppf(self, u: ArrayLike) -> Array:
        share, x = array(u), self._sorted
        if self.interpolate:
            place = share * (len(x) - 1)
            below = np.clip(np.floor(place), 0, max(len(x) - 2, 0)).astype(np.int64)
            low, high, part = x[below], x[np.minimum(below + 1, len(x) - 1)], place - below
            return np.clip((1.0 - part) * low + part * high, low, high)
        return x[np.clip(np.ceil(share * len(x)).astype(np.int64) - 1, 0, len(x) - 1)]

    def cdf(self, x: ArrayLike) -> Array:
        known, asked = self._sorted, array(x)
        behind = np.searchsorted(known, asked, side="right")
        if not self.interpolate:
            return behind / len(known)
        left, right = known[np.maximum(behind - 1, 0)], known[np.minimum(behind, len(known) - 1)]
        part = np.where(right > left, (asked - left) / np.where(right > left, right - left, 1.0), 0.0)
        inside = (behind - 1 + part) / max(len(known) - 1, 1)
        return np.where(behind == 0, 0.0, np.where(behind == len(known), 1.0, inside))

    def scaled(self, factor: float) -> Empirical:
        return Empirical(tuple((self._sorted * factor).tolist()), self.interpolate)
