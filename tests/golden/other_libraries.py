"""A process whose libraries choose the functions of an older processor."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

WITHOUT = "-AVX512F,-AVX512VL,-AVX512BW,-AVX512DQ,-AVX512CD,-AVX2,-AVX2_Usable,-FMA,-FMA_Usable,-FMA4,-AVX,-SSE4_2,-SSE4_1"
"""What the C library must do without."""

SWITCHES = pytest.mark.skipif(
    platform.machine() not in ("x86_64", "AMD64"), reason="the libraries of other processors have no such switches"
)


def dispatched() -> list[str]:
    """The features of this processor that NumPy chooses its functions by."""
    known: Any = np._core._multiarray_umath  # pyright: ignore
    return [name for name in known.__cpu_dispatch__ if known.__cpu_features__[name]]


OLDER = {"NPY_DISABLE_CPU_FEATURES": " ".join(dispatched()), "GLIBC_TUNABLES": f"glibc.cpu.hwcaps={WITHOUT}"}


def elsewhere(code: str, **environment: str) -> str:
    """What Python code prints in a process with these variables."""
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=os.environ | {"JAX_PLATFORMS": "cpu"} | environment,
        cwd=Path(__file__).parents[2],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout
