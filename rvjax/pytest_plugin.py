"""Plugin of pytest: `pytest --rvjax campaigns/ci/` makes every requirement of every campaign there a test.

A campaign is flown once, when the first of its requirements is run, until all are decided. `rvjax check` flies it in a separate
process, since JAX is configured before it starts and other tests may use other settings. FAIL fails with the verdict's sentence.
UNDECIDED is a separate outcome, which fails unless `--rvjax-undecided=pass` (or `rvjax_undecided` in the configuration) says
otherwise. Without `--rvjax` nothing is collected and nothing heavy imported.
"""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import os
import re
import shlex
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import pytest

UNDECIDED = "undecided"
CAMPAIGN = re.compile(rb"^(?:\xef\xbb\xbf)?[\"']?rvjax[\"']?\s*:", re.MULTILINE)
"""What a YAML file has that is a campaign."""

_OUT, _ADDED = "--rvjax-out", "PYTEST_ADDOPTS"
_BRACKETS = str.maketrans("[]", "()")
_PROJECT = (".git", "pyproject.toml", "pytest.ini", "setup.cfg", "setup.py", "tox.ini")
_VERDICT, _COMMANDS = "rvjax_verdict", "rvjax_commands"
_ROOT = pytest.StashKey[Path]()
_TIMEOUT = "rvjax_timeout_min"
_MESSAGE_S = 10.0
"""Seconds until a message says what is waited for."""


def pytest_addoption(parser: pytest.Parser) -> None:
    """The options of the plugin."""
    group = parser.getgroup("rvjax", "robustness campaigns")
    group.addoption("--rvjax", action="store_true", help="collect campaigns (*.yaml): each requirement is a test")
    group.addoption("--rvjax-out", metavar="DIR", help="--rvjax-out=DIR: where run folders go; default: a new temporary folder")
    group.addoption("--rvjax-undecided", choices=("fail", "pass"), help="what an undecided requirement does; default: fail")
    parser.addini("rvjax_undecided", "what an undecided requirement does: fail or pass", default="fail")
    parser.addini(_TIMEOUT, "minutes that flying a campaign may take, or waiting for another pytest that flies it", default="360")


@pytest.hookimpl(tryfirst=True)
def pytest_cmdline_main(config: pytest.Config) -> int | None:
    """`--rvjax-out DIR` is run as `--rvjax-out=DIR`.

    Pytest looks for its root before it knows the options of plugins, and takes a DIR that exists for a folder of tests. With
    another root, tests have other ids: `--last-failed` finds nothing, and a configuration file may be missed.
    """
    if hasattr(config, "workerinput"):
        return None
    given, added = list(map(str, config.invocation_params.args)), shlex.split(os.environ.get(_ADDED, ""))
    arguments, addopts = joined(given), joined(added)
    if (arguments, addopts) == (given, added):
        return None
    if addopts != added:
        os.environ[_ADDED] = shlex.join(addopts)
    return int(pytest.main(arguments, plugins=config.invocation_params.plugins))


def joined(arguments: Sequence[str]) -> list[str]:
    """The arguments with `--rvjax-out DIR` as one word."""
    words, rest = list[str](), iter(arguments)
    for word in rest:
        if word == "--":
            return [*words, word, *rest]
        value = next(rest, None) if word == _OUT else None
        words.append(word if value is None else f"{word}={value}")
    return words


def pytest_configure(config: pytest.Config) -> None:
    """Checks the settings, and registers the mark that keeps the requirements of a campaign together, also without xdist."""
    if not config.getoption("--rvjax"):
        return
    config.addinivalue_line("markers", "xdist_group(name): tests that one process runs")
    undecided, timeout = config.getini("rvjax_undecided"), config.getini(_TIMEOUT)
    wrong = [] if undecided in ("fail", "pass") else [f"rvjax_undecided: found {undecided!r}; accepted: fail, pass"]
    if not 0.0 < _number(timeout) <= 10_000.0:
        wrong.append(f"{_TIMEOUT}: found {timeout!r}; accepted: minutes above 0, up to 10000")
    if wrong:
        raise pytest.UsageError("\n".join(wrong))
    if config.getoption(_OUT):
        _root(config)


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node: Any) -> None:
    """All processes of xdist have the same folder."""
    if node.config.getoption("--rvjax"):
        node.workerinput["rvjax_root"] = str(_root(node.config))


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> pytest.Collector | None:
    """Campaign files, where they are asked for."""
    if not parent.config.getoption("--rvjax") or file_path.suffix not in (".yaml", ".yml"):
        return None
    try:
        found = CAMPAIGN.search(file_path.read_bytes())
    except OSError:
        found = True  # said with its reason when it is loaded
    return CampaignFile.from_parent(parent, path=file_path) if found else None


