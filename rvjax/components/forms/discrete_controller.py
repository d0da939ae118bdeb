"""The user's discrete-time controller: difference equations at the instants of a period, on plain arrays.

    (force, torque), x_c⁺ = update(measured, x_c, gains)       at t = 0, T, 2T, …, held in between

x_c: the state of the controller; T: its period.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from rvjax.campaign import Model, number
from rvjax.components.controllers import interface
from rvjax.components.forms import arrays
from rvjax.components.forms.controller import Command, checked, report, started, unlimited, with_gains
from rvjax.components.forms.form import check_form
from rvjax.components.forms.measured import Measured
from rvjax.components.forms.signal import Signal, columns
from rvjax.components.registry import Component
from rvjax.components.user_mistakes import UserMistake, given_by
from rvjax.physics.state import Measurement, Numbers, Report
from rvjax.physics.vectors import Channels


@dataclass(frozen=True)
class DiscreteController:
    """A discrete-time controller: it acts at the instants of its period, and its command is held in between.

    gains, start, signals, vectors: as of `Controller`. update(measured, state, gains) → (`Command`, new state); the command has
    no rate. period_s: default of the key `period_s` [s], a whole number of steps of the integration; None: the period is
    `horizon.control_period_s`.
    """

    gains: type[Model]
    start: Callable[..., Any] | None = None
    update: Callable[..., tuple[Command, Any]] | None = None
    signals: Mapping[str, Signal] | None = None
    vectors: bool = False
    period_s: float | None = None

    family = "controllers"

    def __post_init__(self) -> None:
        check_form(self, functions=("update",), maybe=("start",), model=self.gains)

    @cached_property
    def component(self) -> Component[Any]:
        """The component of the registry."""
        doc = "period of the controller, a whole number of steps; by default horizon.control_period_s"
        period = number("s", default=self.period_s, above=0.0, doc=doc)
        return Component(with_gains(self.gains, period_s=(float | None, period)), self._build)

    def _build(self, parameters: Any) -> interface.DiscreteController:
        return interface.DiscreteController(self._start, self._update, columns(self.signals), parameters.period_s)

    def _start(self, measurement: Measurement, gains: Numbers) -> Any:
        return started(self.start, Measured.of(measurement, unlimited, not self.vectors), self._numbers(gains))

    def _update(
        self, measurement: Measurement, state: Any, saturate: interface.Saturate, gains: Numbers
    ) -> tuple[Channels, Any, Report]:
        assert self.update is not None
        name = self.update.__name__
        with given_by(self.update):
            given = self.update(Measured.of(measurement, saturate, not self.vectors), state, self._numbers(gains))
            if not isinstance(given, tuple) or isinstance(given, Command) or len(given) != 2:
                raise UserMistake(f"{name} returns {arrays.kind(given)}", "accepted: Command(…), new_state")
            wrench, signals = checked(given[0], name, self.signals)
            return wrench, arrays.tree_like(state, given[1], f"the new state of {name}"), report(wrench, signals)

    def _numbers(self, gains: Numbers) -> Numbers:
        return gains if self.vectors else arrays.arrays(gains)
