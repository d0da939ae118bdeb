"""Interface of a controller: two functions of a sample at an instant."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from rvjax.columns import Column
from rvjax.physics.state import Measurement, Numbers, Report
from rvjax.physics.vectors import Channels

WRENCH = "N, N·m"

Saturate = Callable[[Channels], tuple[Channels, Channels]]
"""v → (h(v), h'(v)) of the simulated actuators, as the drive electronics report it."""


ESTIMATES = {
    "mass_kg": Column("mass_kg", "kg", "estimated mass"),
    "inertia_kgm2": Column("inertia_kgm2", "kg·m²", "estimated inertia"),
}
"""Signals of a controller that estimates mass and inertia."""


class Response(NamedTuple):
    """command: v before the saturation [N, N·m]; rate: of the controller's state; report: for metrics and traces."""

    command: Channels
    rate: Any
    report: Report


class DiscreteController(NamedTuple):
    """A controller that acts at the instants of its period only; its command is held in between.

    start(measurement, gains) → its state at t = 0; update(measurement, state, saturate, gains) → (command, new state, report).
    period_s: None for `horizon.control_period_s`.
    """

    start: Callable[[Measurement, Numbers], Any]
    update: Callable[[Measurement, Any, Saturate, Numbers], tuple[Channels, Any, Report]]
    signals: Mapping[str, Column] = {}
    period_s: float | None = None


class Controller(NamedTuple):
    """start(measurement, gains) → the controller's state at t = 0; respond(measurement, state, saturate, gains) → `Response`.

    signals: unit and meaning of each signal in its report; the unit WRENCH stands for N or N·m, depending on the channel.
    """

    start: Callable[[Measurement, Numbers], Any]
    respond: Callable[[Measurement, Any, Saturate, Numbers], Response]
    signals: Mapping[str, Column] = {}
