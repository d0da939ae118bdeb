"""Mutants of the elementary functions: coefficients, parts, branches, edges."""

from __future__ import annotations

from tests.mutants.mutant import Mutant

EXP, TANH, LOG, ERF = (f"physics/elementary/{name}.py" for name in ("exponential", "hyperbolic", "logarithms", "error_function"))
DIGITS = "physics/test_elementary.py::test_every_digit_is_there"
SPECIAL = "physics/test_elementary.py::test_special_values"
SLOPES = "physics/test_elementary.py::test_derivatives_are_those_of_the_function"
BITS = "physics/test_elementary.py::test_bits_under_jit"

MUTANTS = (
    Mutant("exp: a coefficient off by 1e-13", EXP, "0.0013888888917367081", "0.0013888888918367081", DIGITS),
    Mutant("exp: no second part of ln 2", EXP, "(x - k * t.parts[0]) - k * t.parts[1]", "x - k * t.parts[0]", DIGITS),
    Mutant("exp: overflow too early", EXP, "highest=710.0", "highest=709.0", DIGITS),
    Mutant("exp: 2ᵏ in one factor", "physics/elementary/formats.py", "half = both >> 1", "half = both - 1023", DIGITS),
    Mutant("expm1: rest of r with the other sign", EXP, "rest = (first - r) - second", "rest = second - (first - r)", DIGITS),
    Mutant("expm1: sign of zero lost", EXP, "return jnp.where(jnp.abs(x) <", "return jnp.where(jnp.abs(x) < -", SPECIAL),
    Mutant("expm1: derivative of exp", EXP, "@elementary(lambda x, y: exp(x))", "@elementary(lambda x, y: y)", SLOPES),
    Mutant("tanh: a coefficient off by 1e-12", TANH, "-0.05396825382196964", "-0.05396825382296964", DIGITS),
    Mutant("tanh: one formula for all", TANH, "near = k < 3.0", "near = k < 99.0", DIGITS),
    Mutant("tanh: sign lost", TANH, "(high + low * t), x)", "(high + low * t), x * x)", SPECIAL),
    Mutant("log: a coefficient off by 1e-10", LOG, "0.2857142862599856", "0.2857142863599856", DIGITS),
    Mutant("log: subnormal numbers as they are", LOG, "k - (form.digits + 2.0), k)", "k - (form.digits + 1.0), k)", DIGITS),
    Mutant("log: NaN at zero", LOG, "jnp.where(argument == 0.0, -jnp.inf, jnp.nan)", "jnp.nan * argument", SPECIAL),
    Mutant("log1p: without what 1 + x loses", LOG, "f = f + 0.5 * lost * shrink", "f = f + 0.0 * lost * shrink", DIGITS),
    Mutant("log1p: a sum that XLA folds", LOG, "lost = (1.0 - (one + most)) + (x + most)", "lost = x - (one - 1.0)", BITS),
    Mutant("log2: 1/ln 2 with 11 digits", LOG, "0.0)) * (1.0 / math.log(2.0))", "0.0)) * 1.4426950408", DIGITS),
    Mutant("erf: a coefficient off by 1e-12", ERF, "0.0052239776071164225", "0.0052239776081164225", DIGITS),
    Mutant("erf: a far coefficient off by 1e-12", ERF, "1.152787684180108", "1.152787684181108", DIGITS),
    Mutant("erf: near and far swapped", ERF, "jnp.where(size < 1.0, near, far)", "jnp.where(size > 1.0, near, far)", DIGITS),
)
