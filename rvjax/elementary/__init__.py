"""Elementary functions by arithmetic only: sums, products, quotients, roots, comparisons and bits, no call of a library.

Their bits depend on neither the C library, the processor nor the version of NumPy. float64 and float32, and float64 alone for the
normal law and erfc; the type of the result is that of the argument. Errors: TypeError for other types.

They take numbers and arrays of NumPy and arrays of JAX; `rvjax.physics.elementary` gives those of JAX their derivatives. The
largest errors that they name are those against mpmath of
`pytest -s --slow -k many_numbers tests/elementary tests/physics/test_elementary.py`, subnormal numbers included.
"""

from rvjax.elementary.complementary_error_function import erfc, erfcx
from rvjax.elementary.cube_root import cbrt
from rvjax.elementary.error_function import erf
from rvjax.elementary.exponential import exp, exp2, expm1
from rvjax.elementary.hyperbolic import cosh, sinh, tanh
from rvjax.elementary.inverse_hyperbolic import acosh, asinh, atanh
from rvjax.elementary.inverse_trigonometric import acos, asin, atan, atan2
from rvjax.elementary.lengths import length
from rvjax.elementary.logarithms import log, log1p, log2
from rvjax.elementary.normal import log_ndtr, ndtr, ndtri, ndtri_centred, ndtri_exp
from rvjax.elementary.powers import integer_power, power
from rvjax.elementary.tangent import tan
from rvjax.elementary.trigonometric import cos, sin

__all__ = [
    "acos",
    "acosh",
    "asin",
    "asinh",
    "atan",
    "atan2",
    "atanh",
    "cbrt",
    "cos",
    "cosh",
    "erf",
    "erfc",
    "erfcx",
    "exp",
    "exp2",
    "expm1",
    "integer_power",
    "length",
    "log",
    "log1p",
    "log2",
    "log_ndtr",
    "ndtr",
    "ndtri",
    "ndtri_centred",
    "ndtri_exp",
    "power",
    "sin",
    "sinh",
    "tan",
    "tanh",
]
