"""Mutants of draws: the normal and beta laws, tables of counts, constants of thrusters, functions of a library."""

from __future__ import annotations

from tests.mutants.mutant import Mutant

NORMAL, TAIL, BETA = (f"elementary/{name}.py" for name in ("normal", "complementary_error_function", "incomplete_beta"))
LAWS = "campaign/distributions"
DIGITS = "elementary/test_normal.py::test_every_digit_is_there"
LOGARITHMS = "elementary/test_normal.py::test_quantiles_of_logarithms"
QUOTIENTS = "elementary/test_normal.py::test_the_quotients_are_those_of_as_241"
ENDS = "elementary/test_normal.py::test_special_values"
BETAS = "elementary/test_incomplete_beta.py::test_both_tails_keep_their_digits"
SHAPES = "elementary/test_incomplete_beta.py::test_shapes_of_every_size"
ALONE = "elementary/test_incomplete_beta.py::test_a_number_does_not_depend_on_its_neighbours"
GAMMA = "elementary/test_incomplete_beta.py::test_log_gamma_has_forty_digits"
NUMPY = "elementary/test_numpy.py::test_the_bits_are_those_of_jax"
SHAPE = "elementary/test_numpy.py::test_shapes_and_numbers"
LENGTHS = "elementary/test_small_vectors.py::test_lengths_are_rounded_once"
INVERSES = "elementary/test_small_vectors.py::test_pseudo_inverses_are_rounded_once"
GOLDEN = "golden/test_draws.py::test_draws_are_those_that_are_written_down"
PLAIN = "golden/test_plain_arithmetic.py::test_draws_call_no_function_of_a_library"
POISSON = "spec/test_laws.py::test_poisson_is_the_smallest_count_that_reaches_u"
INVERSE = "spec/test_distributions.py::test_inverse_is_that_of_scipy"
LIMITS = "physics/test_thrusters.py::test_limits_are_those_of_the_zonotope"
VERSIONS = "run/test_identity.py::test_versions_that_change_no_bit_are_not_part_of_it"

MUTANTS = (
    Mutant("erfc: a coefficient off by 1e-12", TAIL, "1.2329951186255526", "1.2329951186265526", DIGITS),
    Mutant("erfc: x² without its last digits", TAIL, "exp(-share * ((size - h) * (size + h)))", "exp(size * 0.0)", DIGITS),
    Mutant("Φ: one tail for both", NORMAL, "xp.where(x < 0.0, beyond, 1.0 - beyond)", "beyond", DIGITS),
    Mutant("Φ⁻¹: a wrong digit", NORMAL, "1.9715909503065514427e3", "1.9715909503165514427e3", QUOTIENTS),
    Mutant("Φ⁻¹: the far tail as the near one", NORMAL, "xp.where(r > 5.0,", "xp.where(r > 50.0,", DIGITS),
    Mutant("Φ⁻¹: an end is no number", NORMAL, "size = xp.where(r < xp.inf, size, r)", "size = size * 1.0", ENDS),
    Mutant("Φ⁻¹: both sides alike", NORMAL, "xp.where(q < 0.0, -size, size))", "size)", DIGITS),
    Mutant("Φ⁻¹ of a logarithm: e^y alone", NORMAL, "-log(-expm1(xp.where(low, -1.0, y)))", "-log(1.0 - exp(y))", LOGARITHMS),
    Mutant(
        "beta: a wrong sign in the fraction", BETA, "a * y - b * x + 1.0 + m * (1.0 + y)", "a * y - b * x + 1.0 - m * y", BETAS
    ),
    Mutant(
        "beta: 1 for 1 − u",
        BETA,
        "_solved(right, 1.0 - flat[above], flat[above])",
        "_solved(right, flat[above], flat[above])",
        BETAS,
    ),
    Mutant("beta: a step too few", BETA, "_ENOUGH = 1e-7", "_ENOUGH = 1e-1", BETAS),
    Mutant("beta: a start without an end", BETA, "np.where(lower < upper, -ndtri(lower), ndtri(upper))", "-ndtri(lower)", SHAPES),
    Mutant(
        "beta: steps for all together",
        BETA,
        "going[now] = (np.abs(step) > _ENOUGH) & (x[now] != old)",
        "going[now] = np.any(np.abs(step) > _ENOUGH) & (x[now] != old)",
        ALONE,
    ),
    Mutant("ln Γ: series cut short", "elementary/log_gamma.py", "_TERMS = 22", "_TERMS = 12", GAMMA),
    Mutant(
        "NumPy: a constant of float64",
        "elementary/formats.py",
        "where(condition, yes, no).astype(x.dtype)",
        "where(condition, yes, no)",
        NUMPY,
    ),
    Mutant("NumPy: a lost dimension", "elementary/formats.py", ".reshape(rows[0].shape)[()]", "", SHAPE),
    Mutant(
        "length: too few digits",
        "elementary/lengths.py",
        "root |= root * root != square",
        "root = root >> 150 << 150",
        LENGTHS,
    ),
    Mutant(
        "pseudo-inverse: its transpose",
        "elementary/pseudo_inverse.py",
        "_product(column, row) for row in inverse",
        "_product(column, row) for row in reversed(inverse)",
        INVERSES,
    ),
    Mutant(
        "thrusters: a bound passed",
        "campaign/linear_program.py",
        "self.values[i] - top) / fall",
        "self.values[i] - 2.0 * top) / fall",
        LIMITS,
    ),
    Mutant("thrusters: one push for both", "campaign/linear_program.py", "-float(e[i])", "-abs(e[i])", LIMITS),
    Mutant("log-uniform: NumPy's exp", f"{LAWS}/bounded.py", "np.clip(exp(", "np.clip(np.exp(", GOLDEN),
    Mutant("a tilt by NumPy", "simulation/inertia.py", "* tan(0.25 * tilt)", "* np.tan(0.25 * tilt)", PLAIN),
    Mutant(
        "an order by the processor",
        "campaign/schedule.py",
        'order.argsort(axis=0, kind="stable")',
        "order.argsort(axis=0)",
        PLAIN,
    ),
    Mutant("Poisson: 1 − F by a count off", f"{LAWS}/discrete.py", "reversed(shares[1:])", "reversed(shares[:-1])", POISSON),
    Mutant("Poisson: rounded shares", f"{LAWS}/discrete.py", "Context(prec=30)", "Context(prec=9)", POISSON),
    Mutant("half normal: u for u/2", f"{LAWS}/normal.py", "ndtri_centred(0.5 * array(u))", "ndtri_centred(array(u))", INVERSE),
    Mutant(
        "versions of NumPy in every identity",
        "execution/identity.py",
        "*(COMPUTING if others else ()),",
        "*COMPUTING,",
        VERSIONS,
    ),
    Mutant("Sobol without its versions", "components/samplers/sobol.py", ', packages=("numpy", "scipy")', "", VERSIONS),
)
