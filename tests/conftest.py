"""Shared by all tests: the process is configured for flying before anything uses JAX."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import pytest

from rvjax import process
from tests.short import CAMPAIGN, SHORT

process.configure("float64")

FIGURE = "figure"


def pytest_addoption(parser: pytest.Parser) -> None:
    """`--mutants`: the mutants of the flying half as well, each in a process of its own (minutes).
    `--acceptance`: the scenarios of the documentation at their full size (minutes).
    `--long`: kills, damage, fuzzed files and injected texts in their full numbers (tens of minutes).
    """
    parser.addoption("--mutants", action="store_true", help="run the mutants of the flying half (minutes)")
    parser.addoption("--acceptance", action="store_true", help="fly the documented scenarios at full size (minutes)")
    parser.addoption("--long", action="store_true", help="the reliability suite in its full numbers (tens of minutes)")


@pytest.fixture
def full(request: pytest.FixtureRequest) -> bool:
    """Whether the reliability suite runs in its full numbers."""
    return bool(request.config.getoption("--long"))


@pytest.fixture
def figure(record_property: Callable[[str, Any], None]) -> Callable[[str], None]:
    """Puts a line among the figures that the test run ends with."""
    return lambda line: record_property(FIGURE, line)


def pytest_terminal_summary(terminalreporter: Any) -> None:
    """The figures that tests have reported, from whichever process."""
    reports: Iterable[Any] = terminalreporter.stats.get("passed", [])
    lines = sorted({str(line) for report in reports for name, line in report.user_properties if name == FIGURE})
    if lines:
        terminalreporter.section("figures of the reliability suite")
        for line in lines:
            terminalreporter.write_line(line)


@pytest.fixture(scope="session")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The run folder of the short campaign."""
    from rvjax.run import run

    return run(CAMPAIGN, tmp_path_factory.mktemp("flown") / "run", SHORT)
