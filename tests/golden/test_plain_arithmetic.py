"""Where draws and constants of a flight are computed, no function is called whose bits depend on the machine or on a version.

NumPy's + − × ÷ √, comparisons, rounding, bits, cumulative sums and searches are the same everywhere, so are math.sqrt, fsum and
ldexp. All others are listed here, each with the reason why no draw and no constant of a flight depends on it.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import rvjax

ROOT = Path(rvjax.__file__).parent

DRAWING = ("campaign", "components", "elementary", "physics", "simulation", "stats/random_streams.py")

OF_MATH = {
    *("acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "cbrt", "cos", "cosh", "dist", "erf", "erfc"),
    *("exp", "exp2", "expm1", "fma", "gamma", "hypot", "lgamma", "log", "log10", "log1p", "log2", "pow", "sin"),
    *("sinh", "sumprod", "tan", "tanh"),
}
OF_NUMPY = {
    *("arccos", "arccosh", "arcsin", "arcsinh", "arctan", "arctan2", "arctanh", "average", "cbrt", "convolve"),
    *("corrcoef", "cos", "cosh", "cov", "dot", "einsum", "exp", "exp2", "expm1", "fft", "float_power"),
    *("geomspace", "histogram", "hypot", "i0", "inner", "interp", "linalg", "log", "log10", "log1p", "log2"),
    *("logaddexp", "logaddexp2", "logspace", "matmul", "mean", "nanmean", "nansum", "percentile", "polyfit"),
    *("polyval", "power", "quantile", "random", "sin", "sinc", "sinh", "std", "sum", "tan", "tanh"),
    *("tensordot", "trapezoid", "var", "vdot"),
}
METHODS = {"argsort", "dot", "mean", "std", "sum", "var"}
"""Of arrays; argsort without kind="stable" has equal numbers in an order that depends on the processor."""

LAW = "the distribution function, for tests and words; draws go through its inverse"
CHECK = "accepts or refuses a campaign, or warns; no number of it flies"
INTEGERS = "whole numbers, whose sum is exact"
PHILOX = "a bit generator, whose stream is fixed by its definition"
SEARCH = "proposes points of a search; those it flies are written down with four digits, or kept in its folder"

REASONS = {
    ("campaign/correlation.py", "np.linalg"): CHECK,
    ("campaign/correlation.py", "**"): CHECK,
    ("campaign/distributions/bounded.py", "scipy"): LAW,
    ("campaign/distributions/discrete.py", "scipy"): LAW,
    ("campaign/inertia.py", "np.linalg"): CHECK,
    ("campaign/inertia.py", "**"): CHECK,
    ("campaign/named_files.py", "**"): CHECK,
    ("campaign/propellant.py", "np.linalg"): CHECK,
    ("campaign/quantity.py", "np.mean"): "of two numbers: their sum, rounded once, by 2",
    ("campaign/thruster_layout.py", "np.linalg"): CHECK,
    ("components/effect.py", "np.sum"): CHECK,
    ("components/wrench_over_time.py", "np.interp"): CHECK,
    ("components/wrench_over_time.py", "np.sum"): CHECK,
    ("components/wrench_over_time.py", "np.trapezoid"): CHECK,
    ("components/wrench_over_time.py", "**"): CHECK,
    ("components/samplers/latin_hypercube.py", "np.random"): PHILOX,
    ("components/samplers/sobol.py", "np.random"): "the versions of NumPy and SciPy are part of the identity",
    ("components/samplers/sobol.py", "scipy"): "the versions of NumPy and SciPy are part of the identity",
    ("components/samplers/values_table.py", "np.linalg"): CHECK,
    ("components/search_methods/cma_es.py", "math.log"): SEARCH,
    ("components/search_methods/cma_es.py", "np.random"): SEARCH,
    ("components/search_methods/gradient.py", "@"): SEARCH,
    ("components/search_methods/gradient.py", "np.linalg"): SEARCH,
    ("components/search_methods/grid.py", "**"): SEARCH,
    ("components/search_methods/point_sets.py", "np.random"): SEARCH,
    ("components/search_methods/point_sets.py", "scipy"): SEARCH,
    ("simulation/draws.py", "np.sum"): INTEGERS,
    ("simulation/plausibility.py", "math.hypot"): CHECK,
    ("simulation/plausibility.py", "**"): CHECK,
    ("simulation/plausibility.py", ".sum()"): CHECK,
    ("simulation/rejection_sampling.py", "np.mean"): CHECK,
    ("simulation/requirement_checks.py", "math.log"): CHECK,
    ("simulation/scene_checks.py", ".mean()"): CHECK,
    ("simulation/scene_checks.py", "@"): CHECK,
    ("simulation/scene_checks.py", "np.linalg"): CHECK,
    ("simulation/scene_checks.py", "np.sum"): CHECK,
    ("simulation/start_zone.py", "@"): CHECK,
    ("simulation/start_zone.py", "np.linalg"): CHECK,
    ("stats/random_streams.py", "np.random"): PHILOX,
}
"""(File, what is called) → why no draw depends on it. Functions of JAX are the engine's work."""

