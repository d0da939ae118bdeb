"""`jit(vmap(scan(RK4)))` with JAX's default settings: what one writes first."""

from __future__ import annotations

from collections.abc import Callable

import jax
import jax.numpy as jnp

from rvjax.execution.bench.workload import Case
from rvjax.simulation.closed_loop import Drawn
from rvjax.simulation.flight import Carry


def prepare(case: Case) -> Callable[[], Carry]:
    """A function that flies the case in one call."""

    def flight(drawn: Drawn, carry: Carry) -> Carry:
        return jax.lax.scan(lambda now, k: (case.step(drawn, now, k), None), carry, jnp.arange(case.steps))[0]

    compiled = jax.jit(jax.vmap(flight)).lower(case.drawn, case.carry).compile()
    return lambda: jax.block_until_ready(compiled(case.drawn, case.carry))
