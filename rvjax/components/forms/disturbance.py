"""The user's disturbance: a force and a torque on the pursuer, on plain arrays."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

from rvjax.campaign import Model
from rvjax.components.disturbances import interface
from rvjax.components.forms import arrays
from rvjax.components.forms.called import Wrench, wrench
from rvjax.components.forms.form import check_form
from rvjax.components.forms.noise import Noise
from rvjax.components.registry import Component
from rvjax.physics.dynamics import Relative
from rvjax.physics.state import Numbers, Plant, State, Tick
from rvjax.physics.vectors import Channels, Scalar


class Scene(NamedTuple):
    """The true motion and body at an instant, as arrays. Frames: P fixed in the pursuer, T fixed in the target.

    t: time [s]. rho, nu, sigma, omega: as of `Measured`, but true. target_r, target_v, target_w: of the target, in T.
    rate: inertial angular velocity of the pursuer, in P [rad/s]. mass: of the pursuer [kg]; inertia: (3, 3), about its centre of
    mass, in P [kg·m²]; centre: of mass, in P [m]; port: docking point, in T [m]. xi: the normal numbers of this step.
    """

    t: Any
    rho: Any
    nu: Any
    sigma: Any
    omega: Any
    target_r: Any
    target_v: Any
    target_w: Any
    rate: Any
    mass: Any
    inertia: Any
    centre: Any
    port: Any
    xi: Any = ()


@dataclass(frozen=True)
class Disturbance:
    """A disturbance: a force and a torque without a state.

    parameters: the model of its numbers. push(scene, numbers) → `Wrench`. noise: how many standard normal numbers `scene.xi`
    has, new in every step and held during it.
    """

    parameters: type[Model]
    push: Callable[..., Wrench] | None = None
    noise: int = 0

    family = "disturbances"

    def __post_init__(self) -> None:
        check_form(self, functions=("push",), maybe=(), model=self.parameters)

    @cached_property
    def component(self) -> Component[Any]:
        """The component of the registry."""
        return Component(self.parameters, self._build, noisy=self.noise > 0)

    def _build(self, parameters: Model) -> interface.Disturbance:
        del parameters
        if not self.noise:
            return interface.Disturbance(self._push)
        noise = Noise(self.noise)

        def keep(tick: Tick, y: State, memory: Any, numbers: Numbers) -> Any:
            del y, memory
            return noise.keep(tick, numbers)

        return interface.Disturbance(self._push, noise.start, keep)

    def _push(self, t: Scalar, y: State, known: Relative, plant: Plant, memory: Any, numbers: Numbers) -> Channels:
        values = (*y.motion, *y.target, known.omega_p, plant.mass, plant.inertia, plant.centre, plant.port)
        seen: list[Any] = [t, *map(arrays.array, values), memory]
        return wrench(self.push, Scene(*seen), arrays.arrays(numbers))
