"""Shared by all tests: the process is configured for flying before anything uses JAX."""

from __future__ import annotations

from pathlib import Path

import pytest

from rvjax import process
from tests.short import CAMPAIGN, SHORT

process.configure("float64")


def pytest_addoption(parser: pytest.Parser) -> None:
    """`--mutants`: the mutants of the flying half as well, each in a process of its own (minutes).
    `--acceptance`: the scenarios of the documentation at their full size (minutes).
    """
    parser.addoption("--mutants", action="store_true", help="run the mutants of the flying half (minutes)")
    parser.addoption("--acceptance", action="store_true", help="fly the documented scenarios at full size (minutes)")


@pytest.fixture(scope="session")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The run folder of the short campaign."""
    from rvjax.run import run

    return run(CAMPAIGN, tmp_path_factory.mktemp("flown") / "run", SHORT)
