"""What moves the numbers of arrays, and what holds further jaxprs: against JAX, and bit for bit against NumPy."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from rvjax.simulation.engines.llvm import control
from rvjax.simulation.engines.llvm.from_jaxpr import scalarised
from rvjax.simulation.engines.llvm.program import UnsupportedError, walk
from tests.engines.machine import Array, machine
from tests.oracles.interpreter import interpreted

lax = jax.lax
Function = Callable[[Any, Any], Any]


def integer(x: Any) -> Any:
    """An index that differs from sample to sample, sometimes outside of an array of three."""
    return lax.convert_element_type(jnp.floor(3.0 * x), jnp.int32)


def looped(a: Any, b: Any) -> Any:
    """Every lane its number of iterations."""
    return lax.while_loop(lambda s: s[0] < 5.0 * b[0] * b[0], lambda s: (s[0] + 1.0, s[1] * 1.5 + a[0, 0]), (0.0, 1.0))


MOVES: dict[str, Function] = {
    "reshape": lambda a, b: a.reshape(9)[::-1],
    "broadcast": lambda a, b: a + b,
    "transpose": lambda a, b: a.T - a,
    "slice": lambda a, b: a[1:, ::2],
    "concatenate": lambda a, b: jnp.concatenate([a, b[None]], axis=0),
    "stack": lambda a, b: jnp.stack([b, a[0], a[:, 1]], axis=1),
    "unstack": lambda a, b: jnp.unstack(a, axis=1)[2],
    "tile": lambda a, b: jnp.tile(b, 3),
    "pad": lambda a, b: lax.pad(a, jnp.asarray(7.0, a.dtype), ((1, 2, 1), (-1, 0, 0))),
    "iota": lambda a, b: b * jnp.arange(3),
    "constants": lambda a, b: b + jnp.asarray(0.1, a.dtype) * jnp.asarray(0.3, a.dtype),
    "split": lambda a, b: jnp.split(a.reshape(9), [2, 5])[1],
    "argmax": lambda a, b: (jnp.argmax(b), jnp.argmin(a), jnp.argmax(a, axis=1)),
    "argmax of NaN": lambda a, b: (jnp.argmax(jnp.sqrt(b)), jnp.argmin(jnp.sqrt(b))),
    "dynamic slice": lambda a, b: lax.dynamic_slice(a, (integer(b[0]), integer(b[1])), (2, 1)),
    "dynamic update": lambda a, b: lax.dynamic_update_slice(a, b[None, :2], (integer(b[0]), integer(b[1]))),
    "gather": lambda a, b: a[jnp.clip(integer(b[0]), 0, 2)],
    "gather outside": lambda a, b: b.at[integer(b[0])].get(mode="fill"),
    "gather rows": lambda a, b: a[jnp.array([2, 0]), jnp.array([1, 1])],
    "gather from constants": lambda a, b: jnp.arange(50.0)[jnp.clip(integer(b[0]) + 20, 0, 49)],
    "gather of truth values": lambda a, b: (jnp.arange(50) % 3 == 0)[jnp.clip(integer(b[0]) + 20, 0, 49)],
    "gather from many": lambda a, b: jnp.concatenate([a.reshape(9)] * 3)[jnp.clip(integer(b[2]) + 9, 0, 26)],
    "scatter": lambda a, b: a.at[1, 2].set(b[0]).at[integer(b[1]), 0].set(5.0, mode="drop"),
    "scatter add": lambda a, b: a.at[integer(b[1])].add(b),
    "scatter in turn": lambda a, b: b.at[jnp.array([0, 0, 2])].multiply(a[0]),
    "choice of samples": lambda a, b: lax.cond(b[0] > 0.0, lambda x: x * 2.0, lambda x: x[::-1], b),
    "choice of three": lambda a, b: lax.switch(integer(b[0]), [lambda x: x, lambda x: -x, lambda x: x * 0.5], b),
    "rows in turn": lambda a, b: lax.scan(lambda s, row: (s * 0.5 + row[0], s), b[0], a),
    "rows in reverse": lambda a, b: lax.scan(lambda s, row: (s * 0.5 + row[0], s), b[0], a, reverse=True),
    "function": lambda a, b: jax.checkpoint(lambda x: x + 1.0)(b),
}
"""What gives the numbers of JAX to the last bit."""

SUMS: dict[str, Function] = {
    "sum": lambda a, b: (jnp.sum(a), jnp.sum(a, axis=0), jnp.prod(b), jnp.max(a, axis=1), jnp.min(b)),
    "all and any": lambda a, b: (jnp.all(b > 0.0), jnp.any(a > 1.0)),
    "running sums": lambda a, b: (jnp.cumsum(a, axis=1), jnp.cumprod(b), lax.cummax(b, reverse=True)),
    "matrix and vector": lambda a, b: a @ b,
    "matrices": lambda a, b: jnp.einsum("ij,kj->ik", a, a) @ a,
    "outer product": jnp.tensordot,
    "while": looped,
    "cross product": lambda a, b: jnp.cross(a[0], b),
    "norm": lambda a, b: jnp.linalg.norm(a @ b),
    "interpolation": lambda a, b: jnp.interp(b[0], jnp.linspace(-3.0, 3.0, 40), jnp.arange(40.0) ** 2),
    "long loop": lambda a, b: lax.fori_loop(0, 5000, lambda i, x: x * 0.999 + i * b[1], b[2]),
    "long loop over rows": lambda a, b: lax.scan(lambda s, x: (s * 0.9 + x * b[0], None), b[1], jnp.sqrt(jnp.arange(3000.0)))[0],
}
"""Sums of products, in another order than JAX's."""

