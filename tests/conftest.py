"""Shared by all tests: the process is configured for flying before anything uses JAX."""

from __future__ import annotations

import functools
import gc
import os
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import hypothesis
import pytest
import typer

from rvjax.simulation import jax_config
from tests.once import made_once
from tests.program import Run
from tests.short import CAMPAIGN, SHORT
from tests.slow import SLOW

jax_config.configure("float64")
hypothesis.settings.register_profile("untimed", deadline=None)  # a busy machine is no failure
hypothesis.settings.register_profile("ci", deadline=None, derandomize=True)  # CI tests the same examples each time
found = (hypothesis.Phase.explicit, hypothesis.Phase.generate)
hypothesis.settings.register_profile("mutant", deadline=None, derandomize=True, phases=found)  # that it fails is enough
hypothesis.settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE") or ("ci" if os.environ.get("CI") else "untimed"))

typer.main.get_command = functools.cache(typer.main.get_command)
"""The command line is put together once, as in a process of a user: 20 ms, which thousands of calls in one process would pay."""

FIGURE = "figure"

FIRST = ("reliability", "run", "report", "physics", "tuning", "ci", "cli")
"""Folders with the longest tests: they start first, so that no worker is left alone with one of them at the end."""


SHARED = {f"tests/physics/test_{name}.py" for name in ("adaptation", "baselines", "dynamics", "flight", "metrics", "oracle")}
"""Files that fly the compiled flights of tests/physics/conftest.py."""


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """All tests of a file go to one worker, and so do those that share the flights of `SHARED`: no fixture is built twice."""
    from xdist.scheduler import LoadFileScheduling

    class Scheduling(LoadFileScheduling):
        def _split_scope(self, nodeid: str) -> str:
            file = nodeid.partition("::")[0]
            return "shared flights" if file in SHARED else file

    config.option.loadscopereorder = False
    return Scheduling(config, log)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """The folders of `FIRST` come first; otherwise the order stays. The tests of `SLOW` wait for their option."""
    root = Path(__file__).parent
    if not (config.getoption("--slow") or config.getoption("--long")):
        for item in items:
            name = item.nodeid.removeprefix(f"{root.name}/")
            if {name, name.partition("[")[0], name.partition("::")[0]} & SLOW:
                item.add_marker(pytest.mark.skip(reason="takes several seconds: --slow"))

    def place(item: pytest.Item) -> int:
        folder = item.path.relative_to(root).parts[0] if item.path.is_relative_to(root) else ""
        return FIRST.index(folder) if folder in FIRST else len(FIRST)

    items.sort(key=place)


def pytest_collection_finish(session: pytest.Session) -> None:
    """What is imported and collected by now stays: the garbage collector need not look at it again and again."""
    del session
    gc.collect()
    gc.freeze()


def pytest_addoption(parser: pytest.Parser) -> None:
    """`--mutants`: the mutants as well, each in a separate process (minutes).
    `--acceptance`: the scenarios of the documentation at their full size (minutes).
    `--slow`: the tests of `tests/slow.py` too (tens of minutes).
    `--long`: those, and the reliability suite in its full numbers (an hour).
    """
    parser.addoption("--mutants", action="store_true", help="run the mutants (minutes)")
    parser.addoption("--acceptance", action="store_true", help="fly the documented scenarios at full size (minutes)")
    parser.addoption("--slow", action="store_true", help="run the tests that take several seconds each (minutes)")
    parser.addoption("--long", action="store_true", help="those, and the reliability suite in full numbers (an hour)")


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
    """The run folder of the short campaign, for all workers; of the report only the section that draws nothing."""
    from rvjax.execution.run import run
    from rvjax.report import sections

    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.setattr(sections, "SECTIONS", (sections.provenance.section,))
        return made_once(tmp_path_factory, "flown", lambda path: run(CAMPAIGN, path, SHORT))
