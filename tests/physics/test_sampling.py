"""A sampled controller: it looks and commands at its instants, its command stands in between, its own state goes on."""

from __future__ import annotations

from functools import partial
from typing import Any

import jax
import numpy as np
import pytest

from rvjax.components.controllers.interface import Controller, Response
from rvjax.physics.state import Measurement, Numbers, Report, State
from rvjax.physics.vectors import Channels, Vector
from rvjax.simulation import closed_loop, flight
from rvjax.simulation.closed_loop import Drawn, Loop
from tests import flights
from tests.members import array, built

H = 0.0625
STEPS = 9


def respond(measurement: Measurement, memory: Vector, saturate: Any, gains: Numbers) -> Response:
    """Proportional, derivative and integral: an own state that is integrated."""
    del saturate, gains
    force = measurement.motion.rho * -0.3 - measurement.motion.nu * 4.0 - memory * 0.02 + measurement.target.w * measurement.t
    command = Channels(force, measurement.motion.sigma * -0.4 - measurement.motion.omega * 3.0)
    return Response(command, measurement.motion.rho + memory * 0.1, Report(command * 0.0, force.x * 0.0, {}))


LAW = Controller(lambda measurement, gains: measurement.motion.rho * 0.5, respond)


def scene(sampling: int) -> tuple[Loop, Drawn]:
    """One lane of the scene that flights are tested in, without faults and disturbances."""
    closed = flights.loop("pd-plus")._replace(controller=LAW, sampling=sampling, disturbances=(), faults=())
    return closed, flights.lane(flights.draw({}, 1.0, H)._replace(disturbances=(), faults=()), 1)


def flown(sampling: int) -> tuple[list[tuple[Any, Any]], State]:
    """The commands where each step begins and within it, at another place; and the last state. One operation after the other."""
    closed, drawn = scene(sampling)
    evaluate = partial(closed_loop.evaluate, closed)
    carry, commands = flight.begin(closed, (), drawn), list[tuple[Any, Any]]()
    for k in range(STEPS):
        _, now, held = flight.step_start(evaluate, drawn, carry, k)
        elsewhere = carry.y._replace(motion=carry.y.motion._replace(rho=carry.y.motion.rho * 2.0))
        _, later, _ = evaluate(drawn, (k + 0.5) * H, elsewhere, held, None)
        commands.append((array(now.command), array(later.command)))
        carry = flight.step(evaluate, (), drawn, carry, k)
    return commands, carry.y


@pytest.mark.parametrize("every", [1, 3, 4])
def test_a_sampled_flight_is_the_one_written_by_hand(every: int) -> None:
    """Look, command, hold the command for so many steps, integrate the own state with the last look: equal bit for bit.

    Kills: a command of every step, a look that comes a step late, a first command of zero, an own state that stands still or sees
    the present motion, a target or a time that is not held with the motion.
    """
    closed, drawn = scene(0)
    y = flight.begin(closed, (), drawn).y
    look: Any = None
    command: Any = None
    for k in range(STEPS):
        if k % every == 0:
            alpha_t = closed_loop.alpha(y.target, drawn.plant)
            look = closed_loop.measurement(k * drawn.context.step_s, y.motion, y.target, alpha_t, drawn)
            command = respond(look, y.control, None, drawn.gains).command

        def held(
            measurement: Measurement, memory: Vector, saturate: Any, gains: Numbers, look: Any = look, command: Any = command
        ) -> Response:
            return respond(look, memory, saturate, gains)._replace(command=command)

        stepping = closed._replace(controller=Controller(LAW.start, held))
        carry = flight.begin(stepping, (), drawn)._replace(y=y)
        y = flight.step(partial(closed_loop.evaluate, stepping), (), drawn, carry, k).y
    jax.tree.map(np.testing.assert_array_equal, y, flown(every)[1])


def test_a_command_stands_between_two_instants() -> None:
    """Within a step and from step to step; a new one at every instant. Kills: a command of the present motion within a step."""
    commands, _ = flown(3)
    for k, (first, later) in enumerate(commands):
        np.testing.assert_array_equal(first, later)
        assert (first == commands[k - k % 3][0]).all()
        assert k == 0 or k % 3 or (first != commands[k - 1][0]).any()


def test_a_period_of_one_step_is_not_continuous_control() -> None:
    """They part by the order of a step, with a longer period further. Kills: a period of one step that is flown continuously."""
    last = [flown(every)[1].motion for every in (0, 1, 4)]
    apart = [float(np.linalg.norm(array(motion.rho) - array(last[0].rho))) for motion in last[1:]]
    assert 0.0 < apart[0] < apart[1] < 0.1


def test_where_a_flight_is_interrupted_changes_nothing_of_what_is_held() -> None:
    """PD+ every three steps behind noise, drift and delay, pushed by noise and a table: in one go and every 7 steps the same
    state and the same memories, bit for bit.

    Kills: noise that depends on where a stretch begins, an instant that is counted from the interruption.
    """
    navigation = [built("navigation", use, flights.LANES) for use in ("noise", "gyro-drift", "delay")]
    pushes = [built("disturbances", use, flights.LANES) for use in ("ornstein-uhlenbeck", "table")]
    closed = flights.loop("pd-plus")._replace(
        sampling=3, navigation=tuple(own for own, _ in navigation), disturbances=tuple(own for own, _ in pushes)
    )
    drawn = flights.draw(flights.gains("pd-plus"), 2.0, 0.05, onset_s=1.0)._replace(
        navigation=tuple(numbers for _, numbers in navigation), disturbances=tuple(numbers for _, numbers in pushes)
    )
    first = jax.vmap(partial(flight.begin, closed, ()))(drawn)
    evaluate = jax.jit(partial(closed_loop.evaluate, closed))
    advance = jax.jit(jax.vmap(partial(flight.advance, evaluate, ()), in_axes=(0, 0, None, None)))
    carry = first
    for k in range(0, 40, 7):
        carry = advance(drawn, carry, k, min(k + 7, 40))
    jax.tree.map(np.testing.assert_array_equal, carry, advance(drawn, first, 0, 40))
    assert np.isinf(carry.lost_s).all()