OF_JAX = {
    "components/forms/measured.py",
    "components/metrics/keep_out.py",
    "physics/backstepping.py",
    "physics/riccati.py",
}
"""Files whose operators @ and ** act on arrays of JAX."""


def called(tree: ast.AST) -> Iterator[str]:
    """What a module uses of the functions above: `math.exp`, `np.linalg`, `scipy`, `@`, `**`."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            home = {"numpy": "np"}.get(node.value.id, node.value.id)
            if (home == "math" and node.attr in OF_MATH) or (home == "np" and node.attr in OF_NUMPY):
                yield f"{home}.{node.attr}"
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in METHODS:
            stable = any(word.arg == "kind" and getattr(word.value, "value", "") == "stable" for word in node.keywords)
            home = getattr(node.func.value, "id", "")
            if home not in ("jnp", "xp") and not stable and not (home in ("np", "numpy") and node.func.attr in OF_NUMPY):
                yield f".{node.func.attr}()"
        elif isinstance(node, ast.ImportFrom) and node.module in ("math", "numpy", "cmath"):
            yield from (f"{node.module}.{name.name}" for name in node.names if name.name in OF_MATH | OF_NUMPY)
        elif isinstance(node, ast.BinOp | ast.AugAssign) and isinstance(node.op, ast.MatMult):
            yield "@"
        elif isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow) and not harmless(node):
            yield "**"
        yield from ("scipy" for name in imported(node) if name.partition(".")[0] == "scipy")


def imported(node: ast.AST) -> Iterator[str]:
    """The modules that a statement imports, also by `import_module("…")`."""
    if isinstance(node, ast.Import):
        yield from (name.name for name in node.names)
    elif isinstance(node, ast.ImportFrom):
        yield node.module or ""
    elif isinstance(node, ast.Call) and node.args and isinstance(node.args[0], ast.Constant):
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        if name == "import_module":
            yield str(node.args[0].value)


def harmless(power: ast.BinOp) -> bool:
    """A whole power of 2 or 10, which is exact."""
    return isinstance(power.left, ast.Constant) and power.left.value in (2, 10)


def found() -> set[tuple[str, str]]:
    """(File, what is called) of all that draws."""
    files = [file for part in DRAWING for file in ((ROOT / part).rglob("*.py") if (ROOT / part).is_dir() else (ROOT / part,))]
    calls = ((file.relative_to(ROOT).as_posix(), call) for file in files for call in called(ast.parse(file.read_text("utf-8"))))
    return {(file, call) for file, call in calls if not (file in OF_JAX and call in ("@", "**"))}


def test_draws_call_no_function_of_a_library() -> None:
    """Kills: np.exp in a law, linalg in a constant of a flight. What is listed must still be there."""
    assert found() - REASONS.keys() == set()
    assert REASONS.keys() - found() == set()


def test_the_check_sees_what_it_is_to_see() -> None:
    """Each way to call a function of a library."""
    code = (
        "import scipy.special as s\nfrom math import exp\nfrom numpy import log\nx = math.sin(1.0)\ny = np.linalg.pinv(a) @ b\n"
        "z = import_module('scipy.optimize')\nx.argsort(), x.argsort(kind='stable'), x.sum()\n"
        "w = a ** b + 2.0 ** k + a ** 2\nnumpy.cos(x)"
    )
    expected = {"scipy", "math.exp", "numpy.log", "math.sin", "np.linalg", "@", "**", "np.cos", ".argsort()", ".sum()"}
    assert set(called(ast.parse(code))) == expected
