"""Kinds of processors, for which code is made and run wherever the processor of the tests can."""

from __future__ import annotations

import platform

import llvmlite.binding as llvm
import pytest

from rvjax.simulation.engines.llvm.machine_code import Target

AVX2 = "+avx2,+avx,+sse4.2,+fma,-avx512f"
TARGETS = {
    "AVX-512": Target("skylake-avx512", "", 8),
    "AVX2": Target("haswell", AVX2, 4),
    "SSE2": Target("x86-64", "", 2),
    "16 lanes": Target("haswell", AVX2, 16),
}


def can_run(kind: str) -> None:
    """Skips the test where this processor cannot run such code."""
    if platform.machine() not in ("x86_64", "AMD64"):
        pytest.skip("the instructions are those of x86")
    if kind == "AVX-512" and not llvm.get_host_cpu_features().get("avx512f"):
        pytest.skip("this processor has no AVX-512")
