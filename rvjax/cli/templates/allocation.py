"""Projected gradient: towards the wrench that is nearest to the command, in a fixed number of steps.

x ← clip(x − (Aᵀ(A x − b) + ε x)/L, 0, 1),   A = W B diag(f_max),   b = W w,   L = |A|² + ε
"""

import jax
import jax.numpy as jnp
import numpy as np

from rvjax.components import Allocation, Parameters, count, number


class Gradient(Parameters):
    """The same in every sample: an allocation has no drawn numbers."""

    steps: int = count(default=20, at_least=1, doc="number of steps")
    effort: float = number("1", default=1e-3, above=0.0, doc="weight ε of the thrusts against the error of the wrench")


def shares(wrench, thrusters, parameters):
    """Shares x of the largest thrusts; the wrench is weighted by the nominal limits, W = diag(2/(u⁺ + u⁻))."""
    weight = 2.0 / (thrusters.upper + thrusters.lower)
    a = weight[:, None] * thrusters.matrix * thrusters.most
    length = 1.0 / (np.linalg.norm(a, 2) ** 2 + parameters.effort)

    def step(_, x):
        slope = a.T @ (a @ x - weight * wrench) + parameters.effort * x
        return jnp.clip(x - length * slope, 0.0, 1.0)

    return jax.lax.fori_loop(0, parameters.steps, step, jnp.zeros(len(thrusters.most)))


ALLOCATION = Allocation(Gradient, shares)
