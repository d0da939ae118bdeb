"""The user's guidance: the wanted velocity of the reference point, on plain arrays."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, NamedTuple

from rvjax.campaign import Model
from rvjax.components.forms import arrays
from rvjax.components.forms.called import begun
from rvjax.components.forms.form import check_form
from rvjax.components.guidance import interface
from rvjax.components.guidance.interface import GuidanceParameters, Wanted
from rvjax.components.registry import Component
from rvjax.components.user_mistakes import UserMistake, given_by
from rvjax.physics.orbit_frame import Turning, orbit_turning
from rvjax.physics.state import Numbers, Path

FRAMES = ("target", "lvlh")


class Course(NamedTuple):
    """velocity: wanted of the reference point, (3,), relative to the frame of the guidance and resolved in T [m/s]; memory: for
    the next step, in the structure of the one before."""

    velocity: Any
    memory: Any = ()


class Approach(NamedTuple):
    """What a guidance knows at the beginning of a step, as arrays. Frames: P fixed in the pursuer, T fixed in the target.

    t: time [s]. rho, nu, sigma, omega: measured motion relative to the docking point, as of `Motion`. target_r, target_v,
    target_w, target_alpha: as of `Measured`. port: docking point δ, in T [m]; axis: docking axis in T, a unit vector (0 without
    one). point, point_velocity: the reference point from the docking point, and its velocity, in T [m, m/s].
    """

    t: Any
    rho: Any
    nu: Any
    sigma: Any
    omega: Any
    target_r: Any
    target_v: Any
    target_w: Any
    target_alpha: Any
    port: Any
    axis: Any
    point: Any
    point_velocity: Any


@dataclass(frozen=True)
class Guidance:
    """A guidance.

    parameters: the model of its numbers; it inherits from GuidanceParameters: acceleration and time_constant_s of the reference
    point. course(approach, numbers) → `Course` from the beginning of a step on; frame: what its velocity is relative to, "target"
    or "lvlh", both about the target's centre. With a memory course(approach, memory, numbers), and start(approach, numbers) →
    memory before the first step.
    """

    parameters: type[GuidanceParameters]
    course: Callable[..., Course] | None = None
    start: Callable[..., Any] | None = None
    frame: Literal["target", "lvlh"] = "target"

    family = "guidance"

    def __post_init__(self) -> None:
        check_form(self, functions=("course",), maybe=("start",), model=self.parameters)
        if not issubclass(self.parameters, GuidanceParameters):
            found = f"found {self.parameters.__name__} as its parameters"
            raise TypeError(f"Guidance: {found}; accepted: a class that inherits from GuidanceParameters")
        if self.frame not in FRAMES:
            raise TypeError(f"Guidance: found the frame {self.frame!r}; accepted: {' or '.join(FRAMES)}")

    @cached_property
    def component(self) -> Component[Any]:
        """The component of the registry."""
        return Component(self.parameters, self._build)

    def _build(self, parameters: Model) -> interface.Guidance:
        del parameters
        return interface.Guidance(self._wanted, self._start)

    def _start(self, situation: interface.Situation, path: Path, numbers: Numbers) -> Any:
        return () if self.start is None else begun(self.start, "the memory", _approach(situation, path), arrays.arrays(numbers))

    def _wanted(self, situation: interface.Situation, path: Path, memory: Any, numbers: Numbers) -> Wanted:
        assert self.course is not None
        name, seen = self.course.__name__, _approach(situation, path)
        with given_by(self.course):
            given = self.course(seen, *(() if self.start is None else (memory,)), arrays.arrays(numbers))
            if not isinstance(given, Course):
                raise UserMistake(f"{name} returns {arrays.kind(given)}", "accepted: Course(velocity=…)")
            velocity = arrays.vector(given.velocity, f"the velocity of {name}")
            kept = arrays.tree_like(memory, given.memory, f"the memory of {name}")
        still = Turning(path.point * 0.0, path.point * 0.0)
        turning = still if self.frame == "target" else orbit_turning(situation.target, situation.alpha_t)
        return Wanted(velocity, turning, kept)


def _approach(situation: interface.Situation, path: Path) -> Approach:
    motion, target = situation.motion, situation.target
    known = (*motion, *target, situation.alpha_t, situation.port, situation.axis, path.point, path.velocity)
    return Approach(situation.t, *map(arrays.array, known))
