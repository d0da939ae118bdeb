"""Noise inside a flight: normal numbers that depend on the sample's key and the number of the step, and on nothing else.

    ξ_k = normal numbers of the Threefry stream with the sample's 64-bit key, at counter k

The same numbers whichever samples fly beside it and wherever a flight is interrupted (J. Salmon et al., "Parallel random numbers:
as easy as 1, 2, 3", SC'11; the implementation is JAX's).
"""

from __future__ import annotations

import jax
import jax.numpy as jnp

from rvjax.algebra import Scalar


def normals(key: tuple[Scalar, ...], k: Scalar, count: int) -> tuple[Scalar, ...]:
    """`count` independent standard normal numbers of step k. key: four whole numbers of 16 bits."""
    a, b, c, d = (part.astype(jnp.uint32) for part in key)
    stream = jax.random.wrap_key_data(jnp.stack([(a << 16) | b, (c << 16) | d]), impl="threefry2x32")
    drawn = jax.random.normal(jax.random.fold_in(stream, k), (count,), key[0].dtype)
    return tuple(drawn[index] for index in range(count))
