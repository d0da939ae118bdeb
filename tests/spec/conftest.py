"""A campaign file to start from."""

from __future__ import annotations

from pathlib import Path

import pytest

GOOD = Path(__file__).parent / "good.yaml"


@pytest.fixture
def good() -> Path:
    """Every section, most of the forms."""
    return GOOD
