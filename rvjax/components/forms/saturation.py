"""The user's saturation: what a channel gives for a command, between its limits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import jax
import jax.numpy as jnp

from rvjax.campaign import Model
from rvjax.components.forms import arrays
from rvjax.components.forms.form import note_origin
from rvjax.components.registry import Component
from rvjax.components.user_mistakes import given_by
from rvjax.physics.vectors import Scalar


class NoParameters(Model):
    """None."""


@dataclass(frozen=True)
class Saturation:
    """A saturation of a single channel, the same for all six.

    limited(command, upper, lower) → h, with −lower ≤ h ≤ upper [N or N·m]. Its slope h' is its derivative.
    """

    limited: Callable[[Any, Any, Any], Any]

    family = "saturations"

    def __post_init__(self) -> None:
        note_origin(self)
        if not callable(self.limited):
            raise TypeError(f"Saturation: limited is {self.limited!r}; accepted: a function of command, upper and lower")

    @cached_property
    def component(self) -> Component[Any]:
        """The component of the registry."""
        return Component(NoParameters, lambda parameters: self._saturate)

    def _saturate(self, v: Scalar, upper: Scalar, lower: Scalar) -> tuple[Scalar, Scalar]:
        def limited(command: Scalar) -> Scalar:
            with given_by(self.limited):
                return arrays.number(self.limited(command, upper, lower), f"the result of {self.limited.__name__}")

        given = jnp.asarray(v)
        return jax.jvp(limited, (given,), (jnp.ones_like(given),))
