"""Plugin of pytest: `pytest --rvjax campaigns/ci/` makes every requirement of every campaign there a test.

A campaign is flown once, when the first of its requirements is run, until all are decided. FAIL fails with the verdict's
sentence; UNDECIDED is an outcome of its own, which fails unless `--rvjax-undecided=pass` (or `rvjax_undecided` in the
configuration) says otherwise. Without `--rvjax` nothing is collected and nothing heavy imported.
"""

from __future__ import annotations

import fcntl
import os
import re
import tempfile
from collections.abc import Generator, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from rvjax.check import Verdict
    from rvjax.spec import Requirement

UNDECIDED = "undecided"
CAMPAIGN = re.compile(rb"^rvjax\s*:", re.MULTILINE)
"""What a YAML file has that is a campaign."""

_VERDICT = "rvjax_verdict"


def pytest_addoption(parser: pytest.Parser) -> None:
    """The options of the plugin."""
    group = parser.getgroup("rvjax", "robustness campaigns")
    group.addoption("--rvjax", action="store_true", help="collect campaigns (*.yaml): each requirement is a test")
    group.addoption("--rvjax-out", metavar="DIR", help="where the run folders go; default: a new temporary folder")
    group.addoption("--rvjax-undecided", choices=("fail", "pass"), help="what an undecided requirement does; default: fail")
    parser.addini("rvjax_undecided", "what an undecided requirement does: fail or pass", default="fail")


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> pytest.Collector | None:
    """Campaign files, where they are asked for."""
    if not parent.config.getoption("--rvjax") or file_path.suffix not in (".yaml", ".yml"):
        return None
    if not CAMPAIGN.search(file_path.read_bytes()):
        return None
    return CampaignFile.from_parent(parent, path=file_path)


class CampaignFile(pytest.File):
    """A campaign; its requirements are its items."""

    _verdicts: tuple[Verdict, ...] | None = None
    folder: Path | None = None

    def collect(self) -> Iterable[pytest.Item]:
        """The requirements. A mistake in the campaign is one of collecting it, with its places."""
        from rvjax import spec
        from rvjax.check.words import title
        from rvjax.errors import CampaignError

        try:
            campaign = spec.load(self.path)
        except CampaignError as error:
            raise self.CollectError(str(error)) from None
        for number, requirement in enumerate(campaign.require, 1):
            item: RequirementItem = RequirementItem.from_parent(self, name=f"[{number}] {title(requirement)}")
            item.number, item.requirement = number, requirement
            item.add_marker(pytest.mark.xdist_group(str(self.path)))
            yield item

    def verdicts(self) -> tuple[Verdict, ...]:
        """Flies the campaign unless it is flown; processes beside each other fly it once."""
        if self._verdicts is None:
            from rvjax.check import judge_folder
            from rvjax.run import run

            root = _root(self.config)
            self.folder = root / re.sub(r"[^\w.-]+", "-", self.path.relative_to(self.config.rootpath).with_suffix("").as_posix())
            with _alone(root, self.folder.name):
                run(self.path, self.folder, until_decided=True)
            self._verdicts = judge_folder(self.folder)
        return self._verdicts


class RequirementItem(pytest.Item):
    """One requirement."""

    number: int
    requirement: Requirement

    def runtest(self) -> None:
        """Passes where the verdict is PASS."""
        from rvjax.errors import RvjaxError

        campaign = self.parent
        assert isinstance(campaign, CampaignFile)
        try:
            verdict = campaign.verdicts()[self.number - 1]
        except RvjaxError as error:
            raise NotShown("ERROR", str(error)) from None
        if verdict.verdict != "PASS":
            raise NotShown(verdict.verdict, f"{verdict.text}\n{_advice(campaign.folder)}")

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """The verdict's sentence; a traceback only of what nobody foresaw."""
        if isinstance(excinfo.value, NotShown):
            return str(excinfo.value)
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[os.PathLike[str], int | None, str]:
        """Path, line and name."""
        return self.path, None, self.name


class NotShown(Exception):
    """A requirement that is not shown to hold. verdict: FAIL, UNDECIDED, or ERROR where it could not be judged."""

    def __init__(self, verdict: str, text: str) -> None:
        super().__init__(text)
        self.verdict = verdict


def _advice(folder: Path | None) -> str:
    """Where the report is, and how the worst sample flies again."""
    if folder is None:
        return ""
    from rvjax.results import RunFolder

    kept = RunFolder.open(folder).trace_samples()
    again = f"\nrvjax replay {folder} --sample {kept[0]}" if kept else ""
    return f"report: {folder / 'report.html'}{again}"


def _root(config: pytest.Config) -> Path:
    """The folder of all run folders: the same for all processes of a session."""
    if said := config.getoption("--rvjax-out"):
        root = Path(said)
    else:
        session = os.environ.get("PYTEST_XDIST_TESTRUNUID") or f"{os.getpid()}"
        root = Path(tempfile.gettempdir()) / f"rvjax-pytest-{session}"
    root.mkdir(parents=True, exist_ok=True)
    return root.absolute()


@contextmanager
def _alone(root: Path, name: str) -> Iterator[None]:
    """One process at a time."""
    with (root / f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Notes the verdict in the report, which processes send to each other."""
    report = yield
    if call.excinfo is not None and isinstance(call.excinfo.value, NotShown):
        setattr(report, _VERDICT, call.excinfo.value.verdict)
        said = item.config.getoption("--rvjax-undecided") or item.config.getini("rvjax_undecided")
        if call.excinfo.value.verdict == "UNDECIDED" and said == "pass":
            report.outcome = "passed"
    return report


def pytest_report_teststatus(report: pytest.TestReport) -> tuple[str, str, tuple[str, dict[str, bool]]] | None:
    """UNDECIDED is neither passed nor failed."""
    if getattr(report, _VERDICT, None) == "UNDECIDED":
        return UNDECIDED, "u", ("UNDECIDED", {"yellow": True})
    return None


def pytest_terminal_summary(terminalreporter: Any) -> None:
    """The sentences of the undecided."""
    reports: list[pytest.TestReport] = terminalreporter.stats.get(UNDECIDED, [])
    if reports:
        terminalreporter.section("undecided requirements")
        for report in reports:
            terminalreporter.write_line(f"{report.nodeid}\n{report.longreprtext}")
