"""The commands and the Python of the pages are run as they stand there, a page after the other in an empty folder.

Shipped campaigns are replaced by short ones of the same names, and searches get small budgets. `NOT_RUN` names what other tests
run.
"""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.docs.fences import ROOT, SHELL, Fence, all_fences, commands
from tests.program import Run
from tests.user_code.cells import Notebook

PAGES = {
    "docs/tutorials/quickstart.md": (),
    "docs/tutorials/controller.md": (),
    "docs/tutorials/ci.md": (),
    "docs/tutorials/tuning.md": (),
    "docs/tutorials/rare.md": (),
    "docs/start.md": ("rvjax run campaigns/quickstart.yaml",),
    "docs/tour.md": (
        "rvjax run campaigns/quickstart.yaml --out reports/before",
        "rvjax run campaigns/quickstart.yaml --out reports/after --set controller.gains.k1=0.15",
    ),
    "docs/comparing.md": ("rvjax init .",),
    "docs/tuning.md": (),
    "docs/which-draws.md": (),
    "docs/export.md": ("rvjax init .", "rvjax run campaign.yaml --out reports/mine"),
    "docs/report.md": ("rvjax init .", "rvjax run campaign.yaml --out reports/mine"),
    "docs/ci.md": (),
    "docs/rare.md": (),
    "docs/controllers.md": (),
    "docs/scenes.md": (),
    "docs/campaigns.md": ("rvjax run campaigns/quickstart.yaml",),
}
"""Page → what was done before it, in the words of the pages that lead there."""

NOT_RUN = {
    "python3 -m venv": "the whole installation; .ci/run and the workflow wheel do it",
    ".venv/bin/pip": "the same",
    ".venv/bin/rvjax run campaigns/quickstart.yaml": "docs/tour.md runs it",
    "source ": "the environment is this one",
    "pip install": "the same",
    "pytest --rvjax campaigns/ci/": "ci/test_pytest_plugin.py",
    "rvjax run campaign.yaml --dask": "reliability/test_cluster_docs.py",
    "rvjax run campaign.yaml --out s3:": "reliability/test_s3.py",
    "rvjax --install-completion": "it would change the shell of the user; cli/test_completion.py",
    "rvjax rare campaign.yaml --method importance": "rare/test_rare_search.py",
    "rvjax view": "it would open a browser; report/test_plots.py",
    "rvjax report reports/mine --pdf": "it needs a Chromium; report/test_plots.py",
    "rvjax bench": "run/test_yardsticks.py",
    "rvjax check campaigns/ci/docking.yaml": "its baseline is that of all samples; ci/test_against.py",
    "rvjax compare reports/bakeoff/… --baseline": "eleven controllers; run/test_baselines.py",
}

SMALLER = (
    (r"--samples \d+", "--samples 416"),
    (r"--rows \d+", "--rows 30"),
    (r"^(rvjax worst .*)--flights \d+", r"\1--flights 400"),
    (r"^(rvjax rare .*)--flights \d+", r"\1--flights 10000"),
    (r"^(rvjax worst (?!.*--flights).*)$", r"\1 --flights 400"),
    (r"^(rvjax rare (?!.*--flights).*)$", r"\1 --flights 10000"),
    (r"^(rvjax sensitivity (?!.*--rows).*)$", r"\1 --rows 30"),
    (r"^(rvjax worst (?!.*--out).*)$", r"\1 --out reports/worst-of-page"),
)
"""Numbers of flights."""

JUDGED = ("run", "check", "compare", "tune", "worst", "rare", "reweigh", "report")
CODES = {"controller.gains.k7": (2,), "controller.gains.k1=0.03": (1,)}
"""What a command has → its exit code, as the page says it."""


