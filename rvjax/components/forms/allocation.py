"""The user's allocation: how far each thruster opens for a commanded wrench, on plain arrays.

    f = x f_max,   x = clip(shares(w, thrusters, parameters), 0, 1)

It is computed at every instant of a flight, as the commands of the six channels are.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np

from rvjax.campaign import Model
from rvjax.campaign.declarations import DeclaredQuantity, declared
from rvjax.campaign.thruster_layout import Layout, limits
from rvjax.components.forms import arrays
from rvjax.components.forms.form import check_form
from rvjax.components.registry import Component
from rvjax.components.user_mistakes import given_by
from rvjax.physics import thruster_allocation
from rvjax.physics.vectors import Channels, each
from rvjax.physics.vectors import Thrusts as Shares


class Thrusters(NamedTuple):
    """The n nominal thrusters, as NumPy arrays: they are the same in every sample, without spread and faults.

    matrix: (6, n) B of w = B f, in P, about the reference point [1, m]. most: (n,) largest thrusts f_max [N]. upper, lower: (6,)
    nominal limits of the channels, as positive numbers [N, N·m].
    """

    matrix: Any
    most: Any
    upper: Any
    lower: Any


@dataclass(frozen=True)
class Allocation:
    """An allocation: how a commanded wrench becomes thrusts.

    parameters: the model of its numbers, which are the same in every sample: `number`, `count`, `flag` and `option`.
    shares(wrench, thrusters, parameters) → (n,) shares of the largest thrusts; below 0 counts as 0, above 1 as 1. wrench: (6,)
    commanded [N, N·m]; thrusters: `Thrusters`; parameters: of the campaign.
    """

    parameters: type[Model]
    shares: Callable[[Any, Thrusters, Any], Any] | None = None

    family = "allocations"

    def __post_init__(self) -> None:
        check_form(self, functions=("shares",), maybe=(), model=self.parameters)
        if drawn := next(_drawn(self.parameters), ""):
            raise TypeError(
                f"Allocation: {drawn} may be drawn, and an allocation is the same in every sample; accepted: number, count, "
                "flag or option"
            )

    @cached_property
    def component(self) -> Component[Any]:
        """The component of the registry."""
        return Component(self.parameters, self._build)

    def _build(self, parameters: Model) -> Callable[[Layout], thruster_allocation.Allocation]:
        def allocation(layout: Layout) -> thruster_allocation.Allocation:
            upper, lower = map(np.array, limits(layout))
            thrusters = Thrusters(layout.matrix, np.array(layout.most), upper, lower)

            def follow(w: Channels, solved: tuple[()]) -> Shares:
                del solved
                assert self.shares is not None
                with given_by(self.shares):
                    given = self.shares(arrays.array(w), thrusters, parameters)
                    shares = arrays.like(Shares(layout.most), given, f"the result of {self.shares.__name__}")
                return each(lambda x: jnp.clip(x, 0.0, 1.0), shares)

            return thruster_allocation.Allocation(lambda w: (), follow, lambda w: ())

        return allocation


def _drawn(model: type[Model]) -> Iterator[str]:
    """The keys of a model whose numbers may be drawn."""
    for key, info in model.keys().items():
        inner = info.annotation
        if isinstance(declared(info), DeclaredQuantity):
            yield key
        elif isinstance(inner, type) and issubclass(inner, Model):
            yield from (f"{key}.{name}" for name in _drawn(inner))
