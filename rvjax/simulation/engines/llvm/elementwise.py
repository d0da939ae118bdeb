"""Primitives of JAX that compute a number from numbers: primitive → instructions.

Arithmetic is that of IEEE 754 in the type of the operands, rounded to nearest: nothing is contracted, put in another order, or
flushed to zero. What the standard leaves open:

    max, min      NaN if an operand is NaN; the second operand if both are equal, so max(0, −0) = −0
    sign          ±1, the operand itself if it is 0, −0 or NaN
    integer_pow   squares from the lowest bit on, x⁶ = x² x⁴ with x⁴ = (x²)²; 1/xⁿ for a negative power
    round         to the even neighbour, or away from zero, as JAX says
    whole numbers wrap around; x/0 = −1 and x mod 0 = x, as in XLA
    float → whole number   towards zero; the nearest number of the type beyond its range; 0 for NaN
    NaN           has no sign and no further bits that anybody may look at

Elementary functions are arithmetic too (`rvjax.physics.elementary`): no function of a C library is called.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from rvjax.physics import elementary
from rvjax.simulation.engines.llvm.program import BOOL, Builder, Type, UnsupportedError, Value

Row = Callable[[Builder, Mapping[str, Any], Type, tuple[Value, ...]], Value]
"""(builder, parameters of the primitive, type of the result, operands) → the result."""


def is_float(kind: Type) -> bool:
    """Whether a type has real numbers."""
    return kind.kind == "f"


def instruction(real: str, whole: str = "", truth: str = "") -> Row:
    """The same instruction on real numbers, on whole numbers and on truth values; "": there is none."""

    def row(to: Builder, params: Mapping[str, Any], kind: Type, operands: tuple[Value, ...]) -> Value:
        del params
        given = to.type(operands[0])
        code = truth or whole if given == BOOL else real if is_float(given) else whole
        return to.emit(_signed(code, given), kind, *operands)

    return row


def _signed(code: str, kind: Type) -> str:
    """The instruction for signed or unsigned numbers: `div` is `sdiv` or `udiv`."""
    if not code:
        raise UnsupportedError(f"on {kind}")
    return code.replace("?", "s" if kind.kind == "i" else "u")


def compare(real: str, whole: str) -> Row:
    """A comparison: `oge` of real numbers, `?ge` of whole numbers."""

    def row(to: Builder, params: Mapping[str, Any], kind: Type, operands: tuple[Value, ...]) -> Value:
        del params
        given = to.type(operands[0])
        if given.kind == "f":
            return to.emit(f"fcmp {real}", kind, *operands)
        return to.emit(f"icmp {_signed(whole, given)}", kind, *operands)

    return row


def extreme(real: str, whole: str, truth: str) -> Row:
    """max or min."""

    def row(to: Builder, params: Mapping[str, Any], kind: Type, operands: tuple[Value, ...]) -> Value:
        del params
        first, second = operands
        if kind == BOOL:
            return to.emit(truth, kind, first, second)
        if not is_float(kind):
            return to.emit("select", kind, to.emit(f"icmp {_signed(whole, kind)}", BOOL, first, second), first, second)
        best = to.emit("select", kind, to.emit(f"fcmp {real}", BOOL, first, second), first, second)
        return to.emit("select", kind, to.emit("fcmp uno", BOOL, first, first), first, best)

    return row


def apply(to: Builder, name: str, kind: Type, *operands: Value, **params: Any) -> Value:
    """The result of another primitive."""
    return ROWS[name](to, params, kind, operands)


def clamp(to: Builder, params: Mapping[str, Any], kind: Type, operands: tuple[Value, ...]) -> Value:
    """min(max(x, low), high)."""
    del params
    low, x, high = operands
    return apply(to, "min", kind, apply(to, "max", kind, x, low), high)


def sign(to: Builder, params: Mapping[str, Any], kind: Type, operands: tuple[Value, ...]) -> Value:
    """±1; the operand itself if it is neither above nor below 0."""
    del params
    (x,) = operands
    zero, one = to.constant(0, kind), to.constant(1, kind)
    if kind.kind == "u":
        return to.emit("select", kind, to.emit("icmp ne", BOOL, x, zero), one, zero)
    if not is_float(kind):
        below = to.emit("select", kind, apply(to, "lt", BOOL, x, zero), to.constant(-1, kind), x)
        return to.emit("select", kind, apply(to, "gt", BOOL, x, zero), one, below)
    whole = np.dtype(f"int{8 * kind.itemsize}")
    bit = to.emit("and", whole, to.emit("bitcast", whole, x), to.constant(np.iinfo(whole).min, whole))
    signed = to.emit("bitcast", kind, to.emit("or", whole, bit, to.emit("bitcast", whole, one)))
    return to.emit("select", kind, to.emit("fcmp one", BOOL, x, zero), signed, x)


def absolute(to: Builder, params: Mapping[str, Any], kind: Type, operands: tuple[Value, ...]) -> Value:
    """|x|."""
    del params
    (x,) = operands
    if is_float(kind):
        return to.emit("fabs", kind, x)
    if kind.kind == "u":
        return x
    return to.emit("select", kind, apply(to, "lt", BOOL, x, to.constant(0, kind)), apply(to, "neg", kind, x), x)


def negative(to: Builder, params: Mapping[str, Any], kind: Type, operands: tuple[Value, ...]) -> Value:
    """−x."""
    del params
    return to.emit("fneg", kind, *operands) if is_float(kind) else to.emit("sub", kind, to.constant(0, kind), *operands)


def divide(to: Builder, params: Mapping[str, Any], kind: Type, operands: tuple[Value, ...]) -> Value:
    """x/y."""
    if is_float(kind):
        return to.emit("fdiv", kind, *operands)
    return _whole(to, "?div", kind, operands, to.constant(-1 if kind.kind == "i" else np.iinfo(kind).max, kind))


def remainder(to: Builder, params: Mapping[str, Any], kind: Type, operands: tuple[Value, ...]) -> Value:
    """x − y trunc(x/y)."""
    if is_float(kind):
        return to.emit("frem", kind, *operands)
    return _whole(to, "?rem", kind, operands, operands[0])


def _whole(to: Builder, code: str, kind: Type, operands: tuple[Value, ...], by_zero: Value) -> Value:
    """A division of whole numbers; by 0, and of the lowest number by −1, as XLA has it."""
    x, y = operands
    zero, one = to.constant(0, kind), to.constant(1, kind)
    none = to.emit("icmp eq", BOOL, y, zero)
    safe = to.emit("select", kind, none, one, y)
    overflow = None
    if kind.kind == "i":
        lowest = to.emit("icmp eq", BOOL, x, to.constant(np.iinfo(kind).min, kind))
        overflow = to.emit("and", BOOL, lowest, to.emit("icmp eq", BOOL, y, to.constant(-1, kind)))
        safe = to.emit("select", kind, overflow, one, safe)
    result = to.emit(_signed(code, kind), kind, x, safe)
    if overflow is not None:
        result = to.emit("select", kind, overflow, x if code == "?div" else zero, result)
    return to.emit("select", kind, none, by_zero, result)


def shift(code: str) -> Row:
    """A shift; by the width of the type or more: 0, or the sign."""

    def row(to: Builder, params: Mapping[str, Any], kind: Type, operands: tuple[Value, ...]) -> Value:
        del params
        x, by = operands
        width = 8 * kind.itemsize
        number = to.number(by)
        if number is not None and 0 <= int(number) < width:
            return to.emit(code, kind, x, by)
        inside = to.emit("icmp ult", BOOL, by, to.constant(width, kind))
        most = to.constant(width - 1, kind)
        shifted = to.emit(code, kind, x, to.emit("select", kind, inside, by, most))
        beyond = shifted if code == "ashr" else to.constant(0, kind)
        return to.emit("select", kind, inside, shifted, beyond)

    return row


def integer_power(to: Builder, params: Mapping[str, Any], kind: Type, operands: tuple[Value, ...]) -> Value:
    """xⁿ for a fixed n."""
    (x,), n = operands, int(params["y"])
    result, left = None, abs(n)
    while left:
        if left & 1:
            result = x if result is None else apply(to, "mul", kind, result, x)
        left >>= 1
        x = apply(to, "mul", kind, x, x) if left else x
    one = to.constant(1, kind)
    if result is None:
        return one
    return apply(to, "div", kind, one, result) if n < 0 else result


def rounded(to: Builder, params: Mapping[str, Any], kind: Type, operands: tuple[Value, ...]) -> Value:
    """The nearest whole number."""
    even = params["rounding_method"] == jax.lax.RoundingMethod.TO_NEAREST_EVEN
    return to.emit("rint" if even else "round", kind, *operands)


def select(to: Builder, params: Mapping[str, Any], kind: Type, operands: tuple[Value, ...]) -> Value:
    """The case of a number."""
    del params
    which, *cases = operands
    if to.type(which) == BOOL:
        return to.emit("select", kind, which, cases[1], cases[0]) if cases[1:] else cases[0]
    result = cases[-1]
    for index in reversed(range(len(cases) - 1)):
        here = apply(to, "le", BOOL, which, to.constant(index, to.type(which)))
        result = to.emit("select", kind, here, cases[index], result)
    return result


def finite(to: Builder, params: Mapping[str, Any], kind: Type, operands: tuple[Value, ...]) -> Value:
    """|x| < ∞."""
    del params
    given = to.type(operands[0])
    return to.emit("fcmp olt", kind, to.emit("fabs", given, *operands), to.constant(np.inf, given))


def converted(to: Builder, params: Mapping[str, Any], kind: Type, operands: tuple[Value, ...]) -> Value:
    """The number in another type."""
    del params
    (x,) = operands
    given = to.type(x)
    if given == kind:
        return x
    if (number := to.number(x)) is not None and not (given.kind == "f" and kind.kind in "iu"):
        return to.constant(number, kind)
    if kind == BOOL:
        zero = to.constant(0, given)
        return to.emit("fcmp une", kind, x, zero) if is_float(given) else to.emit("icmp ne", kind, x, zero)
    if is_float(given):
        code = ("fpext" if kind.itemsize > given.itemsize else "fptrunc") if is_float(kind) else _signed("fpto?i.sat", kind)
    elif is_float(kind):
        code = "uitofp" if given.kind in "ub" else "sitofp"
    elif kind.itemsize > given.itemsize or given == BOOL:
        code = "zext" if given.kind in "ub" else "sext"
    else:
        code = "trunc" if kind.itemsize < given.itemsize else "same"
    return to.emit(code, kind, x)


def bits(to: Builder, params: Mapping[str, Any], kind: Type, operands: tuple[Value, ...]) -> Value:
    """The number with the same bits in another type of the same width."""
    del params
    given = to.type(operands[0])
    if given.itemsize != kind.itemsize or BOOL in (given, kind):
        raise UnsupportedError(f"from {given} to {kind}")
    return to.emit("bitcast" if is_float(given) != is_float(kind) else "same", kind, *operands)


def ordered(to: Builder, params: Mapping[str, Any], kind: Type, operands: tuple[Value, ...]) -> Value:
    """x < y in a total order: −NaN, −∞, …, −0, 0, …, ∞, NaN."""
    given = to.type(operands[0])
    if not is_float(given):
        return apply(to, "lt", kind, *operands, **params)
    whole = np.dtype(f"int{8 * given.itemsize}")

    def key(x: Value) -> Value:
        bits = to.emit("bitcast", whole, x)
        below = to.emit("ashr", whole, bits, to.constant(8 * given.itemsize - 1, whole))
        return to.emit("xor", whole, bits, to.emit("and", whole, below, to.constant(np.iinfo(whole).max, whole)))

    return to.emit("icmp slt", kind, *map(key, operands))


def function(of: Callable[..., Any]) -> Row:
    """A function of real numbers that is written with primitives of this table."""

    def row(to: Builder, params: Mapping[str, Any], kind: Type, operands: tuple[Value, ...]) -> Value:
        del params
        from rvjax.simulation.engines.llvm.from_jaxpr import inlined

        return inlined(to, _traced(of, kind.str, len(operands)), operands)[0]

    return row


@cache
def _traced(of: Callable[..., Any], kind: str, count: int) -> Any:
    return jax.make_jaxpr(of)(*[jax.ShapeDtypeStruct((), np.dtype(kind))] * count)


def _same(to: Builder, params: Mapping[str, Any], kind: Type, operands: tuple[Value, ...]) -> Value:
    """The operand."""
    del to, params, kind
    return operands[0]


def _logistic(x: Any) -> Any:
    """1/(1 + e^{−x})."""
    return 1.0 / (1.0 + jnp.exp(-x))


ELEMENTARY = (
    *("exp", "exp2", "expm1", "log", "log1p", "sin", "cos", "tan", "asin", "acos", "atan", "atan2"),
    *("sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "cbrt", "erf"),
)
"""Primitives that have the name of their function in `rvjax.physics.elementary`."""

ROWS: Mapping[str, Row] = {
    "add": instruction("fadd", "add", "or"),
    "add_any": instruction("fadd", "add", "or"),
    "sub": instruction("fsub", "sub"),
    "mul": instruction("fmul", "mul", "and"),
    "div": divide,
    "rem": remainder,
    "neg": negative,
    "abs": absolute,
    "sign": sign,
    "max": extreme("ogt", "?gt", "or"),
    "min": extreme("olt", "?lt", "and"),
    "clamp": clamp,
    "sqrt": instruction("sqrt"),
    "rsqrt": function(lambda x: 1.0 / jnp.sqrt(x)),
    "square": lambda to, params, kind, operands: apply(to, "mul", kind, *operands, *operands),
    "integer_pow": integer_power,
    "floor": instruction("floor"),
    "ceil": instruction("ceil"),
    "round": rounded,
    "is_finite": finite,
    "eq": compare("oeq", "eq"),
    "ne": compare("une", "ne"),
    "lt": compare("olt", "?lt"),
    "le": compare("ole", "?le"),
    "gt": compare("ogt", "?gt"),
    "ge": compare("oge", "?ge"),
    "lt_to": ordered,
    "and": instruction("", "and"),
    "or": instruction("", "or"),
    "xor": instruction("", "xor"),
    "not": lambda to, params, kind, operands: to.emit("xor", kind, *operands, to.constant(True if kind == BOOL else -1, kind)),
    "shift_left": shift("shl"),
    "shift_right_logical": shift("lshr"),
    "shift_right_arithmetic": shift("ashr"),
    "select_n": select,
    "convert_element_type": converted,
    "bitcast_convert_type": bits,
    "copy": _same,
    "device_put": _same,
    "name": _same,
    "stop_gradient": _same,
    "reduce_precision": _same,
    "optimization_barrier": _same,
    "logistic": function(_logistic),
    "pow": function(elementary.power),
    **{name: function(getattr(elementary, name)) for name in ELEMENTARY},
}
"""Primitive → instructions."""
