"""Noise inside a flight: the published generator, normal numbers, independence, and coloured noise as it is defined.

Statistical tests use exact distributions and are built so that a sound program fails each of them once in a million seeds; the
seeds are fixed, so it does not fail at random.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

from rvjax.components.disturbances.ornstein_uhlenbeck import keep, start
from rvjax.components.samplers.monte_carlo import MonteCarlo
from rvjax.physics.noise import normals, threefry
from rvjax.physics.state import Numbers, Tick
from rvjax.simulation.draws import Draws
from tests.members import array, built

Array = NDArray[np.float64]

FALSE_ALARM = 1e-6
"""Of each test, over all its comparisons (Bonferroni)."""


def key(samples: Any, name: str = "noise") -> tuple[Array, ...]:
    """The keys of samples."""
    chosen = np.asarray(samples)
    return Draws(MonteCarlo(7).at(chosen), chosen, 7).key(name)


def drawn(own: tuple[Array, ...], steps: Any, count: int) -> Array:
    """(samples, steps, count) normal numbers."""
    of_steps = jax.vmap(lambda one, k: normals(one, k, count), in_axes=(None, 0))
    return np.stack(jax.jit(jax.vmap(of_steps, in_axes=(0, None)))(own, jnp.asarray(steps)), axis=-1)


def bounds(tests: int) -> float:
    """The |z| that a normal number exceeds with the false-alarm rate in any of so many tests."""
    return float(stats.norm.isf(0.5 * FALSE_ALARM / tests))


def test_the_generator_is_the_published_one() -> None:
    """The three known answers of Random123 for threefry2x32-20. Kills: a wrong turn, a missing addition of the key."""
    for given, expected in (
        ((0x0, 0x0, 0x0, 0x0), (0x6B200159, 0x99BA4EFE)),
        ((0xFFFFFFFF,) * 4, (0x1CB996FC, 0xBB002BE7)),
        ((0x13198A2E, 0x03707344, 0x243F6A88, 0x85A308D3), (0xC4923A9C, 0x483DF7A0)),
    ):
        first, second, *counter = (jnp.uint32(word) for word in given)
        assert tuple(map(int, threefry((first, second), (counter[0], counter[1])))) == expected


def test_the_numbers_are_normal() -> None:
    """Kolmogorov and Smirnov over 480,000 numbers, and how many lie beyond 4; false alarm 1e-6.

    Kills: ln u without the factor 2, an angle of half a turn.
    """
    found = drawn(key(np.arange(800)), np.arange(100), 6).ravel()
    assert stats.kstest(found, "norm").pvalue >= 0.5 * FALSE_ALARM
    assert stats.binomtest(int((np.abs(found) > 4.0).sum()), found.size, 2.0 * stats.norm.sf(4.0)).pvalue >= 0.5 * FALSE_ALARM


def test_numbers_depend_on_nothing_of_each_other() -> None:
    """Components, steps, samples and components of other names are uncorrelated, and so are their squares: Σab/√Σa² is a standard
    normal number if b is independent of a; for squares to the order 1/√N. False alarm 1e-6.

    Kills: one word for two numbers, the component's number left out of the counter, one key for all samples or all components.
    """
    found = drawn(key(np.arange(64)), np.arange(500), 12)
    other = drawn(key(np.arange(64), "other"), np.arange(500), 12)
    pairs = [(found[..., i], found[..., j]) for i in range(12) for j in range(i)]
    pairs += [(found[:, :-lag, i], found[:, lag:, i]) for lag in (1, 2, 7) for i in range(12)]
    pairs += [(found[:-lag, :, i], found[lag:, :, i]) for lag in (1, 5) for i in range(12)]
    pairs += [(found[..., i], other[..., i]) for i in range(12)]
    pairs += [(a * a - 1.0, (b * b - 1.0) / np.sqrt(2.0)) for a, b in pairs]
    sizes = [abs(float((a * b).sum() / np.sqrt((a * a).sum()))) for a, b in pairs]
    assert max(sizes) <= bounds(len(pairs))


def test_they_are_those_of_box_and_muller() -> None:
    """By NumPy's functions, from the words of the published generator: to double precision, so that every compiler has the same
    noise. Kills: single precision, a word that is rounded to 24 bits."""
    a, b, c, d = (part.astype(np.uint32) for part in key(np.arange(64)))
    words = threefry((jnp.asarray((a << 16) | b), jnp.asarray((c << 16) | d)), (jnp.uint32(5), jnp.uint32(0)))
    first, second = (np.asarray(word, dtype=np.float64) for word in words)
    size, angle = np.sqrt(-2.0 * np.log((first + 0.5) / 2**32)), 2.0 * np.pi * second / 2**32
    expected = np.stack([size * np.cos(angle), size * np.sin(angle)], axis=-1)
    np.testing.assert_allclose(drawn(key(np.arange(64)), np.array([5]), 2)[:, 0], expected, rtol=0.0, atol=1e-14)


def test_noise_is_the_sample_s_own_wherever_it_flies() -> None:
    """Bit for bit in chunks of any composition and at any step alone; in another program, with fewer numbers drawn beside it, to
    the last digits; in float32 to those of single precision.

    Kills: a counter that is carried, noise by place in the chunk, another stream in float32, numbers that depend on the count.
    """
    found = drawn(key(np.arange(64)), np.arange(20), 6)
    some = np.array([40, 3, 3, 63, *range(20, 32)])
    np.testing.assert_array_equal(drawn(key(some), np.array([13, 2]), 6), found[some][:, [13, 2]])
    small = tuple(part.astype(np.float32) for part in key(np.arange(64)))
    np.testing.assert_allclose(drawn(small, np.arange(20), 6), found, atol=1e-5)  # most where u is near 1
    np.testing.assert_allclose(drawn(key(np.arange(64)), np.arange(20), 3), found[..., :3], atol=1e-14)


SAMPLES, H = 4_000, 0.5


def coloured(steps: Sequence[int], h: float = H) -> tuple[Array, Array, Array]:
    """(steps, samples, 6) coloured noise at some steps; (6,) its standard deviations and time constants."""
    _, numbers = built(
        "disturbances",
        "ornstein-uhlenbeck",
        SAMPLES,
        force_N=[0.1, 0.2, 3.0],
        torque_Nm=[0.01, 0.5, 0.02],
        time_constant_s=[0.7, 2.0, 5.0, 20.0, 100.0, 1.0],
    )

    def one(own: Numbers) -> Any:
        def step(memory: Any, k: Any) -> Any:
            now = keep(Tick(k, k * h, h), None, memory, own)  # where the flight is plays no part
            return now, now.parts()

        return jax.lax.scan(step, start(own), jnp.arange(max(steps) + 1))[1]

    rows = np.stack(jax.jit(jax.vmap(one))(numbers), axis=-1)
    first = jax.tree.map(lambda x: np.asarray(x)[0], numbers)
    sizes = np.array([*first.force_N.parts(), *first.torque_Nm.parts()])
    return rows[:, list(steps)].swapaxes(0, 1), sizes, array(first.time_constant_s)


@pytest.mark.parametrize("h", [0.5, 0.05])
def test_coloured_noise_has_its_variance_and_correlation(h: float) -> None:
    """At any two steps x, x': Σx²/s² and Σ(x' − ax)²/(s²(1−a²)) are χ² with N degrees of freedom, Σx(x' − ax)/(s √(1−a²) √Σx²) is
    a standard normal number, a = e^{−|t−t'|/τ}; exact, N = 4,000, false alarm 1e-6.

    Kills: a start at zero, √(1−a) for √(1−a²), Euler's 1 − h/τ, a time constant that is a rate, one for all channels, the draw of
    another step.
    """
    steps = [0, 1, 2, 3, 12, 30]
    found, sd, tau = coloured(steps, h)
    pairs = [(i, j) for i in range(len(steps)) for j in range(i)]
    tests = 6 * (len(steps) + 2 * len(pairs))
    low, high = stats.chi2.ppf([0.5 * FALSE_ALARM / tests, 1.0 - 0.5 * FALSE_ALARM / tests], SAMPLES)
    for row in found:
        energy = (row**2).sum(0) / sd**2
        assert ((low <= energy) & (energy <= high)).all()
    for later, earlier in pairs:
        a = np.exp(-(steps[later] - steps[earlier]) * h / tau)
        x, rest = found[earlier], (found[later] - a * found[earlier]) / (sd * np.sqrt(1.0 - a * a))
        energy = (rest**2).sum(0)
        assert ((low <= energy) & (energy <= high)).all(), (later, earlier)
        assert (np.abs((x * rest).sum(0) / np.sqrt((x**2).sum(0))) <= bounds(tests)).all(), (later, earlier)


def test_channels_of_coloured_noise_are_independent() -> None:
    """Σab/√Σa² s_b is a standard normal number for any two channels; false alarm 1e-6. Kills: one draw for all channels."""
    (found,), sd, _ = coloured([5])
    sizes = [
        abs((found[:, i] * found[:, j]).sum() / sd[j] / np.sqrt((found[:, i] ** 2).sum())) for i in range(6) for j in range(i)
    ]
    assert max(sizes) <= bounds(len(sizes))