def short(text: str) -> str:
    """A campaign with few samples, and a search with few candidates."""
    text = re.sub(r"^samples: \d+", "samples: 32", text, flags=re.MULTILINE)
    text = re.sub(r"^  samples: \d+", "  samples: 32", text, flags=re.MULTILINE)
    text = re.sub(r"candidates: \d+", "candidates: 4", text)
    text = re.sub(r"first: \d+", "first: 13", text)
    text = re.sub(r"method: splitting(?!.*budget)", "method: splitting, budget: {flights: 10000}", text)
    return re.sub(r"hard: \d+", "hard: 4", text)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A clone with short campaigns, in which the process works."""
    for path in (ROOT / "campaigns").rglob("*"):
        place = tmp_path / path.relative_to(ROOT)
        place.parent.mkdir(parents=True, exist_ok=True)
        if path.suffix == ".yaml":
            place.write_text(short(path.read_text(encoding="utf-8")), encoding="utf-8")
        elif path.is_file():
            shutil.copy(path, place)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    return tmp_path


def ran(command: str, rvjax: Run, monkeypatch: pytest.MonkeyPatch) -> str:
    """What is wrong with the end of a command, "" if nothing is."""
    if any(command.startswith(beginning) for beginning in NOT_RUN):
        return ""
    for old, new in SMALLER:
        command = re.sub(old, new, command)
    words = [filled(word) for word in shlex.split(command.replace("NAME", "pd-plus"))]
    if words[0] == "cd":
        monkeypatch.chdir(words[1])
        return ""
    if words[0] == "pytest":
        done = subprocess.run(
            [sys.executable, "-m", *words, "-p", "no:cacheprovider"], capture_output=True, text=True, check=False
        )
        return "" if done.returncode == 0 else done.stdout
    assert words[0] == "rvjax", command
    code, out, err = rvjax(*words[1:])
    expected = next((codes for key, codes in CODES.items() if key in command), (0, 1, 3) if words[1] in JUDGED else (0,))
    return "" if code in expected else f"{command}: exit code {code}, not {expected}\n{out}\n{err}"


def filled(word: str) -> str:
    """A path with the name of the only folder in place of …"""
    if "…" not in word:
        return word
    return str(next(path for path in Path().glob(word.replace("…", "*")) if path.is_dir()))


def work(fence: Fence, rvjax: Run, notebook: Notebook, monkeypatch: pytest.MonkeyPatch) -> str:
    """Does what a reader does with a fence. Returns what went wrong."""
    if fence.file:
        Path(fence.file).write_text(fence.text, encoding="utf-8")
    elif fence.tail:
        with Path(fence.tail).open("a", encoding="utf-8") as file:
            file.write(f"\n{fence.text}")
    elif fence.language in SHELL:
        return "".join(ran(command, rvjax, monkeypatch) for command in commands(fence.text))
    elif fence.language == "python":
        notebook.run_cell(re.sub(r'"([^"]*…[^"]*)"', lambda path: repr(filled(path[1])), fence.text))
    return ""


@pytest.mark.usefixtures("bare", "folder")
@pytest.mark.parametrize("page", PAGES)
def test_a_page_runs(page: str, rvjax: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: a command that does not do what the page needs next, a name that is gone, a key that the program refuses."""
    notebook = Notebook(monkeypatch)
    for command in PAGES[page]:
        assert ran(command, rvjax, monkeypatch) == ""
    for fence in all_fences():
        if fence.document == page:
            assert work(fence, rvjax, notebook, monkeypatch) == "", str(fence)
    monkeypatch.delitem(sys.modules, "my_law", raising=False)


ELSEWHERE = {
    "README.md": "its campaign is that of docs/tour.md; .ci/run runs its second command",
    "CONTRIBUTING.md": ".ci/run",
    "docs/releasing.md": "a release",
    "docs/cluster.md": "reliability/test_cluster_docs.py",
    "docs/crosscheck.md": "needs Basilisk; physics/test_mean_wrench.py",
    "docs/peers.md": "needs the peers; peers/test_peers.py",
    "docs/study.md": "an hour; docs/test_study.py runs it in small",
    "docs/extending.md": "docs/test_extending.py",
    "docs/python.md": "docs/test_python_page.py",
}


def test_every_page_with_commands_is_run() -> None:
    """Kills: a new page whose commands nobody runs; a reason for a command that no page has."""
    found = {fence.document for fence in all_fences() if fence.language in (*SHELL, "python")}
    assert found == {*PAGES, *ELSEWHERE}
    every = [command for fence in all_fences() if fence.language in SHELL for command in commands(fence.text)]
    assert [reason for reason in NOT_RUN if not any(command.startswith(reason) for command in every)] == []


WRONG = [
    ("sh", "rvjax run campaigns/none.yaml\n"),
    ("sh", "rvjax run campaigns/quickstart.yaml --set pursuer.mass_kg=-1\n"),
    ("python", "import rvjax\n\nrvjax.Campaign('campaigns/quickstart.yaml').with_(samples=-1).source.value['x']\n"),
    ("python", "print(undefined)\n"),
]


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(("language", "text"), WRONG, ids=lambda value: str(value)[:30])
def test_a_fence_that_fails_is_noticed(language: str, text: str, rvjax: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: exit codes or exceptions that are not looked at."""
    fence = Fence("x.md", 1, language, text)
    try:
        message = work(fence, rvjax, Notebook(monkeypatch), monkeypatch)
    except Exception as error:  # noqa: BLE001
        message = repr(error)
    assert message
