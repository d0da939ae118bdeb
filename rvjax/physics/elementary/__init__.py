"""Elementary functions by arithmetic only: sums, products, quotients, roots, comparisons and bits, no call of a library.

Their bits depend on neither the C library nor the width of a vector register. float64 and float32; the type of the result is
that of the argument. Errors: TypeError for other types.

The largest errors that the functions name are those against mpmath of
`pytest -s --slow -k many_numbers tests/physics/test_elementary.py`, subnormal arguments and results included.
"""

from rvjax.physics.elementary.cube_root import cbrt
from rvjax.physics.elementary.error_function import erf
from rvjax.physics.elementary.exponential import exp, exp2, expm1
from rvjax.physics.elementary.hyperbolic import cosh, sinh, tanh
from rvjax.physics.elementary.inverse_hyperbolic import acosh, asinh, atanh
from rvjax.physics.elementary.inverse_trigonometric import acos, asin, atan, atan2
from rvjax.physics.elementary.logarithms import log, log1p, log2
from rvjax.physics.elementary.powers import integer_power, power
from rvjax.physics.elementary.tangent import tan
from rvjax.physics.elementary.trigonometric import cos, sin

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
    "exp",
    "exp2",
    "expm1",
    "integer_power",
    "log",
    "log1p",
    "log2",
    "power",
    "sin",
    "sinh",
    "tan",
    "tanh",
]
