"""Every fault: nothing before its onset and after its end, bit for bit; the value it is known for while it acts."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from rvjax.components.faults.interface import Fault, FaultParameters
from rvjax.components.registry import component, members
from rvjax.physics.state import Numbers, Tick
from rvjax.physics.vectors import Channels
from tests.parameters import example

Array = NDArray[np.float64]

H = 0.125
STEPS = 48
UPPER = Channels.of((4.0, 4.0, 4.0, 0.8, 0.8, 0.8))

OWN: dict[str, dict[str, Any]] = {
    "effectiveness": {"remaining": 0.25},
    "incipient": {"loss": 0.6, "growth": 0.5},
    "bias": {"share": 0.1},
    "drift": {"growth": 0.02, "most": 0.05},
    "stuck": {},
    "float": {},
    "reversed": {"remaining": 0.75},
    "lag": {"time_constant_s": 0.7},
    "delay": {"steps": 3},
}
"""What a campaign says of the faults whose values are checked below; any other one is built from an example of its model."""


def channels(value: Any) -> Channels:
    """One number for every channel, or six."""
    return Channels.of(tuple(np.broadcast_to(np.asarray(value, dtype=float), 6)))


def built(use: str, **said: Any) -> tuple[Fault, Numbers]:
    """A member with what a campaign says of it, and its numbers."""
    member = component("faults", use)
    values = OWN[use] if use in OWN else example("faults", use, drawn=False, apart=FaultParameters)
    parameters = member.parameters.model_validate({"onset_s": 1.0} | values | said)
    numbers = {name: channels([part.low for part in quantity.parts]) for name, quantity in parameters.quantities().items()}
    return member.build(parameters), Numbers(numbers)


_compiled: dict[tuple[Any, ...], Any] = {}
"""By member and form of its numbers: a flight is compiled once for all its values."""


def whole(fault: Fault, numbers: Numbers, command: Any) -> tuple[Any, Any]:
    """`flown`, of a fault and its numbers."""

    def step(memory: Any, now: tuple[Any, Any]) -> tuple[Any, tuple[Any, Any]]:
        k, row = now
        u = Channels.of(tuple(row))
        memory = fault.keep(Tick(k, k * H, H), u, memory, numbers)
        begun, middle = (jnp.stack(fault.act((k + part) * H, u, memory, UPPER, numbers).parts()) for part in (0.0, 0.5))
        return memory, (begun, middle)

    start = jax.tree.map(lambda x: jnp.asarray(x, float), fault.start(channels(0.0), numbers))
    return jax.lax.scan(step, start, (jnp.arange(len(command)), command))[1]


def flown(use: str, command: Array, onset: Any = 1.0, **said: Any) -> tuple[Array, Array]:
    """(steps, 6) what comes out at the beginning and in the middle of every step; command: (steps, 6), standing during a step."""
    fault, numbers = built(use, **said)
    numbers = Numbers({**numbers, "onset_s": channels(onset)})
    form = (use, said.get("steps"), *sorted(numbers))
    if form not in _compiled:
        _compiled[form] = jax.jit(partial(whole, fault))
    begun, middle = _compiled[form](numbers, command)
    return np.asarray(begun), np.asarray(middle)


def commanded(seed: int = 7) -> Array:
    """(steps, 6) a command that is another one at every step."""
    return np.random.default_rng(seed).uniform(-3.0, 4.0, (STEPS, 6))


TIMES = np.arange(STEPS)[:, None] * H
LIMIT = np.array(UPPER.parts())


@settings(max_examples=8, deadline=None)
@given(onset=st.lists(st.floats(0.0, 7.0, allow_subnormal=False), min_size=6, max_size=6), seed=st.integers(0, 1000))
@pytest.mark.parametrize("use", members("faults"))
def test_before_its_onset_a_fault_is_nothing(use: str, onset: list[float], seed: int) -> None:
    """Bit for bit, each channel by itself. Kills: `t > 0` for `t >= onset`, one onset for all channels, a blend in its place."""
    command = commanded(seed)
    for at, out in zip((TIMES, TIMES + 0.5 * H), flown(use, command, onset), strict=True):
        before = at < np.array(onset)
        np.testing.assert_array_equal(out[before], command[before])
        late = at > np.array(onset) + 1.0
        changed = (out != command)[late]
        assert changed.any() or not late.any()
        if use in OWN and use != "lag":  # which changes nothing where the command happens to stand
            assert changed.all()


@settings(max_examples=8, deadline=None)
@given(duration=st.floats(0.3, 3.0), onset=st.floats(0.0, 2.0, allow_subnormal=False))
@pytest.mark.parametrize("use", members("faults"))
def test_behind_its_end_a_fault_is_nothing(use: str, duration: float, onset: float) -> None:
    """Kills: a duration that is not read, an end that is counted from the start of the flight."""
    command = commanded()
    out, _ = flown(use, command, onset, duration_s=duration)
    over = (onset + duration <= TIMES)[:, 0]
    np.testing.assert_array_equal(out[over], command[over])
    acting = ((onset <= TIMES) & (onset + duration > TIMES))[:, 0]
    endless, _ = flown(use, command, onset, duration_s=1e6)
    np.testing.assert_array_equal(out[acting], endless[acting])


@settings(max_examples=20, deadline=None)
@given(period=st.integers(2, 12), duty=st.floats(0.05, 0.95), onset=st.integers(0, 8))
def test_an_intermittent_fault_acts_in_the_first_part_of_each_period(period: int, duty: float, onset: int) -> None:
    """Whole steps, so that the phase is exact. Kills: the duty of the sound part, a phase from the start of the flight."""
    assume(abs(period * duty - round(period * duty)) > 1e-9)  # an end between two steps, which rounding cannot move
    command = commanded()
    out, _ = flown("float", command, onset * H, period_s=period * H, duty=duty)
    steps = np.arange(STEPS) - onset
    acts = (steps >= 0) & (steps % period / period < duty)
    np.testing.assert_array_equal(out == 0.0, np.broadcast_to(acts[:, None], out.shape))


@pytest.mark.parametrize(
    ("use", "said", "expected"),
    [
        ("effectiveness", {}, lambda h, s: 0.25 * h),
        ("incipient", {}, lambda h, s: (1 - 0.6 * (1 - np.exp(-0.5 * s))) * h),
        ("bias", {}, lambda h, s: h + 0.1 * LIMIT),
        ("bias", {"share": -0.2}, lambda h, s: h - 0.2 * LIMIT),
        ("drift", {}, lambda h, s: h + np.minimum(0.02 * s, 0.05) * LIMIT),
        ("drift", {"growth": -0.02}, lambda h, s: h - np.minimum(0.02 * s, 0.05) * LIMIT),
        ("stuck", {"share": -0.5}, lambda h, s: np.broadcast_to(-0.5 * LIMIT, h.shape)),
        ("float", {}, lambda h, s: 0.0 * h),
        ("reversed", {}, lambda h, s: -0.75 * h),
    ],
)
def test_while_it_acts_a_fault_gives_what_it_is_known_for(use: str, said: Mapping[str, Any], expected: Any) -> None:
    """Kills: Δ for 1 − Δ, time from the start of the flight, a share of the commanded value, a cap on one side only, a
    reversal without its sign."""
    command = commanded()
    for at, out in zip((TIMES, TIMES + 0.5 * H), flown(use, command, **said), strict=True):
        acts = (at >= 1.0)[:, 0]
        np.testing.assert_allclose(out[acts], expected(command, at - 1.0)[acts], rtol=1e-13, atol=1e-15)


def test_an_incipient_fault_has_lost_63_percent_of_its_loss_after_one_time_constant() -> None:
    """1 − 1/e of Δ at t_f + 1/a. Kills: a growth that is a time constant."""
    out, _ = flown("incipient", np.ones((STEPS, 6)))
    assert out[int(3.0 / H), 0] == pytest.approx(1 - 0.6 * (1 - np.exp(-1.0)), abs=1e-14)


@pytest.mark.parametrize(("onset", "step"), [(1.0, 7), (1.0 + 0.4 * H, 8), (1.0 + 0.6 * H, 8)])
def test_a_channel_sticks_where_it_was_when_it_was_last_sound(onset: float, step: int) -> None:
    """Kills: the value of the step behind the onset, a memory that goes on, zero in its place."""
    command = commanded()
    out, middle = flown("stuck", command, onset)
    late = (onset <= TIMES)[:, 0]
    np.testing.assert_array_equal(out[late], np.broadcast_to(command[step], out[late].shape))
    np.testing.assert_array_equal(middle[late], out[late])


def test_a_stuck_channel_that_came_free_sticks_anew() -> None:
    """Every second step. Kills: the first value for good."""
    command = commanded()
    out, _ = flown("stuck", command, 1.0, period_s=2 * H, duty=0.5)
    for k in range(8, STEPS):
        np.testing.assert_array_equal(out[k], command[k - 1] if k % 2 == 0 else command[k])


def test_a_lag_follows_an_exponential_to_a_constant_command() -> None:
    """From the last sound value, exactly, also inside a step. Kills: Euler's method, τ for 1/τ, a start from zero."""
    command = np.where(TIMES < 1.0, 2.0, -1.0) * np.ones(6)
    for at, out in zip((TIMES, TIMES + 0.5 * H), flown("lag", command, 1.0 - 0.5 * H), strict=True):
        acts = (at >= 1.0)[:, 0]
        exact = -1.0 + 3.0 * np.exp(-(at - (1.0 - H)) / 0.7)
        np.testing.assert_allclose(out[acts], np.broadcast_to(exact, out.shape)[acts], rtol=1e-12)


@pytest.mark.parametrize("steps", [1, 3, 64])
def test_a_delay_gives_what_was_asked_for_so_many_steps_before(steps: int) -> None:
    """Before the flight nothing was asked for. Kills: one step more or less."""
    command = commanded()
    out, middle = flown("delay", command, 0.0, steps=steps)
    before = np.concatenate([np.zeros((steps, 6)), command])[:STEPS]
    np.testing.assert_array_equal(out, before)
    np.testing.assert_array_equal(middle, before)
