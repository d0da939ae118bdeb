"""diffrax: `diffeqsolve` with the classical Runge–Kutta method at a fixed step, vmapped.

It flies without metrics, in its favour.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

import jax
import numpy as np

from rvjax.execution.bench.workload import Case, UnavailableError
from rvjax.physics.state import State
from rvjax.simulation import closed_loop
from rvjax.simulation.closed_loop import Drawn
from rvjax.simulation.flight import Carry


def prepare(case: Case) -> Callable[[], Carry]:
    """A function that flies the case in one call; the attitude is switched to its shadow at the end, not between steps."""
    try:
        import diffrax
    except ImportError as error:
        raise UnavailableError("diffrax is not installed; pip install diffrax") from error

    coefficients = diffrax.ButcherTableau(
        c=np.array([0.5, 0.5, 1.0]),
        b_sol=np.array([1.0, 2.0, 2.0, 1.0]) / 6.0,
        b_error=np.zeros(4),
        a_lower=(np.array([0.5]), np.array([0.0, 0.5]), np.array([0.0, 0.0, 1.0])),
    )

    class Classical(diffrax.AbstractERK):
        tableau: ClassVar[diffrax.ButcherTableau] = coefficients
        interpolation_cls: ClassVar[Callable[..., object]] = diffrax.ThirdOrderHermitePolynomialInterpolation.from_k

        def order(self, terms: object) -> int:
            del terms
            return 4

    def flight(drawn: Drawn, y: State) -> State:
        step = drawn.context.step_s
        leaves, structure = jax.tree.flatten(y)  # diffrax takes no state with an empty part, as of a controller without states

        def rate(t: Any, leaves: list[Any], args: object) -> list[Any]:
            del args
            return jax.tree.leaves(case.evaluate(drawn, t, jax.tree.unflatten(structure, leaves), case.carry.held)[0])

        end = case.steps * step
        solved = diffrax.diffeqsolve(diffrax.ODETerm(rate), Classical(), 0.0, end, step, leaves, max_steps=case.steps + 1)
        assert solved.ys is not None
        return closed_loop.between_steps(jax.tree.unflatten(structure, [series[-1] for series in solved.ys]))

    compiled = jax.jit(jax.vmap(flight)).lower(case.drawn, case.carry.y).compile()
    return lambda: case.carry._replace(y=jax.block_until_ready(compiled(case.drawn, case.carry.y)))