SUMS["outer product"] = lambda a, b: jnp.tensordot(b, b, axes=0)


@pytest.fixture(autouse=True)
def double() -> Any:
    """Double precision."""
    with jax.enable_x64(True):
        yield


def samples() -> tuple[Array, Array]:
    """(a matrix, a vector) of each sample."""
    chance = np.random.default_rng(5)
    return chance.normal(size=(37, 3, 3)), chance.normal(size=(37, 3))


def flown(functions: dict[str, Function]) -> tuple[list[Array], list[Array]]:
    """The results of all functions, by the engine and by JAX; XLA crashes at some of them together."""
    given = samples()
    ours = machine(lambda a, b: [each(a, b) for each in functions.values()], *given)
    theirs = [jax.jit(jax.vmap(each))(*given) for each in functions.values()]
    return ours, [np.asarray(x) for x in jax.tree.leaves(theirs)]


@pytest.mark.parametrize("name", MOVES)
def test_moved_numbers_are_those_of_jax(name: str) -> None:
    """Kills: a transposed axis, an index off by one, an index outside that is not moved or dropped."""
    ours, theirs = flown({name: MOVES[name]})
    assert all(np.array_equal(a, b, equal_nan=True) for a, b in zip(ours, theirs, strict=True))


def test_sums_are_those_of_jax_to_rounding() -> None:
    """Kills: a term that is missing, a product of the wrong axes, iterations of another lane."""
    ours, theirs = flown(SUMS)
    for a, b in zip(ours, theirs, strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-12, atol=1e-12)


def test_sums_take_their_terms_in_turn() -> None:
    """Bit for bit as written out. Kills: another order of the terms, a fused multiplication and addition."""
    exact = {name: SUMS[name] for name in ("while", "matrix and vector", "matrices", "cross product", "norm", "long loop")}
    given = samples()
    for name, function in exact.items():
        expected = jax.tree.leaves(interpreted(function, {}, *given))
        assert all(np.array_equal(a, b) for a, b in zip(machine(function, *given), expected, strict=True)), name


def test_the_first_of_equal_extremes_is_found() -> None:
    """As in JAX and NumPy. Kills: the last of them."""
    given = np.array([[1.0, 3.0, 3.0], [2.0, 2.0, 2.0], [0.0, -0.0, 1.0]])
    places = machine(lambda x: (jnp.argmax(x), jnp.argmin(x)), given)
    assert np.array_equal(places, [np.argmax(given, axis=1), np.argmin(given, axis=1)])


@pytest.mark.parametrize("lanes", [2, 4, 16])
def test_the_number_of_lanes_changes_no_bit(lanes: int) -> None:
    """37 samples in groups of 2, 4, 8 and 16. Kills: a loop that ends with the first lane, memory of another lane."""
    functions = {
        name: (MOVES | SUMS)[name] for name in ("while", "gather from many", "gather from constants", "long loop over rows")
    }
    function = lambda a, b: [each(a, b) for each in functions.values()]  # noqa: E731
    given = samples()
    assert all(
        np.array_equal(a, b) for a, b in zip(machine(function, *given), machine(function, *given, lanes=lanes), strict=True)
    )


def test_what_is_the_same_in_all_lanes_is_a_branch() -> None:
    """A choice by the number of the step computes one side only; a choice by a sample both. Kills: a controller that is updated
    at every step, to be thrown away."""

    def stepped(x: Any, k: Any) -> Any:
        return lax.cond(k % 3 == 0, lambda x: x * 2.0, lambda x: x + 1.0, x)

    number = jax.ShapeDtypeStruct((), jnp.float64)
    program, _ = scalarised(stepped, number, jax.ShapeDtypeStruct((), jnp.int32))
    assert [operation.code for operation in walk(program.body)].count("branch") == 1
    program, _ = scalarised(lambda x: lax.cond(x > 0.0, lambda x: x * 2.0, lambda x: x + 1.0, x), number, step=False)
    assert "branch" not in [operation.code for operation in walk(program.body)]


def test_a_short_loop_is_unrolled(monkeypatch: pytest.MonkeyPatch) -> None:
    """To the same bits. Kills: a loop whose last iteration is missing."""
    given = samples()

    def function(a: Any, b: Any) -> Any:
        return lax.fori_loop(0, 7, lambda i, x: x * b[0] + i, b[1])

    (unrolled,) = machine(function, *given)
    monkeypatch.setattr(control, "UNROLLED", 0)
    (looped,) = machine(function, *given)
    assert np.array_equal(unrolled, looped)


@pytest.mark.parametrize(("function", "words"), [(jnp.sort, "`sort`"), (jnp.linalg.inv, "`lu`"), (jnp.fft.fft, "`fft`")])
def test_an_unknown_primitive_is_named(function: Callable[..., Any], words: str) -> None:
    """Kills: a flight without it."""
    with pytest.raises(UnsupportedError, match=words):
        scalarised(function, jax.ShapeDtypeStruct((3, 3), jnp.float64), step=False)