class CampaignFile(pytest.File):
    """A campaign; its requirements are its items."""

    judged: dict[str, Any] | None = None
    """What `rvjax check --json` said."""

    def collect(self) -> Iterable[pytest.Item]:
        """The requirements. A mistake in the campaign is one of collecting it, with its places."""
        from rvjax.analysis.verdicts.sentences import title
        from rvjax.campaign import load
        from rvjax.errors import CampaignError

        try:
            campaign = load(self.path)
        except CampaignError as error:
            raise self.CollectError(str(error)) from None
        names = item_names([title(requirement) for requirement in campaign.require])
        for number, (name, requirement) in enumerate(zip(names, campaign.require, strict=True), 1):
            item: RequirementItem = RequirementItem.from_parent(self, name=name)
            item.number, item.title = number, title(requirement)
            item.add_marker(pytest.mark.xdist_group(folder_name(self.path)))
            yield item

    @property
    def folder(self) -> Path:
        """Its run folder: no two campaigns have the same."""
        return _root(self.config) / folder_name(self.path)

    def judge(self) -> dict[str, Any]:
        """Flies the campaign unless it is flown; of processes beside each other one flies it, the others read what came out."""
        if self.judged is None:
            session = os.environ.get("PYTEST_XDIST_TESTRUNUID", "")
            kept = self.folder.with_suffix(f"{self.folder.suffix}.json")
            limit_s = 60.0 * _number(self.config.getini(_TIMEOUT))
            with _alone(self.folder, limit_s, self._say):
                found = _kept(kept)
                if session and found.get("session") == session:
                    self.judged = found
                else:
                    self.judged = {**_check(self.path, self.folder, limit_s), "session": session}
                    kept.write_text(json.dumps({**self.judged, "commands": []}), encoding="utf-8")
        return self.judged

    def _say(self, text: str) -> None:
        """A line in the terminal; nothing in a process of xdist, which has none."""
        reporter: Any = self.config.pluginmanager.get_plugin("terminalreporter")
        if reporter is not None:
            reporter.write_line(text)


class RequirementItem(pytest.Item):
    """One requirement."""

    number: int
    title: str
    parent: CampaignFile

    def runtest(self) -> None:
        """Passes where the verdict is PASS."""
        found = self.parent.judge()
        if "verdicts" not in found:
            raise NotShown("ERROR", found["error"])
        verdict = found["verdicts"][self.number - 1]
        if verdict["verdict"] != "PASS":
            raise NotShown(verdict["verdict"], f"{verdict['text']}\n{_advice(self.parent.folder, verdict['worst_sample'])}")

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """The verdict's sentence; a traceback only of what nobody foresaw."""
        if isinstance(excinfo.value, NotShown):
            return str(excinfo.value)
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[os.PathLike[str], int | None, str]:
        """Path, line and heading. Of a heading that ends the id pytest would write `0::9` for 0.9."""
        return self.path, None, f"{self.path.name}: {self.title}"


class NotShown(Exception):
    """A requirement that is not shown to hold. verdict: FAIL, UNDECIDED, or ERROR where it could not be judged."""

    def __init__(self, verdict: str, text: str) -> None:
        super().__init__(text)
        self.verdict = verdict


def item_names(titles: Sequence[str]) -> list[str]:
    """A name of each requirement that no tool takes apart, different from all others.

    Tools split ids at `::` and read what follows a `[` as parameters. A name has no number: it stays when another requirement is
    inserted.
    """
    from rvjax.errors import visible

    names: dict[str, None] = {}
    for text in titles:
        plain = re.sub("::+", ":", " ".join(visible(text).split())).translate(_BRACKETS).strip(":") or "requirement"
        counted = (plain if count == 1 else f"{plain} ({count})" for count in itertools.count(1))
        names[next(name for name in counted if name not in names)] = None
    return list(names)


def folder_name(campaign: Path) -> str:
    """Its path in its project, or the whole path, as one word, and a few digits that no other path has.

    The project is the nearest folder above with one of `_PROJECT`; the root that pytest chooses depends on its arguments.
    """
    above = (folder for folder in campaign.parents if any((folder / name).exists() for name in _PROJECT))
    project = next(above, None)
    shown = campaign if project is None else campaign.relative_to(project)
    name = re.sub(r"[^\w.-]+", "-", shown.with_suffix("").as_posix()).strip("-.")
    return f"{name[-80:]}-{hashlib.sha256(os.fsencode(shown)).hexdigest()[:8]}"


