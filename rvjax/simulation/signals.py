"""Signals: the named numbers of a flight at an instant.

The columns of the trace table (`recorded`), and numbers that follow from them (`derived`):

    position_error_m       |ρ|                                distance from the docking point
    attitude_error_deg     4 atan |σ|                         principal rotation angle from the target's frame
    speed_m_s              |ν|                                velocity error
    closing_speed_m_s      −d|ρ|/dt = −ρᵀν/|ρ|                toward the docking point, below 0 if the pursuer departs
    rate_deg_s             |ω|                                angular rate relative to the target
    share_fx … share_tz    |h(v)|/u_m                         commanded wrench as a share of the limit on its side
    share_any              max of the six

Traces have a column more per channel, mean_fx … mean_tz [N, N·m]: the mean from this row to the next of the total wrench on the
pursuer about its centre of mass, in P. It is no signal of an instant, so margins cannot name it.

ρ̇ = ν − Ω×ρ, and Ω×ρ is normal to ρ. Symbols: `rvjax.physics.state`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from rvjax.campaign import Quantity
from rvjax.columns import AXES, CHANNELS, EFFECT, NAVIGATION, SIGNAL, Column
from rvjax.components.controllers.interface import WRENCH, Controller, DiscreteController
from rvjax.components.effects.interface import Effect
from rvjax.components.navigation.interface import NavigationError
from rvjax.physics.elementary import atan
from rvjax.physics.state import Numbers, Step
from rvjax.physics.vectors import Channels, Scalar, Symmetric, Thrusts, Vector, dot, each, largest, norm
from rvjax.simulation import user_checks
from rvjax.simulation.effects_sum import effects_sum

UNSAID = "?"
"""Unit of a signal that its controller does not declare."""


@dataclass(frozen=True)
class Signal:
    """column: its name, unit and meaning. get: its value at an instant, of a sample or of arrays of samples."""

    column: Column
    get: Callable[[Step], Scalar]


def unit_of(channel: str) -> str:
    """The unit of a wrench on a channel."""
    return "N" if channel[0] == "f" else "N·m"


MEAN_WRENCH: Mapping[str, Column] = {
    f"mean_{channel}": Column(
        f"mean_{channel}",
        unit_of(channel),
        "mean from this row to the next of the total wrench about the centre of mass, in P; NaN in the last row",
    )
    for channel in CHANNELS
}
"""The columns of a trace that are no signals: a mean over steps (`rvjax.simulation.mean_wrench`)."""


def recorded(
    meanings: Mapping[str, Column],
    values: Mapping[str, Any],
    measured: bool,
    thrusters: int,
    effects: Mapping[str, tuple[Effect, Any]] | None = None,
    propellant: bool = False,
    interrupted: Sequence[str] = (),
    guided: bool = False,
) -> dict[str, Signal]:
    """The columns of a trace, by name and in their order; everything in SI, frames as in `rvjax.physics.state`.

    meanings: of the declared signals of the controller; values: a value of each signal, whose type says its components. measured:
    include the measured motion. thrusters: their number. effects: name → (effect, its state and its signals at an instant).
    propellant: include what is left of it, and the mass and the centre of mass of the instant.
    interrupted: the navigation errors with times without a new measurement. guided: include the reference point of the guidance.
    """
    signals = [Signal(Column("t_s", "s", "time"), lambda step: step.t), *_motion(measured), *_wrenches()]
    signals += _path() if guided else []
    for i in range(thrusters):
        column = Column(f"thrust_t{i + 1}_N", "N", f"thrust of t{i + 1} behind the faults")
        signals.append(Signal(column, lambda step, i=i: thrusts(step)[i]))
    for name in (*meanings, *sorted(values.keys() - meanings.keys())):
        meaning = meanings.get(name, Column(name, UNSAID, name))
        for suffix in _parts(values[name]):
            unit = unit_of(suffix[1:]) if meaning.unit == WRENCH else meaning.unit
            column = Column(f"{SIGNAL}{name}{suffix}", unit, f"{meaning.description}, a signal of the controller")
            signals.append(Signal(column, lambda step, name=name, suffix=suffix: _parts(step.report.signals[name])[suffix]))
    for index, (name, (effect, (state, given))) in enumerate((effects or {}).items()):
        signals += _of_effect(index, name, effect, state, given)
    signals += _of_propellant() if propellant else []
    for index, name in enumerate(interrupted):
        column = Column(f"{NAVIGATION}{name}.age_s", "s", f"time since the last measurement, of {name}")
        signals.append(Signal(column, lambda step, index=index: step.ages[index]))
    return {signal.column.name: signal for signal in signals}


def _of_propellant() -> list[Signal]:
    """What changes as propellant is used."""
    centre = "centre_of_mass_{}_m", "centre of mass, from the reference point, in P"
    return [
        Signal(Column("propellant_left_kg", "kg", "propellant left"), attrgetter("tank.left")),
        Signal(Column("mass_kg", "kg", "mass of the pursuer"), attrgetter("plant.mass")),
        *(Signal(Column(centre[0].format(axis), "m", centre[1]), attrgetter(f"plant.centre.{axis}")) for axis in AXES),
    ]


def _of_effect(index: int, name: str, effect: Effect, state: Any, given: Mapping[str, Any]) -> Iterator[Signal]:
    """The columns of an effect: the leaves of its state, and its signals."""
    stem = f"{EFFECT}{name}."
    for number, (path, leaf) in enumerate(jax.tree_util.tree_flatten_with_path(state)[0]):
        place = jax.tree_util.keystr(path, simple=True, separator="_") or "state"
        for entry in np.ndindex(leaf.shape[1:]) if np.ndim(leaf) > 1 else ((),):
            ending = "".join(f"_{i + 1}" for i in entry)

            def get(step: Step, number: int = number, entry: tuple[int, ...] = entry) -> Any:
                values = jax.tree.leaves(step.effects[index][0])[number]
                return values[(..., *entry)] if entry else values

            yield Signal(Column(f"{stem}{place}{ending}", UNSAID, f"state of the effect {name}"), get)
    for signal in (*effect.signals, *sorted(given.keys() - effect.signals.keys())):
        meaning = effect.signals.get(signal, Column(signal, UNSAID, signal))
        for suffix in _parts(given[signal]):
            column = Column(f"{stem}{signal}{suffix}", meaning.unit, f"{meaning.description}, a signal of the effect {name}")
            yield Signal(column, lambda step, signal=signal, suffix=suffix: _parts(step.effects[index][1][signal])[suffix])


def _motion(measured: bool) -> list[Signal]:
    vectors = {
        "rho_{}_m": ("m", "pursuer minus docking point, in P", "rho", "motion.rho"),
        "nu_{}_m_s": ("m/s", "difference of inertial velocities, in P", "nu", "motion.nu"),
        "sigma_{}": ("1", "modified Rodrigues parameters of P with respect to T", "sigma", "motion.sigma"),
        "omega_{}_rad_s": ("rad/s", "angular velocity of P relative to T, in P", "omega", "motion.omega"),
        "target_r_{}_m": ("m", "inertial position of the target, resolved in T", "r_t", "target.r"),
        "target_v_{}_m_s": ("m/s", "inertial velocity of the target, resolved in T", "v_t", "target.v"),
        "target_w_{}_rad_s": ("rad/s", "inertial angular velocity of the target, in T", "w_t", "target.w"),
    }
    if measured:
        vectors |= {
            f"seen_{form}": (unit, f"as measured, {text}", symbol, place.replace("motion", "measured"))
            for form, (unit, text, symbol, place) in vectors.items()
            if place.startswith("motion")
        }
    return [
        Signal(Column(form.format(axis), unit, f"{symbol}: {text}"), attrgetter(f"{place}.{axis}"))
        for form, (unit, text, symbol, place) in vectors.items()
        for axis in AXES
    ]


def _path() -> list[Signal]:
    return [
        Signal(Column(f"ref_{axis}{unit}", of, f"{text} of the reference point, in T"), attrgetter(f"path.{place}.{axis}"))
        for place, unit, of, text in (
            ("point", "_m", "m", "place from the docking point"),
            ("velocity", "_m_s", "m/s", "velocity"),
        )
        for axis in AXES
    ]


def _wrenches() -> list[Signal]:
    wrenches: Mapping[str, tuple[str, Callable[[Step], Channels]]] = {
        "cmd": ("commanded wrench h(v), in P", lambda step: step.commanded),
        "applied": ("wrench behind the faults, before the disturbance, in P", lambda step: step.applied),
        "dist": ("disturbance wrench, in P", lambda step: step.disturbance),
        f"{SIGNAL}v": ("command v before the saturation", lambda step: step.command),
        f"{SIGNAL}chi": ("Nussbaum argument", lambda step: step.report.chi),
    }
    return [
        Signal(
            Column(f"{form}_{channel}", "1" if form == f"{SIGNAL}chi" else unit_of(channel), text),
            lambda step, get=get, i=i: get(step).parts()[i],
        )
        for form, (text, get) in wrenches.items()
        for i, channel in enumerate(CHANNELS)
    ]


def derived() -> dict[str, Signal]:
    """Signals that follow from the columns of a trace, by name."""
    signals = [
        Signal(Column("position_error_m", "m", "distance from the docking point"), lambda step: norm(step.motion.rho)),
        Signal(Column("attitude_error_deg", "deg", "rotation angle from the target frame"), _angle),
        Signal(Column("speed_m_s", "m/s", "velocity error"), lambda step: norm(step.motion.nu)),
        Signal(Column("closing_speed_m_s", "m/s", "speed toward the docking point"), _closing),
        Signal(
            Column("rate_deg_s", "deg/s", "angular rate relative to the target"),
            lambda step: jnp.rad2deg(norm(step.motion.omega)),
        ),
    ]
    for i, channel in enumerate(CHANNELS):
        column = Column(f"share_{channel}", "1", f"commanded wrench as a share of its limit, channel {channel}")
        signals.append(Signal(column, lambda step, i=i: _shares(step).parts()[i]))
    column = Column("share_any", "1", "commanded wrench as a share of its limit, worst channel")
    signals.append(Signal(column, lambda step: largest(_shares(step))))
    return {signal.column.name: signal for signal in signals}


def _angle(step: Step) -> Scalar:
    return jnp.rad2deg(4.0 * atan(norm(step.motion.sigma)))


def _closing(step: Step) -> Scalar:
    """−ρᵀν/|ρ|; 0 at the docking point itself."""
    distance = norm(step.motion.rho)
    return -dot(step.motion.rho, step.motion.nu) / jnp.where(distance > 0.0, distance, 1.0)


def _shares(step: Step) -> Channels:
    def share(h: Scalar, upper: Scalar, lower: Scalar) -> Scalar:
        return jnp.abs(h) / jnp.where(h >= 0.0, upper, lower)

    return each(share, step.commanded, step.plant.upper, step.plant.lower)


def reported(controller: Controller | DiscreteController, gains: Mapping[str, Quantity]) -> Mapping[str, Any]:
    """The signals of a controller, by name, as shapes without numbers: it is traced, not run. gains: of the controller."""
    _, _, report = jax.eval_shape(
        user_checks.traced("controllers", controller), user_checks.numbers(gains), user_checks.ARGUMENTS
    )
    return report.signals


def moved(effect: Effect, quantities: Mapping[str, Quantity]) -> tuple[Any, Mapping[str, Any]]:
    """The state and the signals of an effect, as shapes of arrays of samples: it is traced, not run."""

    def values(numbers: Numbers, given: user_checks.Arguments) -> Any:
        state = effect.start(numbers)
        return state, effects_sum((effect,), (numbers,), (state,), given.t, given.known, given.plant, given.wrench)[2][0]

    shapes = jax.eval_shape(values, user_checks.numbers(quantities), user_checks.ARGUMENTS)
    return jax.tree.map(lambda shape: jax.ShapeDtypeStruct((1, *shape.shape), shape.dtype), shapes)


def interrupting(errors: Mapping[str, NavigationError]) -> list[str]:
    """The names of the navigation errors with times without a new measurement. errors: of a campaign, by name."""
    return [name for name, error in errors.items() if error.age is not None]


def thrusts(step: Step) -> tuple[Any, ...]:
    """The thrust of each thruster [N]; empty without thrusters."""
    return step.thrusts.parts() if isinstance(step.thrusts, Thrusts) else ()


def _parts(value: Any) -> dict[str, Any]:
    """The components of a signal of a controller, by the suffix of their names."""
    names = {Vector: AXES, Channels: CHANNELS, Symmetric: ("xx", "yy", "zz", "yz", "xz", "xy")}.get(type(value))
    return {"": value} if names is None else {f"_{name}": part for name, part in zip(names, value.parts(), strict=True)}
