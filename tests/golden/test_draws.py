"""Draws are those that are written down, on any processor, with any C library."""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rvjax.campaign.distribution_notation import SCALAR_WORDS, VECTOR_WORDS
from tests.golden.digests import EVERY_LAW, STORED, cases, digests

HOW = "if the change is meant: python -m tests.golden.digests --write"

WITHOUT = "-AVX512F,-AVX512VL,-AVX512BW,-AVX512DQ,-AVX512CD,-AVX2,-AVX2_Usable,-FMA,-FMA_Usable,-FMA4,-AVX,-SSE4_2,-SSE4_1"
"""What the C library must do without."""


def dispatched() -> list[str]:
    """The features of this processor that NumPy chooses its functions by."""
    known: Any = np._core._multiarray_umath  # pyright: ignore
    return [name for name in known.__cpu_dispatch__ if known.__cpu_features__[name]]


def stored() -> dict[str, str]:
    return json.loads(STORED.read_text(encoding="utf-8"))


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


def test_draws_are_those_that_are_written_down() -> None:
    """Kills: a changed last digit of any draw."""
    assert digests() == stored(), HOW


@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="other processors have no such switches")
def test_the_processor_changes_no_draw() -> None:
    """NumPy and the C library without what a newer processor has. Kills: a function of a library on the way to a draw."""
    code = "import runpy; runpy.run_module('tests.golden.digests', run_name='__main__')"
    found = elsewhere(code, NPY_DISABLE_CPU_FEATURES=" ".join(dispatched()), GLIBC_TUNABLES=f"glibc.cpu.hwcaps={WITHOUT}")
    assert json.loads(found) == stored()


@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="other processors have no such switches")
@pytest.mark.skipif("AVX2" not in str(dispatched()) and "V3" not in str(dispatched()), reason="NumPy has nothing to choose here")
def test_the_switches_switch() -> None:
    """Without them NumPy's own exp has other bits: what the test above finds equal could have been different."""
    code = "import hashlib, numpy as np; print(hashlib.sha256(np.exp(np.linspace(-30, 30, 100001)).tobytes()).hexdigest())"
    assert elsewhere(code) != elsewhere(code, NPY_DISABLE_CPU_FEATURES=" ".join(dispatched()))


def test_every_law_is_among_them() -> None:
    """Kills: a law that is added without its draws being written down."""
    text = EVERY_LAW.read_text(encoding="utf-8")
    assert [word for word in (*SCALAR_WORDS, *VECTOR_WORDS) if f"{word}:" not in text] == []
    assert set(cases()) <= set(stored())
