"""A component that a notebook cell has made flies from the source of this cell."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import rvjax
from rvjax.errors import CampaignError, UsageError
from rvjax.run_folder import RunFolder
from tests.user_code.cells import Notebook
from tests.user_code.mistakes import END, FORCE, LAW
from tests.user_code.test_user_identity import HELPED, METRIC
from tests.user_code.test_user_mistakes import project

pytestmark = pytest.mark.usefixtures("bare")
ADVICE = "accepted: a name that this notebook cell defines or imports; it flies without the other cells"
RESUME = """
import rvjax
words = rvjax.RunFolder.open("run").provenance["overrides"]
rvjax.fly_campaign("run/campaign.yaml", out="run", overrides=words, progress=False)
rvjax.replay_sample("run", 3)
print("resumed and replayed")
"""


@pytest.fixture
def campaign(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A campaign beside the notebook, whose own law is another one."""
    monkeypatch.chdir(tmp_path)
    return project(tmp_path, LAW.replace("-3.0 *", "-2.0 *"))


@pytest.fixture
def notebook(monkeypatch: pytest.MonkeyPatch) -> Notebook:
    """An empty notebook."""
    return Notebook(monkeypatch)


def name_of(cell: str) -> str:
    """The file that a cell stands for."""
    return f"cell_{hashlib.sha256(cell.encode()).hexdigest()[:8]}.py"


def refused(campaign: Path, component: Any) -> str:
    """The words with which a component is refused."""
    with pytest.raises((UsageError, CampaignError)) as error:
        _ = rvjax.Campaign(campaign).with_(controller=component).problem
    return str(error.value)


