"""Actuators against closed forms and against pulses that are counted one by one."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rvjax.components.actuators.interface import Limits
from rvjax.components.registry import component
from rvjax.execution.replay import replay
from rvjax.execution.run import run
from rvjax.physics.state import Numbers, Tick
from rvjax.physics.vectors import Channels
from rvjax.simulation.problem import load
from tests.short import CAMPAIGN, SHORT

Array = np.ndarray[Any, Any]
UPPER, LOWER = np.array([4.0, 4.0, 4.0, 0.8, 0.8, 0.8]), np.array([3.0, 3.0, 3.0, 0.6, 0.6, 0.6])
LIMITS = Limits(Channels.of(tuple(UPPER)), Channels.of(tuple(LOWER)))
H = 0.05


def driven(name: str, numbers: dict[str, float], commands: Array, inside: float = 1.0) -> Array:
    """(steps, 6) outputs at t_k + inside · h, for a command (steps, 6) that is constant during each step."""
    actuator = component("actuators", name).build(None)
    given = Numbers(numbers)
    memory = actuator.start(Channels.of((0.0,) * 6), given)
    outputs = []
    for k, command in enumerate(commands):
        u = Channels.of(tuple(command))
        last = Channels.of(tuple(commands[max(k - 1, 0)]))
        held = last if name in ("first-order-lag", "rate-limit") else u  # their memory is the end of the step before
        memory = actuator.keep(Tick(k, k * H, H), held, memory, LIMITS, given)
        outputs.append([float(x) for x in actuator.act((k + inside) * H, u, memory, LIMITS, given).parts()])
    return np.array(outputs)


def test_the_lag_is_an_exponential() -> None:
    """1 − e^{−t/T} after a step, whatever the length of the steps. Kills: Euler's step, a time constant squared."""
    outputs = driven("first-order-lag", {"time_constant_s": 0.3}, np.tile(UPPER / 2.0, (40, 1)))
    t = np.arange(1, 41)[:, None] * H
    np.testing.assert_allclose(outputs, UPPER / 2.0 * (1.0 - np.exp(-t / 0.3)), rtol=1e-12, atol=1e-15)


def test_the_rate_is_limited() -> None:
    """A ramp of r u_max until the command is reached, and back. Kills: a limit in absolute units, an overshoot."""
    up = driven("rate-limit", {"rate": 0.5}, np.vstack([np.tile(UPPER / 2.0, (30, 1)), np.tile(-LOWER / 4.0, (30, 1))]))
    t = np.arange(1, 31)[:, None] * H
    np.testing.assert_allclose(up[:30], np.minimum(0.5 * UPPER * t, UPPER / 2.0), rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(up[30:], np.maximum(UPPER / 2.0 - 0.5 * UPPER * t, -LOWER / 4.0), rtol=1e-12, atol=1e-15)


def test_quantisation_gives_multiples() -> None:
    """Multiples of q u_max, the nearest. Kills: a floor, a step of the lower limit."""
    commands = np.random.default_rng(1).uniform(-1.0, 1.0, (50, 6)) * UPPER
    actuator = component("actuators", "quantisation").build(None)
    given = np.array([
        [float(x) for x in actuator.act(0.0, Channels.of(tuple(c)), (), LIMITS, Numbers({"step": 0.1})).parts()] for c in commands
    ])  # fmt: skip
    multiples = given / (0.1 * UPPER)
    np.testing.assert_allclose(multiples, np.round(multiples), atol=1e-12)
    assert np.all(np.abs(given - commands) <= 0.05 * UPPER * (1.0 + 1e-12))


@pytest.mark.parametrize(("period", "shortest"), [(0.5, 0.0), (0.5, 0.06), (0.33, 0.04)])
def test_pulses_have_the_impulse_of_their_command(period: float, shortest: float) -> None:
    """Each period's impulse is T_on u_max on the side of the command at its beginning, T_on counted in continuous time. The
    command changes in every step. Kills: a command read later than at the beginning, a pulse that is cut to whole steps, a dead
    zone at one end only, the upper limit for a negative pulse."""
    steps = 200
    commands = np.random.default_rng(2).uniform(-1.1, 1.1, (steps, 6)) * np.where(np.arange(6) % 2, UPPER, LOWER)
    outputs = driven("pulse-width", {"period_s": period, "shortest_s": shortest}, commands, inside=0.5)
    begins = [0]
    for k in range(steps):
        if np.floor(k * H / period + 1e-6) > np.floor(begins[-1] * H / period + 1e-6):
            begins.append(k)
    for first, last in pairwise(begins):
        start = np.floor(first * H / period + 1e-6) * period
        for channel in range(6):
            h = commands[first, channel]
            limit = UPPER[channel] if h >= 0.0 else LOWER[channel]
            on = period * min(abs(h) / limit, 1.0)
            on = 0.0 if on < shortest else period if period - on < shortest else on
            inside = max(min(start + on, last * H) - first * H, 0.0)
            np.testing.assert_allclose(outputs[first:last, channel].sum() * H, np.sign(h) * limit * inside, atol=1e-9)


PULSES = "{use: pulse-width, period_s: 0.5, shortest_s: {uniform: [0.02, 0.04]}}"
CHAIN = f"actuation=[{{use: rate-limit, rate: {{uniform: [1, 2]}}}}, {PULSES}]"


@pytest.mark.usefixtures("bare")
@pytest.mark.parametrize("actuators", [(), ("actuators={use: thrusters, layout: cube-24, size_m: 1, max_N: 3}",)])
def test_a_campaign_flies_them(tmp_path: Path, actuators: tuple[str, ...]) -> None:
    """On channels, and on thrusters; the draws act. The output is a pulse or nothing. Kills: actuators behind the faults or left
    out, a pulse that follows the command within its period."""
    sets = [*SHORT, "controller={use: pd-plus}", CHAIN, "samples=8", "faults=[]", "horizon.step_s=0.05", *actuators]
    problem = load(CAMPAIGN, sets)
    assert len(problem.loop.actuation) == 2
    if actuators:
        return
    trace, _, _ = replay(run(CAMPAIGN, tmp_path / "run", sets, progress=False), 1)
    applied = trace["applied_fx"].to_numpy()
    size = np.max(np.abs(applied))
    full = [0.0, applied.min(), applied.max()]
    share = np.mean(np.min(np.abs(applied[:, None] - full), axis=1) < 1e-9)
    assert size > 2.5
    assert share > 0.85, "a tenth of the steps holds the end of a pulse"
