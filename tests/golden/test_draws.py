"""Draws are those that are written down, on any processor, with any C library."""

from __future__ import annotations

import json

import pytest

from rvjax.campaign.distribution_notation import SCALAR_WORDS, VECTOR_WORDS
from tests.golden.digests import EVERY_LAW, STORED, cases, digests
from tests.golden.other_libraries import OLDER, SWITCHES, dispatched, elsewhere

HOW = "if the change is meant: python -m tests.golden.digests --write"


def stored() -> dict[str, str]:
    return json.loads(STORED.read_text(encoding="utf-8"))


def test_draws_are_those_that_are_written_down() -> None:
    """Kills: a changed last digit of any draw."""
    assert digests() == stored(), HOW


@SWITCHES
def test_the_processor_changes_no_draw() -> None:
    """NumPy and the C library without what a newer processor has. Kills: a function of a library on the way to a draw."""
    code = "import runpy; runpy.run_module('tests.golden.digests', run_name='__main__')"
    found = elsewhere(code, **OLDER)
    assert json.loads(found) == stored()


@SWITCHES
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
