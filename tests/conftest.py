"""Shared by all tests: the process is configured for flying before anything uses JAX."""

from __future__ import annotations

import functools
import os
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import hypothesis
import pytest
import typer

from rvjax.simulation import jax_config
from tests.program import Run
from tests.short import CAMPAIGN, SHORT

jax_config.configure("float64")
hypothesis.settings.register_profile("untimed", deadline=None)  # a busy machine is no failure
hypothesis.settings.register_profile("ci", deadline=None, derandomize=True)  # CI tests the same examples each time
hypothesis.settings.load_profile("ci" if os.environ.get("CI") else "untimed")

typer.main.get_command = functools.cache(typer.main.get_command)
"""The command line is put together once, as in a process of a user: 20 ms, which thousands of calls in one process would pay."""

FIGURE = "figure"


def pytest_addoption(parser: pytest.Parser) -> None:
    """`--mutants`: the mutants of the flying half as well, each in a process of its own (minutes).
    `--acceptance`: the scenarios of the documentation at their full size (minutes).
    `--long`: the reliability suite in its full numbers (an hour).
    """
    parser.addoption("--mutants", action="store_true", help="run the mutants of the flying half (minutes)")
    parser.addoption("--acceptance", action="store_true", help="fly the documented scenarios at full size (minutes)")
    parser.addoption("--long", action="store_true", help="the reliability suite in its full numbers (minutes)")


@pytest.fixture
def full(request: pytest.FixtureRequest) -> bool:
    """Whether the reliability suite runs in its full numbers."""
    return bool(request.config.getoption("--long"))


@pytest.fixture
def figure(record_property: Callable[[str, Any], None]) -> Callable[[str], None]:
    """Puts a line among the figures that the test run ends with."""
    return lambda line: record_property(FIGURE, line)


@pytest.fixture
def bare(monkeypatch: pytest.MonkeyPatch) -> None:
    """Reports without sections, for tests that are not about them: drawing takes longer than a short campaign."""
    monkeypatch.setattr("rvjax.report.sections.SECTIONS", ())


@pytest.fixture
def rvjax(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """Runs the program in this process: (exit code, stdout, stderr)."""
    from rvjax.cli import main

    def run(*arguments: object) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["rvjax", *map(str, arguments)])
        with pytest.raises(SystemExit) as ended:
            main()
        assert isinstance(ended.value.code, int)
        return (ended.value.code, *capsys.readouterr())

    return run


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
    """The run folder of the short campaign; of the report only the section that draws nothing."""
    from rvjax.execution.run import run
    from rvjax.report import sections

    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.setattr(sections, "SECTIONS", (sections.provenance.section,))
        return run(CAMPAIGN, tmp_path_factory.mktemp("flown") / "run", SHORT)