def test_a_cell_flies_as_its_file_would(
    campaign: Path, notebook: Notebook, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A law and a metric of two cells, with a module beside the notebook: the run keeps their bytes, and its samples are those of
    the same text in files. Another process, which knows no cell, resumes and replays the folder. Kills: a cell outside of the
    identity, the law of another cell, a cell that only this process can fly."""
    (tmp_path / "gains_of.py").write_text("FACTOR = 110.0\n")
    first = rvjax.Campaign(campaign)
    monkeypatch.syspath_prepend(tmp_path)
    space = notebook.run_cell(HELPED)
    del sys.modules["gains_of"]  # for good: monkeypatch would bring it back
    notebook.run_cell(METRIC)
    run = first.with_(controller=(space["CONTROLLER"], {"gains": {"kp": 0.02}}), metrics=[space["METRIC"]]).fly(
        "run", progress=False
    )
    names = {name_of(HELPED): HELPED, name_of(METRIC): METRIC, "gains_of.py": "FACTOR = 110.0\n"}
    assert {path.name: path.read_text() for path in (run.path / "inputs").iterdir()} == names
    assert set(run.folder.identity["components"]) == set(names)

    (tmp_path / "law.py").write_text(HELPED)
    (tmp_path / "ball.py").write_text(METRIC)
    files = {"use": "./law.py", "gains": {"kp": 0.02}}
    same = first.with_(controller=files, metrics=[{"use": "./ball.py"}]).fly("files", progress=False)
    assert run.samples.equals(same.samples)

    for name in ("gains_of.py", "law.py", "ball.py"):
        (tmp_path / name).unlink()
    before = run.samples
    (chunk,) = (run.path / "samples").glob("*")
    chunk.unlink()
    done = subprocess.run([sys.executable, "-c", RESUME], capture_output=True, text=True, check=False)
    assert done.stdout == "resumed and replayed\n", done.stderr
    assert RunFolder.open(run.path).samples().frame.equals(before)


def test_the_cell_that_made_the_component_flies(campaign: Path, notebook: Notebook) -> None:
    """Cells that bind the same name again: each object stands for its own cell, also the older one with another name. Kills: the
    cell of the functions, the newest cell."""
    older = notebook.run_cell("import numpy\n" + LAW + "OLDER = CONTROLLER\n")["CONTROLLER"]
    newer = notebook.run_cell(LAW)["CONTROLLER"]
    for component, cell in ((older, "import numpy\n" + LAW + "OLDER = CONTROLLER\n"), (newer, LAW)):
        assert set(rvjax.Campaign(campaign).with_(controller=component).problem.spec.source.inputs) == {name_of(cell)}


def test_a_name_of_another_cell_is_a_mistake_with_its_line(campaign: Path, notebook: Notebook) -> None:
    """Kills: a component that flies with what the notebook happens to hold, the law of the cell whose functions it takes, a
    message that does not say what to do."""
    notebook.run_cell("import jax.numpy as jnp\nLIMIT = 3.0\n")
    cell = LAW.replace(FORCE, FORCE + "    force = force * LIMIT\n")
    line = cell.splitlines().index("    force = force * LIMIT") + 1
    words = refused(campaign, notebook.run_cell(cell)["CONTROLLER"])
    assert f"{name_of(cell)}:{line}: respond: NameError: name 'LIMIT' is not defined; {ADVICE}" in words
    notebook.run_cell(LAW)
    words = refused(campaign, notebook.run_cell(END)["CONTROLLER"])
    assert f"{name_of(END)}:1: NameError: name 'Controller' is not defined; {ADVICE}" in words


MAGIC = "get_ipython().run_line_magic('matplotlib', 'inline')\n"


@pytest.mark.parametrize(
    ("text", "found"),
    [
        (LAW + "%matplotlib inline\n", "an IPython command"),
        (LAW + "!ls\n", "an IPython command"),
        (LAW + "respond?\n", "an IPython command"),
        (LAW + MAGIC, "an IPython command"),
        (LAW + "await later()\n", ""),
    ],
)
def test_a_cell_is_plain_python(campaign: Path, notebook: Notebook, text: str, found: str) -> None:
    """Commands of IPython as the user writes them, and as IPython keeps them. Kills: a command in a run folder, a message that
    calls it bad syntax."""
    space = notebook.run_cell(LAW)
    entry = space["CONTROLLER"].made_in[0]
    notebook.keep(entry, text)
    words = refused(campaign, space["CONTROLLER"])
    line = text.splitlines()[-1]
    if found:
        assert f"line {len(text.splitlines())} of the cell of a component, {line!r}: {found}" in words
        assert "%%writefile my_law.py" in words
    else:
        assert "'await' outside function" in words


def test_a_component_without_a_name_is_refused(campaign: Path, notebook: Notebook) -> None:
    """Nothing could find it in the cell again. Kills: another component of the cell, a name of another
    cell."""
    notebook.run_cell(LAW + "HELD = [Controller(Gains, start, respond)]\n")
    space = notebook.run_cell("NAMED_LATER = HELD[0]\n")
    assert "without a name in the cell that makes it; accepted: a name, such as CONTROLLER" in refused(campaign, space["HELD"][0])


def test_a_cell_that_also_flies_is_refused(campaign: Path, notebook: Notebook, tmp_path: Path) -> None:
    """It would fly in itself. Kills: a flight inside of a flight, a message about a file that the user's code does not open."""
    del campaign
    flying = LAW + 'import rvjax\nrvjax.Campaign("mine.yaml").with_(controller=CONTROLLER).fly("run", progress=False)\n'
    with pytest.raises(CampaignError) as error:
        notebook.run_cell(flying)
    line = len(flying.splitlines())
    assert f"{name_of(flying)}:{line}: the code of a component flies a campaign; accepted: definitions only" in str(error.value)
    assert not (tmp_path / "run").exists()


def test_a_cell_without_a_source_is_refused(campaign: Path, notebook: Notebook) -> None:
    """As at the prompt of Python. Kills: a run without its code."""
    assert "in no Python file and no notebook cell" in refused(campaign, notebook.run_cell(LAW, kept=False)["CONTROLLER"])


def test_a_law_with_functions_of_another_file_stands_for_its_own(
    campaign: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Kills: the file of the first function."""
    (tmp_path / "starts_here.py").write_text(
        "import jax.numpy as jnp\n\n\ndef start(measured, gains):\n    return jnp.zeros(3)\n"
    )
    (tmp_path / "lawful_there.py").write_text("from starts_here import start\n" + LAW.replace("def start(", "def unused("))
    monkeypatch.syspath_prepend(tmp_path)
    law = __import__("lawful_there")
    problem = rvjax.Campaign(campaign).with_(controller=law.CONTROLLER).problem
    for name in ("lawful_there", "starts_here"):
        monkeypatch.delitem(sys.modules, name)
    assert set(problem.spec.source.inputs) == {"lawful_there.py", "starts_here.py"}
