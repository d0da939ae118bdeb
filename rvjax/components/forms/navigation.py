"""The user's navigation error: the measured motion from the true motion, on plain arrays."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

from rvjax.campaign import Model
from rvjax.components.forms import arrays
from rvjax.components.forms.form import check_form
from rvjax.components.forms.noise import Noise
from rvjax.components.navigation import interface
from rvjax.components.registry import Component
from rvjax.components.user_mistakes import UserMistake, given_by
from rvjax.physics import state
from rvjax.physics.state import Numbers, Tick
from rvjax.physics.vectors import Scalar


class Motion(NamedTuple):
    """Relative motion, each of shape (3,): rho [m], nu [m/s], sigma (MRP), omega [rad/s]; frames as of `Measured`."""

    rho: Any
    nu: Any
    sigma: Any
    omega: Any


@dataclass(frozen=True)
class NavigationError:
    """A navigation error.

    parameters: the model of its numbers. see(motion, numbers) → the measured `Motion`; motion: true, or of the error before.
    noise: how many standard normal numbers it gets, new in every step and held during it; then see(motion, xi, numbers).
    """

    parameters: type[Model]
    see: Callable[..., Motion] | None = None
    noise: int = 0

    family = "navigation"

    def __post_init__(self) -> None:
        check_form(self, functions=("see",), maybe=(), model=self.parameters)

    @cached_property
    def component(self) -> Component[Any]:
        """The component of the registry."""
        return Component(self.parameters, self._build, noisy=self.noise > 0)

    def _build(self, parameters: Model) -> interface.NavigationError:
        del parameters
        if not self.noise:
            return interface.NavigationError(self._see)
        noise = Noise(self.noise)

        def start(motion: state.Motion, numbers: Numbers) -> Any:
            del motion
            return noise.start(numbers)

        def keep(tick: Tick, motion: state.Motion, memory: Any, numbers: Numbers) -> Any:
            del motion, memory
            return noise.keep(tick, numbers)

        return interface.NavigationError(self._see, start, keep)

    def _see(self, t: Scalar, motion: state.Motion, memory: Any, numbers: Numbers) -> state.Motion:
        assert self.see is not None
        del t
        seen = Motion(*map(arrays.array, motion))
        name = self.see.__name__
        with given_by(self.see):
            given = self.see(seen, *((memory,) if self.noise else ()), arrays.arrays(numbers))
            if not isinstance(given, Motion):
                raise UserMistake(f"{name} returns {arrays.kind(given)}", "accepted: a Motion, such as motion._replace(rho=…)")
            return state.Motion(*(arrays.vector(part, f"{key} of {name}") for key, part in given._asdict().items()))
