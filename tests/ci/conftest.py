"""Run folders with made-up flights."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.report.conftest import made

__all__ = ["before", "made"]


@pytest.fixture(scope="session")
def before(made: Callable[..., Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two hundred samples."""
    return made(tmp_path_factory.mktemp("before") / "run", 200, (0.9, 0.08, 0.02), kept=0)
