"""Yardsticks: other ways to fly the same samples through the same closed loop, for `rvjax bench`.

Each module has `prepare(case)`: a function that flies `rvjax.execution.bench.workload.Case` and returns the carry at its
end, or raises `UnavailableError` with what is lacking.
"""

YARDSTICKS = {
    "plain_vmap": "benchmarks.plain_vmap",
    "diffrax": "benchmarks.diffrax_rk4",
    "numpy": "benchmarks.numpy_batch",
    "scalar_c": "benchmarks.scalar_c",
    "simd_c": "benchmarks.simd_c",
}
