"""C code of one step of a flight, written from its jaxpr: the yardsticks `scalar_c` and `simd_c`.

The jaxpr of `rvjax.simulation.flight.step` for one sample holds scalars only, so every equation of it becomes one C statement.
Two loops are put around the statements:

    scalar   a sample after the other, its steps inside: what a colleague writes in an afternoon
    simd     a block of lanes side by side, its steps outside the lanes: every statement works on whole vector registers

Both share the samples between threads with OpenMP. What gcc may do with the statements is the caller's choice of flags.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from jax.extend.core import ClosedJaxpr

from benchmarks.flat import Call, Constant, Operand, flat

REALS = {"float64": ("double", ""), "float32": ("float", "f")}
"""C type, and the suffix of its functions and numbers, by precision."""

INFIX = {"add": "+", "sub": "-", "mul": "*", "div": "/"}
COMPARISONS = {"ge": ">=", "gt": ">", "le": "<=", "lt": "<", "eq": "==", "ne": "!="}
CALLS = ("sqrt", "tanh", "exp", "log", "cos", "sin")

HEAD = """#include <math.h>
typedef {real} real;
static inline real sign_of(real a) {{ return a > 0 ? (real)1 : (a < 0 ? (real)-1 : (real)0); }}
static inline real larger(real a, real b) {{ return a > b ? a : b; }}
static inline real smaller(real a, real b) {{ return a < b ? a : b; }}
"""

SCALAR = """
void fly(long samples, long first, long last, const real *drawn, real *carry) {{
#pragma omp parallel for schedule(static)
  for (long i = 0; i < samples; i++) {{
{load}
    for (long k = first; k < last; k++) {{
{body}
{keep}
    }}
{store}
  }}
}}
"""

SIMD = """
void fly(long samples, long first, long last, const real *drawn, real *carry) {{
#pragma omp parallel for schedule(static)
  for (long b = 0; b < samples; b += {lanes}) {{
    real d[{drawn}][{lanes}], c[{carried}][{lanes}];
    for (long j = 0; j < {drawn}; j++) for (long l = 0; l < {lanes}; l++) d[j][l] = drawn[j * samples + b + l];
    for (long j = 0; j < {carried}; j++) for (long l = 0; l < {lanes}; l++) c[j][l] = carry[j * samples + b + l];
    for (long k = first; k < last; k++) {{
#pragma omp simd
      for (long l = 0; l < {lanes}; l++) {{
{load}
{body}
{keep}
      }}
    }}
    for (long j = 0; j < {carried}; j++) for (long l = 0; l < {lanes}; l++) carry[j * samples + b + l] = c[j][l];
  }}
}}
"""


class NoScalarError(ValueError):
    """A step holds arrays."""


def scalar(step: ClosedJaxpr, drawn: int, precision: str) -> str:
    """C source of `fly(samples, first, last, drawn, carry)`, a sample after the other.

    step: (drawn numbers…, carried numbers…, k) → carried numbers…; drawn: how many of its arguments are drawn.
    Both arrays lie number by number: (numbers, samples).
    """
    carried = len(step.jaxpr.outvars)
    body, outputs = _statements(step, drawn, precision)
    load = [f"const real d{j} = drawn[{j} * samples + i];" for j in range(drawn)]
    load += [f"real c{j} = carry[{j} * samples + i];" for j in range(carried)]
    keep = [f"c{j} = {name};" for j, name in enumerate(outputs)]
    store = [f"carry[{j} * samples + i] = c{j};" for j in range(carried)]
    parts = {"load": load, "body": body, "keep": keep, "store": store}
    return _head(precision) + SCALAR.format(**{name: "\n".join(lines) for name, lines in parts.items()})


def simd(step: ClosedJaxpr, drawn: int, precision: str, lanes: int) -> str:
    """C source of the same function, `lanes` samples side by side; their number must divide that of the samples."""
    carried = len(step.jaxpr.outvars)
    body, outputs = _statements(step, drawn, precision)
    load = [f"const real d{j} = d[{j}][l];" for j in range(drawn)]
    load += [f"const real c{j} = c[{j}][l];" for j in range(carried)]
    keep = [f"c[{j}][l] = {name};" for j, name in enumerate(outputs)]
    parts = {"load": load, "body": body, "keep": keep}
    text = {name: "\n".join(lines) for name, lines in parts.items()}
    return _head(precision) + SIMD.format(lanes=lanes, drawn=drawn, carried=carried, **text)


def _head(precision: str) -> str:
    return HEAD.format(real=REALS[precision][0])


def _statements(step: ClosedJaxpr, drawn: int, precision: str) -> tuple[list[str], list[str]]:
    """One statement for each equation, and the names of the results."""
    carried, suffix = len(step.jaxpr.outvars), REALS[precision][1]
    arguments = [f"d{j}" for j in range(drawn)] + [f"c{j}" for j in range(carried)] + ["k"]
    whole = flat(step)
    if len(arguments) != whole.inputs:
        raise ValueError(f"a step of {drawn} drawn and {carried} carried numbers and k has {whole.inputs} arguments")

    def name(operand: Operand) -> str:
        if isinstance(operand, Constant):
            return _number(operand.value, suffix)
        return arguments[operand] if operand < whole.inputs else f"t{operand - whole.inputs}"

    lines: list[str] = []
    for number, call in enumerate(whole.calls):
        (out,) = call.equation.outvars
        if out.aval.shape != ():
            raise NoScalarError(f"{call.name} gives {out.aval.str_short()}; a step of one sample holds scalars only")
        kind = "long" if np.dtype(out.aval.dtype).kind == "i" else "real"
        lines.append(f"const {kind} t{number} = {_expression(call, [name(operand) for operand in call.operands], suffix)};")
    return lines, [name(one) for one in whole.results]


def _expression(call: Call, a: list[str], suffix: str) -> str:
    name = call.name
    if name in INFIX:
        return f"{a[0]} {INFIX[name]} {a[1]}"
    if name in COMPARISONS:
        return f"{a[0]} {COMPARISONS[name]} {a[1]} ? (real)1 : (real)0"
    if name in CALLS:
        return f"{name}{suffix}({a[0]})"
    if name == "integer_pow":
        return " * ".join([a[0]] * call.equation.params["y"])
    return FORMS[name](suffix).format(*a)


FORMS: Mapping[str, Callable[[str], str]] = {
    "neg": lambda s: "-{0}",
    "not": lambda s: "1 - {0}",
    "and": lambda s: "{0} * {1}",
    "or": lambda s: "larger({0}, {1})",
    "abs": lambda s: f"fabs{s}({{0}})",
    "sign": lambda s: "sign_of({0})",
    "max": lambda s: "larger({0}, {1})",
    "min": lambda s: "smaller({0}, {1})",
    "select_n": lambda s: "{0} != 0 ? {2} : {1}",
    "clamp": lambda s: "smaller(larger({1}, {0}), {2})",
    "square": lambda s: "{0} * {0}",
    "floor": lambda s: f"floor{s}({{0}})",
    "round": lambda s: f"rint{s}({{0}})",
    "rsqrt": lambda s: f"1 / sqrt{s}({{0}})",
    "convert_element_type": lambda s: "{0}",
    "copy": lambda s: "{0}",
    "stop_gradient": lambda s: "{0}",
    "broadcast_in_dim": lambda s: "{0}",
}
"""Every other primitive that a step is made of, by its form in C."""


def _number(value: np.generic, suffix: str) -> str:
    if value.dtype.kind in "bi":
        return str(int(value))
    number = float(value)
    if np.isinf(number):
        return "INFINITY" if number > 0 else "(-INFINITY)"
    return f"({number!r}{suffix})"
