"""Elementary functions against 40-digit arithmetic, in all digits that a number has."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import jax
import mpmath
import numpy as np
import pytest

from rvjax.physics import elementary
from tests.oracles.elementary_truth import SPECIAL_PAIRS, SPECIAL_VALUES, TRUTHS, arguments, pairs
from tests.oracles.jaxpr_numpy import evaluate, operations
from tests.oracles.last_place import errors

each_kind = pytest.mark.parametrize("kind", [np.float64, np.float32])
each_name = pytest.mark.parametrize("name", TRUTHS)
TWO: dict[str, Callable[[Any, Any], Any]] = {"power": mpmath.power, "atan2": mpmath.atan2}
each_two = pytest.mark.parametrize("name", TWO)
OPERATIONS = {
    "exp": (38, 28),
    "expm1": (43, 33),
    "tanh": (42, 34),
    "log": (46, 38),
    "log1p": (53, 45),
    "log2": (45, 37),
    "erf": (97, 65),
    "exp2": (34, 24),
    "sinh": (63, 47),
    "cosh": (42, 32),
    "tan": (80, 76),
    "atan": (49, 35),
    "asin": (44, 30),
    "acos": (52, 38),
    "asinh": (67, 59),
    "acosh": (66, 58),
    "atanh": (60, 52),
    "cbrt": (64, 56),
    "power": (175, 157),
    "atan2": (66, 52),
}
"""Operations of each, (float64, float32)."""

IN_FLIGHTS = ("exp", "expm1", "tanh", "log", "log1p", "erf", "atan")


@pytest.fixture(autouse=True)
def digits() -> Any:
    """40 digits."""
    with mpmath.workdps(40):
        yield


def check(name: str, kind: type[np.floating[Any]], count: int) -> None:
    """The function is within two units in the last place at `count` numbers, or pairs, of each set of arguments."""
    given = pairs(name, kind, count) if name in TWO else (arguments(TRUTHS[name], kind, count),)
    exact = TWO[name] if name in TWO else TRUTHS[name].exact
    found = evaluate(getattr(elementary, name), *given)
    assert found.dtype == kind
    error = errors(found, [exact(*(mpmath.mpf(float(x)) for x in row)) for row in zip(*given, strict=True)])
    worst = [float(x[np.argmax(error)]) for x in given]
    assert error.max() <= 2.0, f"{name}: {error.max():.3g} units in the last place at {worst}"
    print(f"{name} {kind.__name__} {error.max():.2f}")


def check_special(name: str, kind: type[np.floating[Any]], rows: Sequence[Sequence[float]]) -> None:
    """Arguments and result, the sign of zero included. rows: (argument, …, result)."""
    *given, wanted = (np.array(column, dtype=kind) for column in zip(*rows, strict=True))
    found = evaluate(getattr(elementary, name), *given)
    np.testing.assert_array_equal(found, wanted)
    numbers = ~np.isnan(wanted)
    np.testing.assert_array_equal(np.signbit(found[numbers]), np.signbit(wanted[numbers]))


@each_kind
@each_name
def test_every_digit_is_there(name: str, kind: type[np.floating[Any]]) -> None:
    """Within 2 units in the last place, subnormal numbers included. Kills a changed coefficient, a swapped branch."""
    check(name, kind, 250)


@each_kind
@each_name
def test_every_digit_is_there_at_many_numbers(name: str, kind: type[np.floating[Any]]) -> None:
    """The same at 20000 numbers of each set: `pytest -s --slow -k many_numbers` prints the errors of the docstrings."""
    check(name, kind, 20000)


@each_kind
@each_two
def test_every_digit_of_two_arguments_is_there(name: str, kind: type[np.floating[Any]]) -> None:
    """Within 2 units in the last place. Kills a lost rest of the logarithm, a wrong octant."""
    check(name, kind, 250)


@each_kind
@each_two
def test_every_digit_of_two_arguments_is_there_at_many_numbers(name: str, kind: type[np.floating[Any]]) -> None:
    """The same at 20000 pairs of each set."""
    check(name, kind, 20000)


@each_kind
@each_two
def test_special_pairs(name: str, kind: type[np.floating[Any]]) -> None:
    """NaN, ±∞ and ±0 as C99 has them. Kills a lost sign of zero, a wrong octant, a number for NaN."""
    check_special(name, kind, [row for function, *row in SPECIAL_PAIRS if function == name])


@each_two
def test_derivatives_of_two_arguments(name: str) -> None:
    """Both first derivatives and all second ones against mpmath; arguments of different shapes and types meet as in jnp."""
    function, exact = getattr(elementary, name), TWO[name]
    for x, y in ((0.7, 1.3), (2.5, -0.4)):
        for order in ((1, 0), (0, 1), (2, 0), (1, 1), (0, 2)):
            derived = function
            for argument, times in enumerate(order):
                for _ in range(times):
                    derived = jax.grad(derived, argument)
            wanted = float(mpmath.diff(exact, (mpmath.mpf(x), mpmath.mpf(y)), order))
            assert float(derived(x, y)) == pytest.approx(wanted, rel=1e-12, abs=1e-13)
    assert jax.eval_shape(function, np.ones((3, 1), np.float32), np.ones(2, np.float32)).shape == (3, 2)
    assert jax.eval_shape(lambda x: function(x, 2.5), np.ones(2, np.float32)).dtype == np.float32


def test_negative_numbers_have_slopes_of_whole_powers() -> None:
    """∂x^y/∂x = y x^(y−1) for x < 0 and at y = 0. Kills NaN from the logarithm of x, which is not asked for."""
    slope = jax.vmap(jax.grad(elementary.power), (0, 0))
    x, y = np.array([-2.0, -3.0, 0.0, 2.0]), np.array([3.0, -2.0, 2.0, 0.0])
    np.testing.assert_allclose(slope(x, y), [12.0, 2.0 / 27.0, 0.0, 0.0], rtol=1e-15)


@each_kind
def test_whole_powers_are_those_of_lax(kind: type[np.floating[Any]]) -> None:
    """Every bit of jax.lax.integer_pow, for any exponent; their slopes too. Kills another order of the products."""
    x = np.random.default_rng(3).uniform(0.3, 3.0, 200).astype(kind) * np.where(np.arange(200) % 2, 1, -1).astype(kind)
    for n in (-7, -2, -1, 0, 1, 2, 3, 5, 6, 7, 13, 30):
        ours = evaluate(lambda v, n=n: elementary.integer_power(v, n), x)
        np.testing.assert_array_equal(ours, jax.lax.integer_pow(x, n))
    for n in (-2, 0, 1, 5):
        found = jax.vmap(jax.grad(lambda v, n=n: elementary.integer_power(v, n)))(np.array([-1.5, 0.5, 2.0]))
        np.testing.assert_allclose(found, n * np.array([-1.5, 0.5, 2.0]) ** (n - 1.0), rtol=1e-15)


@each_kind
@each_name
def test_special_values(name: str, kind: type[np.floating[Any]]) -> None:
    """NaN, ±∞ and ±0 as C99 has them. Kills a lost sign of zero, a finite number for ∞, a number for NaN."""
    check_special(name, kind, [*(row for function, *row in SPECIAL_VALUES if function == name), (np.nan, np.nan)])
    payload = np.array([np.nan], kind).view(np.int64 if kind is np.float64 else np.int32) + 12345
    assert np.isnan(evaluate(getattr(elementary, name), payload.view(kind))).all()


@each_name
def test_derivatives_are_those_of_the_function(name: str) -> None:
    """First and second ones, in forward and reverse mode, under jit and vmap. Kills a wrong formula, a derivative of the bits."""
    truth, function = TRUTHS[name], getattr(elementary, name)
    low, high = max(truth.inside[0], -3.0) + 0.1, min(truth.inside[1], 3.0) - 0.1
    x = np.linspace(low, high, 12)
    first, second = (np.array([float(mpmath.diff(truth.exact, mpmath.mpf(float(v)), n)) for v in x]) for n in (1, 2))
    slope, bend = jax.jit(jax.vmap(lambda v: (jax.grad(function)(v), jax.jacfwd(jax.grad(function))(v))))(x)
    np.testing.assert_allclose(slope, first, rtol=1e-14, atol=1e-14)
    np.testing.assert_allclose(bend, second, rtol=1e-12, atol=1e-13)


@each_kind
@pytest.mark.parametrize("name", OPERATIONS)
def test_only_arithmetic(name: str, kind: type[np.floating[Any]]) -> None:
    """Another primitive than those of the oracle is an error there; no more operations than are written down."""
    counted = operations(getattr(elementary, name), *[np.ones((), kind)] * (1 + (name in TWO)))
    assert sum(counted.values()) == OPERATIONS[name][0 if kind is np.float64 else 1], counted


@each_name
def test_types_and_shapes(name: str) -> None:
    """The type of the argument stays, any shape is taken, a Python number takes the type of what it meets."""
    function = getattr(elementary, name)
    for kind in (np.float64, np.float32):
        for shape in ((), (2, 0, 3), (4, 5)):
            found = jax.eval_shape(function, jax.ShapeDtypeStruct(shape, kind))
            assert (found.shape, found.dtype) == (shape, kind)
        assert jax.eval_shape(lambda x: x * function(0.5), jax.ShapeDtypeStruct((3,), kind)).dtype == kind
    np.testing.assert_array_equal(function(0.5), evaluate(function, np.array([0.5]))[0])
    assert jax.eval_shape(function, jax.ShapeDtypeStruct((2,), np.int32)).dtype == np.float64
    with pytest.raises(TypeError, match="float16 numbers: float64 and float32 are accepted"):
        jax.eval_shape(function, jax.ShapeDtypeStruct((2,), np.float16))


@each_kind
def test_tanh_is_odd_bounded_and_rises(kind: type[np.floating[Any]]) -> None:
    """|tanh x| ≤ 1, tanh(−x) = −tanh x in every bit, and no fall of more than two units in the last place."""
    x = np.sort(np.abs(np.concatenate([arguments(TRUTHS["tanh"], kind, 20000), np.arange(0.0, 22.0, 1e-3, kind)])))
    y = evaluate(elementary.tanh, x)
    np.testing.assert_array_equal(evaluate(elementary.tanh, -x), -y)
    assert y.max() == 1.0
    assert np.all(np.diff(y) >= -2.0 * np.spacing(y[1:]))
    tiny = x[x < 1e-10]
    np.testing.assert_array_equal(evaluate(elementary.tanh, tiny), tiny)


@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="there every processor contracts a*b + c")
@pytest.mark.parametrize(
    "names", [IN_FLIGHTS, tuple(sorted({*OPERATIONS, "sin", "cos"} - {*IN_FLIGHTS}))], ids=["flights", "others"]
)
def test_bits_under_jit(names: tuple[str, ...]) -> None:
    """XLA without fused multiply-add gives the bits of NumPy: no rewriting of XLA's changes a result.

    With it XLA turns a*b + c into one operation with one rounding, and last bits differ.
    """
    done = subprocess.run(
        [sys.executable, "-m", "tests.physics.same_bits", *names],
        env=os.environ | {"XLA_FLAGS": "--xla_cpu_max_isa=AVX", "JAX_ENABLE_X64": "1", "JAX_PLATFORMS": "cpu"},
        cwd=Path(__file__).parents[2],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.split() == [f"{name}:{kind}:0" for name in names for kind in ("float64", "float32")]
