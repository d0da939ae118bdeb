"""Every row of the table primitive → instructions, on random and special numbers, against NumPy and against JAX.

A row is tried alone in a function of a single primitive. Each test runs a list of rows, because compiling takes longer than
flying. What a row computes must differ from what every other row computes: the numbers tell the rows apart.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from itertools import product
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from rvjax.simulation.engines.llvm.elementwise import ROWS
from tests.engines.machine import Array, machine, same

lax = jax.lax
EVEN, AWAY = lax.RoundingMethod.TO_NEAREST_EVEN, lax.RoundingMethod.AWAY_FROM_ZERO


class Case(NamedTuple):
    """row: of the table. function: of JAX, with this primitive alone. expected: the same by NumPy. operands: their kinds. jax:
    whether JAX must agree on the CPU, NaN and the sign of zero included."""

    row: str
    function: Callable[..., Any]
    expected: Callable[..., Any]
    operands: str = "r"
    jax: bool = True


def whole(x: Any) -> Any:
    """A number as an integer of 32 bits."""
    return lax.convert_element_type(x, jnp.int32)


def unsigned(x: Any) -> Any:
    """A number as an unsigned integer of 32 bits."""
    return lax.convert_element_type(x, jnp.uint32)


def of_integers(function: Callable[..., Any]) -> Callable[..., Any]:
    """The function of integers that are given as reals."""
    return lambda *operands: function(*map(whole, operands))


def i32(x: Array) -> Array:
    """The same in NumPy."""
    return x.astype(np.int64).astype(np.int32)


def u32(x: Array) -> Array:
    """The same in NumPy, unsigned."""
    return x.astype(np.int64).astype(np.uint32)


def signed(operation: Callable[..., Any]) -> Callable[..., Any]:
    """An operation of NumPy on integers that are given as reals."""
    return lambda *operands: operation(*map(i32, operands))


def maximum(a: Array, b: Array) -> Array:
    """NaN where one is NaN; the second of equal operands."""
    return np.where(np.isnan(a), a, np.where(a > b, a, b))


def minimum(a: Array, b: Array) -> Array:
    """NaN where one is NaN; the second of equal operands."""
    return np.where(np.isnan(a), a, np.where(a < b, a, b))


def away(x: Array) -> Array:
    """The nearest whole number, halves away from zero."""
    part = np.abs(x) - np.floor(np.abs(x))
    return np.copysign(np.where(np.isfinite(x), np.floor(np.abs(x)) + (part >= 0.5), np.abs(x)), x)


def truncated(a: Array, b: Array) -> Array:
    """a/b towards zero."""
    quotient = np.abs(a.astype(np.int64)) // np.where(b == 0, 1, np.abs(b.astype(np.int64)))
    return np.where(b == 0, -1, np.where((a < 0) != (b < 0), -quotient, quotient)).astype(np.int32)


def rest(a: Array, b: Array) -> Array:
    """a − b trunc(a/b)."""
    return np.where(b == 0, a, a - b.astype(np.int64) * truncated(a, b)).astype(np.int32)


CASES = (
    Case("add", lax.add, np.add, "rr"),
    Case("sub", lax.sub, np.subtract, "rr"),
    Case("mul", lax.mul, np.multiply, "rr"),
    Case("div", lax.div, np.divide, "rr"),
    Case("max", lax.max, maximum, "rr", jax=False),  # the sign of max(0, −0) is that of XLA's processor
    Case("min", lax.min, minimum, "rr", jax=False),
    Case("neg", lax.neg, np.negative),
    Case("abs", lax.abs, np.abs),
    Case("sign", lax.sign, lambda x: np.where(np.isnan(x) | (x == 0), x, np.copysign(1.0, x))),
    Case("sqrt", lax.sqrt, np.sqrt),
    Case("square", lax.square, lambda x: x * x),
    Case("integer_pow", lambda x: lax.integer_pow(x, 7), lambda x: (x * (x * x)) * ((x * x) * (x * x))),
    Case("integer_pow", lambda x: lax.integer_pow(x, -3), lambda x: 1 / (x * (x * x))),
    Case("integer_pow", lambda x: lax.integer_pow(x, 0), np.ones_like),
    Case("floor", lax.floor, np.floor),
    Case("ceil", lax.ceil, np.ceil),
    Case("round", lambda x: lax.round(x, EVEN), np.rint),
    Case("round", lambda x: lax.round(x, AWAY), away),
    Case("clamp", lambda x, y: lax.clamp(lax.sub(y, 1.0), x, y), lambda x, y: minimum(maximum(x, y - 1), y), "rr", jax=False),
    Case("is_finite", lax.is_finite, np.isfinite),
    Case("eq", lax.eq, np.equal, "rr"),
    Case("ne", lax.ne, np.not_equal, "rr"),
    Case("lt", lax.lt, np.less, "rr"),
    Case("le", lax.le, np.less_equal, "rr"),
    Case("gt", lax.gt, np.greater, "rr"),
    Case("ge", lax.ge, np.greater_equal, "rr"),
    Case("select_n", lambda x, y: lax.select_n(lax.lt(x, y), x, y), lambda x, y: np.where(x < y, y, x), "rr"),
    Case(
        "select_n",
        lambda x, y: lax.select_n(lax.clamp(np.int32(0), whole(x), np.int32(2)), x, y, lax.add(x, y)),
        lambda x, y: np.choose(np.clip(i32(np.nan_to_num(x, posinf=3, neginf=-3)), 0, 2), [x, y, x + y]),
        "ir",
    ),
    Case("rem", lax.rem, np.fmod, "rr"),
    Case("convert_element_type", whole, i32, "i"),
    Case("convert_element_type", unsigned, u32, "n"),
    Case("convert_element_type", lambda x: lax.convert_element_type(x, jnp.float32), np.float32),
    Case("convert_element_type", lambda x: lax.convert_element_type(x, jnp.bool_), lambda x: x != 0),
    Case("convert_element_type", lambda x: lax.convert_element_type(lax.gt(x, 0.0), x.dtype), lambda x: x > 0),
    Case("add", of_integers(lax.add), signed(np.add), "ii"),
    Case("sub", of_integers(lax.sub), signed(np.subtract), "ii"),
    Case("mul", of_integers(lax.mul), signed(np.multiply), "ii"),
    Case("div", of_integers(lax.div), signed(truncated), "ii"),
    Case("rem", of_integers(lax.rem), signed(rest), "ii"),
    Case("neg", of_integers(lax.neg), signed(np.negative), "i"),
    Case("abs", of_integers(lax.abs), signed(np.abs), "i"),
    Case("sign", of_integers(lax.sign), signed(np.sign), "i"),
    Case("max", of_integers(lax.max), signed(np.maximum), "ii"),
    Case("min", of_integers(lax.min), signed(np.minimum), "ii"),
    Case("lt", of_integers(lax.lt), signed(np.less), "ii"),
    Case("gt", lambda x, y: lax.gt(unsigned(x), unsigned(y)), lambda x, y: u32(x) > u32(y), "nn"),
    Case("and", of_integers(lax.bitwise_and), signed(np.bitwise_and), "ii"),
    Case("or", of_integers(lax.bitwise_or), signed(np.bitwise_or), "ii"),
    Case("xor", of_integers(lax.bitwise_xor), signed(np.bitwise_xor), "ii"),
    Case("not", of_integers(lax.bitwise_not), signed(np.bitwise_not), "i"),
    Case("not", lambda x: lax.bitwise_not(lax.gt(x, 0.0)), lambda x: ~(x > 0)),
    Case("and", lambda x, y: lax.bitwise_and(lax.gt(x, 0.0), lax.gt(y, 0.0)), lambda x, y: (x > 0) & (y > 0), "rr"),
    Case("or", lambda x, y: lax.bitwise_or(lax.gt(x, 0.0), lax.gt(y, 0.0)), lambda x, y: (x > 0) | (y > 0), "rr"),
    Case("shift_left", lambda x: lax.shift_left(unsigned(x), np.uint32(13)), lambda x: u32(x) << np.uint32(13), "n"),
    Case(
        "shift_right_logical", lambda x: lax.shift_right_logical(unsigned(x), np.uint32(7)), lambda x: u32(x) >> np.uint32(7), "n"
    ),
    Case("shift_right_arithmetic", lambda x: lax.shift_right_arithmetic(whole(x), np.int32(5)), lambda x: i32(x) >> 5, "i"),
    Case(
        "shift_left",
        lambda x, y: lax.shift_left(unsigned(x), unsigned(lax.abs(y))),
        lambda x, y: np.where(np.abs(y) < 32, u32(x) << u32(np.minimum(np.abs(y), 31)), 0),
        "ns",
    ),
    Case(
        "shift_left",
        lambda x: lax.bitwise_or(lax.shift_left(unsigned(x), np.uint32(35)), lax.shift_left(unsigned(x), np.uint32(3))),
        lambda x: u32(x) << np.uint32(3),
        "n",
    ),
    Case("shift_right_arithmetic", lambda x: lax.shift_right_arithmetic(whole(x), np.int32(40)), lambda x: i32(x) >> 31, "i"),
    Case(
        "lt_to",
        lambda x, y: lax.lt_to_p.bind(x, y),
        lambda x, y: np.where(
            np.isnan(x) | np.isnan(y), ~np.isnan(x), (x < y) | ((x == 0) & (y == 0) & np.signbit(x) & ~np.signbit(y))
        ),
        "pp",
    ),
)


@cache
def numbers(kind: str, real: str) -> Array:
    """Random and special numbers. r: reals; i: integers of 32 bits; n: from 0 to 2³² − 1; s: small integers; p: reals without a
    negative NaN."""
    chance, dtype = np.random.default_rng(17), np.dtype(real)
    if kind in "rp":
        limits = np.finfo(dtype)
        special = [0.0, -0.0, 1.0, -1.0, 0.5, -0.5, 1.5, 2.5, -2.5, 3.0, np.inf, -np.inf, np.nan]
        special += [
            limits.tiny,
            -limits.tiny,
            limits.tiny * limits.eps,
            limits.tiny / 3,
            limits.max,
            -limits.max,
            2.0**31,
            -(2.0**33),
        ]
        spread = chance.normal(size=12) * 10.0 ** chance.uniform(-30, 30, 12)
        return np.array([*special, *chance.normal(size=12), *spread], dtype=dtype)
    if kind == "s":
        return np.arange(0, 40, 3).astype(dtype)
    digits = 24 if real == "float32" else 31
    top = 2**digits
    if kind == "n":
        top = 2**32 if real == "float64" else top
        return np.array([0, 1, 2, top // 2, top - 1, *chance.integers(0, top, 12)]).astype(dtype)
    return np.array([0, 1, -1, 2, 7, -8, top - 1, 1 - top, *chance.integers(-top, top, 12), *chance.integers(-9, 9, 6)]).astype(
        dtype
    )


def operands(case: Case, real: str) -> list[Array]:
    """Every pair of numbers, or every number."""
    columns = zip(*product(*(numbers(kind, real) for kind in case.operands)), strict=True)
    return [np.array(column, dtype=real) for column in columns]


def by_jax(function: Callable[..., Any], *given: Array) -> list[Array]:
    """By JAX's compiler."""
    return [np.asarray(x) for x in jax.jit(jax.vmap(function))(*given)]


