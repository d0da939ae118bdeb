"""Elementary functions by arithmetic only: sums, products, quotients, roots, comparisons and bits, no call of a library.

Their bits depend on neither the C library nor the width of a vector register. float64 and float32; the type of the result is
that of the argument. Errors: TypeError for other types.

The largest errors that the functions name are those against mpmath of
`pytest -s --slow -k many_numbers tests/physics/test_elementary.py`, subnormal arguments and results included.
"""

from rvjax.physics.elementary.error_function import erf
from rvjax.physics.elementary.exponential import exp, expm1
from rvjax.physics.elementary.hyperbolic import tanh
from rvjax.physics.elementary.logarithms import log, log1p, log2
from rvjax.physics.elementary.trigonometric import cos, sin

__all__ = ["cos", "erf", "exp", "expm1", "log", "log1p", "log2", "sin", "tanh"]
