"""Elementary functions of NumPy's numbers and arrays: the bits of the JAX ones, any shape, no warning."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rvjax import elementary
from rvjax.physics import elementary as of_jax
from tests.oracles.elementary_truth import SPECIAL_PAIRS, SPECIAL_VALUES, TRUTHS, arguments, pairs
from tests.oracles.jaxpr_numpy import evaluate

TWO = ("power", "atan2")
each_kind = pytest.mark.parametrize("kind", [np.float64, np.float32])
each_name = pytest.mark.parametrize("name", [*TRUTHS, "sin", "cos", *TWO])


def given(name: str, kind: type[np.floating[Any]]) -> tuple[np.ndarray[Any, Any], ...]:
    """Arguments of every size, and those with a special result."""
    rows = [row for function, *row in (*SPECIAL_VALUES, *SPECIAL_PAIRS) if function == name]
    if name in TWO:
        return tuple(np.append(x, [row[i] for row in rows]).astype(kind) for i, x in enumerate(pairs(name, kind, 500)))
    truth = TRUTHS[{"sin": "tan", "cos": "tan"}.get(name, name)]
    return (np.append(arguments(truth, kind, 500), [*(row[0] for row in rows), np.nan]).astype(kind),)


@each_kind
@each_name
@pytest.mark.filterwarnings("error")
def test_the_bits_are_those_of_jax(name: str, kind: type[np.floating[Any]]) -> None:
    """One operation of NumPy for each of the jaxpr gives the same bits. Kills a constant of another type, a warning."""
    x = given(name, kind)
    ours = getattr(elementary, name)(*x)
    assert ours.dtype == kind
    np.testing.assert_array_equal(ours, evaluate(getattr(of_jax, name), *x))
    np.testing.assert_array_equal(np.signbit(ours), np.signbit(evaluate(getattr(of_jax, name), *x)))


def test_whole_powers_too() -> None:
    """Kills another order of the products."""
    x = np.linspace(-3.0, 3.0, 101)
    for n in (-3, 0, 1, 2, 7):
        np.testing.assert_array_equal(elementary.integer_power(x, n), evaluate(lambda v, n=n: of_jax.integer_power(v, n), x))


@each_name
def test_shapes_and_numbers(name: str) -> None:
    """Arrays of any shape and layout; numbers give a float64, arguments of two shapes meet. Kills a lost dimension."""
    function, count = getattr(elementary, name), 1 + (name in TWO)
    one = function(*[0.5] * count)
    assert type(one) is np.float64
    assert type(function(*[1] * count)) is np.float64
    for x in (np.full((), 0.5), np.full((2, 0, 3), 0.5), np.full((4, 5), 0.5).T, np.full((4, 6), 0.5)[:, ::2]):
        found = function(*[x] * count)
        assert found.shape == x.shape
        np.testing.assert_array_equal(found, np.full(x.shape, one))
    if count == 2:
        assert function(np.ones((3, 1)), np.ones(2)).shape == (3, 2)
        assert function(np.ones(2, np.float32), 2.5).dtype == np.float32
    with pytest.raises(TypeError, match="float16 numbers: float64 and float32 are accepted"):
        function(*[np.ones(2, np.float16)] * count)
