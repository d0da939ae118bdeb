"""Mutants of the elementary functions: coefficients, parts, branches, edges."""

from __future__ import annotations

from tests.mutants.mutant import Mutant

EXP, TANH, LOG, ERF = (f"elementary/{name}.py" for name in ("exponential", "hyperbolic", "logarithms", "error_function"))
DIGITS = "physics/test_elementary.py::test_every_digit_is_there"
SPECIAL = "physics/test_elementary.py::test_special_values"
SLOPES = "physics/test_elementary.py::test_derivatives_are_those_of_the_function"
BITS = "physics/test_elementary.py::test_bits_under_jit"
PAIRS = "physics/test_elementary.py::test_every_digit_of_two_arguments_is_there"
SPECIAL_PAIRS = "physics/test_elementary.py::test_special_pairs"
TAN, ARC, AREA, POWERS = (
    f"elementary/{name}.py" for name in ("tangent", "inverse_trigonometric", "inverse_hyperbolic", "powers")
)
WHOLE = "physics/test_elementary.py::test_whole_powers_are_those_of_lax"

MUTANTS = (
    Mutant("exp: a coefficient off by 1e-13", EXP, "0.0013888888917367081", "0.0013888888918367081", DIGITS),
    Mutant("exp: no second part of ln 2", EXP, "(x - k * t.parts[0]) - k * t.parts[1]", "x - k * t.parts[0]", DIGITS),
    Mutant("exp: overflow too early", EXP, "highest=711.0", "highest=709.0", DIGITS),
    Mutant("exp: 2ᵏ in one factor", "elementary/formats.py", "half = both >> 1", "half = both - 1023", DIGITS),
    Mutant("expm1: rest of r with the other sign", EXP, "rest = (first - r) - second", "rest = second - (first - r)", DIGITS),
    Mutant("expm1: sign of zero lost", EXP, "return xp.where(xp.abs(x) <", "return xp.where(xp.abs(x) < -", SPECIAL),
    Mutant(
        "expm1: derivative of exp",
        "physics/elementary.py",
        "elementary.expm1, lambda x, y: exp(x)",
        "elementary.expm1, lambda x, y: y",
        SLOPES,
    ),
    Mutant("tanh: a coefficient off by 1e-12", TANH, "-0.05396825382196964", "-0.05396825382296964", DIGITS),
    Mutant("tanh: one formula for all", TANH, "near = k < 3.0", "near = k < 99.0", DIGITS),
    Mutant("tanh: sign lost", TANH, "(high + low * t), x)", "(high + low * t), x * x)", SPECIAL),
    Mutant("log: a coefficient off by 1e-10", LOG, "0.2857142862599856", "0.2857142863599856", DIGITS),
    Mutant("log: subnormal numbers as they are", LOG, "k - (form.digits + 2.0), k)", "k - (form.digits + 1.0), k)", DIGITS),
    Mutant("log: NaN at zero", LOG, "either(argument == 0.0, -xp.inf, xp.nan, argument)", "xp.nan * argument", SPECIAL),
    Mutant("log1p: without what 1 + x loses", LOG, "f = f + 0.5 * lost * shrink", "f = f + 0.0 * lost * shrink", DIGITS),
    Mutant("log1p: a sum that XLA folds", LOG, "lost = (1.0 - (one + most)) + (x + most)", "lost = x - (one - 1.0)", BITS),
    Mutant("log2: 1/ln 2 with 11 digits", LOG, "0.0)) * (1.0 / LN2)", "0.0)) * 1.4426950408", DIGITS),
    Mutant("erf: a coefficient off by 1e-12", ERF, "0.0052239776071164225", "0.0052239776081164225", DIGITS),
    Mutant("erf: a far coefficient off by 1e-12", ERF, "1.152787684180108", "1.152787684181108", DIGITS),
    Mutant("erf: near and far swapped", ERF, "xp.where(size < 1.0, near, far)", "xp.where(size > 1.0, near, far)", DIGITS),
    Mutant("exp2: a coefficient off by 1e-13", EXP, "0.0555041086648216,", "0.0555041086649216,", DIGITS),
    Mutant("sinh: overflow of e^x", TANH, "half = half_exp(size)", "half = half_exp(xp.minimum(size, 700.0))", DIGITS),
    Mutant("sinh: a coefficient off by 1e-12", TANH, "0.008333333333333299", "0.008333333334333299", DIGITS),
    Mutant("cosh: quotient missing", TANH, "return half + 0.25 / half", "return half + 0.2 / half", DIGITS),
    Mutant("tan: what the reduction loses", TAN, "lost + ((r - less) - n * part)", "lost", DIGITS),
    Mutant("tan: correction with the other sign", TAN, "y = quotient + correction *", "y = quotient - correction *", DIGITS),
    Mutant("tan: a quarter off", TAN, "quarter > 1.5", "quarter > 2.5", DIGITS),
    Mutant("atan: a coefficient off by 1e-11", ARC, "0.11111111100881761", "0.11111111101881761", DIGITS),
    Mutant("atan: no second part of π", ARC, "(sign * tail + quarters * second)", "sign * tail", DIGITS),
    Mutant("atan2: behind for ahead", ARC, "bits(x) < 0", "x < 0.0", SPECIAL_PAIRS),
    Mutant("atan2: overflow of the sum", ARC, "0.25, 1.0, x)  # less", "1.0, 1.0, x)  # less", PAIRS),
    Mutant("asin: a coefficient off by 1e-11", ARC, "0.04464285714637338", "0.04464285715637338", DIGITS),
    Mutant("asin: branches swapped", ARC, "xp.where(far, beyond, s + tail)", "xp.where(far, s + tail, beyond)", DIGITS),
    Mutant("acos: π/2 for π", ARC, "4.0 * first - (2.0 * s", "2.0 * first - (2.0 * s", DIGITS),
    Mutant("asinh: ln x for ln 2x", AREA, "either(large, LN2, 0.0, w)", "0.0", DIGITS),
    Mutant("acosh: u² missing", AREA, "xp.sqrt(above * above + (above + above))", "xp.sqrt(above + above)", DIGITS),
    Mutant("acosh: a number below 1", AREA, "xp.where(x < 1.0, xp.nan, y)", "y", SPECIAL),
    Mutant("atanh: half missing", AREA, "with_sign(0.5 * log1p", "with_sign(log1p", DIGITS),
    Mutant("cbrt: last step missing", "elementary/cube_root.py", "t = _closer(head(t, (30, 12)), m) *", "t = t *", DIGITS),
    Mutant("power: rest of the logarithm missing", POWERS, "(y - cut) * first + y * second", "(y - cut) * first", PAIRS),
    Mutant("power: a coefficient off by 1e-10", POWERS, "0.42857142857213787", "0.42857142867213787", PAIRS),
    Mutant("power: odd for whole", POWERS, "odd = whole & (", "odd = whole | (", SPECIAL_PAIRS),
    Mutant("power: sign of zero by comparison", POWERS, "odd & (bits(x) < 0)", "odd & (x < 0.0)", SPECIAL_PAIRS),
    Mutant("whole powers: square too often", POWERS, "if rest & 1:", "if rest & 3:", WHOLE),
)
