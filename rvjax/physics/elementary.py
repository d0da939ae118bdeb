"""The elementary functions of `rvjax.elementary` for JAX: with derivatives, inlined under `jit`.

The type of the result is that of the arguments, float64 or float32. Python numbers are evaluated by NumPy and give a
number that takes the type of what it meets, as in jnp. Errors: TypeError for other types.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache, partial, wraps

import jax
import jax.numpy as jnp

from rvjax import elementary
from rvjax.elementary.formats import LN2
from rvjax.physics.vectors import Scalar

Function = Callable[[Scalar], Scalar]


def evaluated(function: Callable[..., Scalar], inner: Callable[..., Scalar], *arguments: Scalar) -> Scalar:
    """inner(*arguments) in their common type; of Python numbers function(*arguments), by NumPy, which contracts nothing."""
    if all(type(x) in (bool, int, float) for x in arguments):
        with jax.ensure_compile_time_eval():
            return jnp.asarray(float(function(*map(float, arguments))))
    dtype = jnp.result_type(*arguments)
    dtype = dtype if jnp.issubdtype(dtype, jnp.floating) else jnp.result_type(float)
    return inner(*(jnp.asarray(x, dtype=dtype) for x in arguments))


def differentiable(function: Function, slope: Callable[[Scalar, Scalar], Scalar]) -> Function:
    """A function f of one argument with its derivative: slope(x, f(x)) = f'(x). Bits have none."""
    inner = jax.custom_jvp(jax.jit(function, inline=True))

    def rule(primals: tuple[Scalar], tangents: tuple[Scalar]) -> tuple[Scalar, Scalar]:
        y = inner(*primals)
        return y, slope(*primals, y) * tangents[0]

    inner.defjvp(rule)
    return wraps(function)(partial(evaluated, function, inner))


def differentiable_of_two(
    function: Callable[[Scalar, Scalar], Scalar], slopes: Callable[[Scalar, Scalar, Scalar], tuple[Scalar, Scalar]]
) -> Callable[[Scalar, Scalar], Scalar]:
    """A function of two arguments with its derivative: slopes(x, y, f(x, y)) = (∂f/∂x, ∂f/∂y)."""
    inner = jax.custom_jvp(jax.jit(function, inline=True))

    def rule(primals: tuple[Scalar, Scalar], tangents: tuple[Scalar, Scalar]) -> tuple[Scalar, Scalar]:
        value = inner(*primals)
        along_x, along_y = slopes(*primals, value)
        return value, along_x * tangents[0] + along_y * tangents[1]

    inner.defjvp(rule)

    @wraps(function)
    def outer(x: Scalar, y: Scalar) -> Scalar:
        return evaluated(function, lambda *both: inner(*jnp.broadcast_arrays(*both)), x, y)

    return outer


exp = differentiable(elementary.exp, lambda x, y: y)
exp2 = differentiable(elementary.exp2, lambda x, y: LN2 * y)
expm1 = differentiable(elementary.expm1, lambda x, y: exp(x))
log = differentiable(elementary.log, lambda x, y: 1.0 / x)
log1p = differentiable(elementary.log1p, lambda x, y: 1.0 / (1.0 + x))
log2 = differentiable(elementary.log2, lambda x, y: (1.0 / LN2) / x)
sin = differentiable(elementary.sin, lambda x, y: cos(x))
cos = differentiable(elementary.cos, lambda x, y: -sin(x))
tan = differentiable(elementary.tan, lambda x, y: 1.0 + y * y)
asin = differentiable(elementary.asin, lambda x, y: 1.0 / jnp.sqrt((1.0 - x) * (1.0 + x)))
acos = differentiable(elementary.acos, lambda x, y: -1.0 / jnp.sqrt((1.0 - x) * (1.0 + x)))
atan = differentiable(elementary.atan, lambda x, y: 1.0 / (1.0 + x * x))
tanh = differentiable(elementary.tanh, lambda x, y: 1.0 - y * y)
sinh = differentiable(elementary.sinh, lambda x, y: cosh(x))
cosh = differentiable(elementary.cosh, lambda x, y: sinh(x))
asinh = differentiable(elementary.asinh, lambda x, y: 1.0 / jnp.sqrt(1.0 + x * x))
acosh = differentiable(elementary.acosh, lambda x, y: 1.0 / (jnp.sqrt(x - 1.0) * jnp.sqrt(x + 1.0)))
atanh = differentiable(elementary.atanh, lambda x, y: 1.0 / ((1.0 - x) * (1.0 + x)))
cbrt = differentiable(elementary.cbrt, lambda x, y: 1.0 / (3.0 * y * y))
erf = differentiable(elementary.erf, lambda x, y: (2.0 / math.sqrt(math.pi)) * exp(-(x * x)))


def integer_power(x: Scalar, n: int) -> Scalar:
    """xⁿ for a fixed integer n. Exactly what `jax.lax.integer_pow` computes."""
    return _integer_power(n)(x)


@cache
def _integer_power(n: int) -> Function:
    def slope(x: Scalar, y: Scalar) -> Scalar:
        return n * integer_power(x, n - 1) if n else jnp.zeros_like(y)

    def raised(x: Scalar) -> Scalar:
        return elementary.integer_power(x, n)

    return differentiable(raised, slope)


def _slopes_of_power(x: Scalar, y: Scalar, value: Scalar) -> tuple[Scalar, Scalar]:
    """∂/∂y is 0 for x ≤ 0, where only whole y give numbers."""
    along_x = jnp.where(y == 0.0, 0.0, y * power(x, jnp.where(y == 0.0, 1.0, y - 1.0)))
    return along_x, value * log(jnp.where(x > 0.0, x, 1.0))


def _slopes_of_angle(y: Scalar, x: Scalar, angle: Scalar) -> tuple[Scalar, Scalar]:
    del angle
    square = x * x + y * y
    return x / square, -y / square


power = differentiable_of_two(elementary.power, _slopes_of_power)
atan2 = differentiable_of_two(elementary.atan2, _slopes_of_angle)