def all_at_once(real: str, fly: Callable[..., list[Array]]) -> list[Array]:
    """The result of every case, from a single program for each kind of operands."""
    found: dict[int, Array] = {}
    for kinds in dict.fromkeys(case.operands for case in CASES):
        group = [index for index, case in enumerate(CASES) if case.operands == kinds]
        given = operands(CASES[group[0]], real)
        results = fly(lambda *x, group=group: [CASES[i].function(*x) for i in group], *given)
        found |= dict(zip(group, results, strict=True))
    return [found[index] for index in range(len(CASES))]


@pytest.fixture(scope="module", params=["float64", "float32"])
def flown(request: pytest.FixtureRequest) -> Any:
    """(type, the result of every case, the same by JAX)."""
    with jax.enable_x64(request.param == "float64"):
        yield request.param, all_at_once(request.param, machine), all_at_once(request.param, by_jax)


@pytest.mark.parametrize("index", range(len(CASES)), ids=[f"{i}-{case.row}" for i, case in enumerate(CASES)])
def test_a_row_is_that_of_numpy_and_jax(index: int, flown: Any) -> None:
    """Kills: another instruction, another comparison with NaN, another sign of zero, a subnormal number that becomes 0. JAX is
    compared without subnormal numbers, which it takes for 0."""
    real, results, of_jax = flown
    case, given = CASES[index], operands(CASES[index], real)
    with np.errstate(all="ignore"):
        expected = case.expected(*given)
    assert same(results[index], expected), [
        (*(x[i] for x in given), results[index][i], expected[i])
        for i in range(len(given[0]))
        if not same(results[index][i : i + 1], expected[i : i + 1])
    ][:5]
    tiny = np.finfo(real).tiny
    usual = np.all([(np.abs(x) >= tiny) | (x == 0) | ~np.isfinite(x) for x in (*given, np.asarray(expected, np.float64))], axis=0)
    if case.jax:
        assert same(results[index][usual], of_jax[index][usual])