def _number(text: str) -> float:
    """The number; not a number where there is none."""
    try:
        return float(text)
    except ValueError:
        return math.nan


def _kept(file: Path) -> dict[str, Any]:
    """The verdicts that a process of xdist has kept; empty where there are none, or not whole."""
    try:
        found = json.loads(file.read_bytes())
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def _check(campaign: Path, folder: Path, limit_s: float) -> dict[str, Any]:
    """What `rvjax check` says of a campaign: its document, or `error`; `commands`: what it told a service on its way."""
    command = [sys.executable, "-P", "-m", "rvjax", "check", str(campaign), "--out", str(folder), "--json", "--quiet"]
    utf_8 = os.environ | {"PYTHONIOENCODING": "utf-8"}
    try:
        done = subprocess.run(
            command, capture_output=True, encoding="utf-8", errors="replace", env=utf_8, check=False, timeout=limit_s
        )
    except subprocess.TimeoutExpired:
        why = f"not decided within {limit_s / 60:g} min; the flights are kept. Resume with the command below, or set {_TIMEOUT}"
        return {"error": f"{why}\n{shlex.join(command[:-2])}", "commands": []}
    commands = [line for line in done.stderr.splitlines() if line.startswith(("::error ", "::warning "))]
    try:
        document = json.loads(done.stdout)
    except ValueError:
        said = done.stderr.strip() or done.stdout.strip()
        document = {"error": f"rvjax ended with {done.returncode}: {said[-2000:]}\n{shlex.join(command[:-2])}"}
    if "verdicts" not in document and "error" not in document:
        document["error"] = f"rvjax ended with {done.returncode}: {done.stderr.strip()[-2000:]}"
    return document | {"commands": commands}


def _advice(folder: Path, sample: int | None) -> str:
    """Where the report is, and how the worst sample flies again."""
    again = "" if sample is None else f"\nrvjax replay {shlex.quote(str(folder))} --sample {sample}"
    return f"report: {folder / 'report.html'}{again}"


def _root(config: pytest.Config) -> Path:
    """The folder of all run folders: the same for all processes of a session, and nobody else's."""
    if _ROOT not in config.stash:
        given = getattr(config, "workerinput", {}).get("rvjax_root") or config.getoption(_OUT)
        root = Path(given or tempfile.mkdtemp(prefix="rvjax-pytest-")).absolute()
        try:
            root.mkdir(parents=True, exist_ok=True)
            tempfile.TemporaryFile(dir=root).close()
        except OSError as error:
            accepted = "accepted: a folder that can be written"
            raise pytest.UsageError(f"{_OUT}={given}: cannot be written: {error.strerror}; {accepted}") from None
        config.stash[_ROOT] = root
    return config.stash[_ROOT]


@contextmanager
def _alone(folder: Path, limit_s: float, say: Callable[[str], None]) -> Iterator[None]:
    """One process at a time. NotShown where another process keeps the campaign for longer than the limit."""
    import fcntl  # not everywhere where pytest is

    started, said = time.monotonic(), False
    with folder.with_suffix(f"{folder.suffix}.lock").open("wb") as lock:
        while True:
            with suppress(BlockingIOError):
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                break
            waited = time.monotonic() - started
            if waited > limit_s:
                why = f"another pytest has been flying this campaign into {folder} for {limit_s / 60:g} min"
                raise NotShown("ERROR", f"{why}; stop it, or set {_TIMEOUT}")
            if waited > _MESSAGE_S and not said:
                said = True
                say(f"waiting for another pytest, which flies into {folder}, up to {limit_s / 60:g} min")
            time.sleep(0.1)
        yield


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Notes the verdict in the report, which processes send to each other."""
    report = yield
    if isinstance(item, RequirementItem) and call.when == "call" and item.parent.judged is not None:
        setattr(report, _COMMANDS, item.parent.judged.pop("commands", []))
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
    """The sentences of the undecided, and what GitHub reads."""
    reports: list[pytest.TestReport] = terminalreporter.stats.get(UNDECIDED, [])
    if reports:
        terminalreporter.section("undecided requirements")
        for report in reports:
            terminalreporter.write_line(f"{report.nodeid}\n{report.longreprtext}")
    for report in (one for each in terminalreporter.stats.values() for one in each):
        for command in getattr(report, _COMMANDS, ()):
            terminalreporter.write_line(command)
