"""Normal numbers for a user's component: new in every step, held during it, different in every sample."""

from __future__ import annotations

from typing import Any, NamedTuple

import jax.numpy as jnp

from rvjax.physics.noise import normals
from rvjax.physics.state import Numbers, Tick


class Noise(NamedTuple):
    """size: how many there are."""

    size: int

    def start(self, numbers: Numbers) -> Any:
        """(size,) zeros before the first step."""
        return jnp.stack([numbers.noise[0] * 0.0] * self.size)

    def keep(self, tick: Tick, numbers: Numbers) -> Any:
        """(size,) standard normal numbers of a step."""
        return jnp.stack(normals(numbers.noise, tick.k, self.size))