def test_the_numbers_tell_the_rows_apart(flown: Any) -> None:
    """The result of a row fits no other row. Kills: a table with two rows exchanged, numbers on which two rows agree."""
    real, results, _ = flown
    for index, case in enumerate(CASES):
        with np.errstate(all="ignore"):
            expected = case.expected(*operands(case, real))
        others = [i for i, other in enumerate(CASES) if other.operands == case.operands and i != index]
        assert not [CASES[i].row for i in others if same(results[i], expected)], case.row


def test_every_row_has_a_case() -> None:
    """Kills: a row that nothing tries. Rows that are functions are tried in tests/physics, those without effect do nothing."""
    elsewhere = {name for name, row in ROWS.items() if "function.<locals>" in row.__qualname__ or row.__name__ == "_same"}
    assert ROWS.keys() - elsewhere - {"add_any", "bitcast_convert_type"} == {case.row for case in CASES}


@pytest.mark.parametrize("real", ["float64", "float32"])
def test_bits_go_there_and_back(real: str) -> None:
    """Sign, exponent and fraction of a float as an integer. Kills: a conversion of the value."""
    with jax.enable_x64(real == "float64"):
        integer = jnp.int64 if real == "float64" else jnp.int32
        given = numbers("r", real)

        def magnitude(x: Any) -> Any:
            bits = lax.bitcast_convert_type(x, integer)
            return lax.bitcast_convert_type(bits & np.iinfo(integer).max, x.dtype)

        (result,) = machine(magnitude, given)
    assert same(result, np.abs(given))
