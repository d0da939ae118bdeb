"""docs/extending.md as a new user reads it: its files are taken from the page, its commands are given in an empty folder."""

from __future__ import annotations

import ast
import re
import shlex
from pathlib import Path

import pytest

from rvjax.run_folder import RunFolder
from tests.program import Run

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "extending.md").read_text(encoding="utf-8")
FILES = dict(re.findall(r"^`(my_\w+\.py)`\n\n```python\n(.*?)```", PAGE, re.DOTALL | re.MULTILINE))
COMMANDS = [shlex.split(line) for fence in re.findall(r"```sh\n(.*?)```", PAGE, re.DOTALL) for line in fence.splitlines()]
TEMPLATES = {
    "my_law.py": "controller",
    "my_sampled_law.py": "discrete_controller",
    "my_fault.py": "fault",
    "my_valve.py": "actuator",
    "my_allocation.py": "allocation",
    "my_slosh.py": "effect",
    "my_metric.py": "metric",
    "my_noise.py": "navigation",
    "my_path.py": "guidance",
    "my_push.py": "disturbance",
}
MOST_LINES = 30

pytestmark = pytest.mark.usefixtures("bare")


def test_the_page_shows_what_init_writes() -> None:
    """Kills: a page whose example is not what a user gets."""
    assert list(FILES) == list(TEMPLATES)
    for name, template in TEMPLATES.items():
        assert FILES[name] == (ROOT / "rvjax" / "cli" / "templates" / f"{template}.py").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", FILES)
def test_a_component_has_at_most_thirty_lines(name: str) -> None:
    """Without docstrings, imports and empty lines. Kills: an interface that asks for what does not concern the component."""
    tree = ast.parse(FILES[name])
    kept: set[int] = set()
    for node in ast.walk(tree):
        docstring = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        if not isinstance(node, ast.stmt) or isinstance(node, (ast.Import, ast.ImportFrom)) or docstring:
            continue
        kept |= {node.lineno} if hasattr(node, "body") else set(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    assert len(kept) <= MOST_LINES


def test_four_commands_lead_to_a_report(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, rvjax: Run) -> None:
    """From an empty folder. Kills: a command that the page forgets, a starter campaign that does not fly the file."""
    monkeypatch.chdir(tmp_path)
    assert len(COMMANDS) <= 5
    for program, *words in COMMANDS:
        assert program == "rvjax"
        code, _, err = rvjax(*words)
        assert code in (0, 1, 3) if words[0] == "run" else code == 0, err
    (folder,) = (tmp_path / "reports" / "my-campaign").iterdir()
    assert (folder / "report.html").exists()
    assert list(RunFolder.open(folder).identity["components"]) == ["my_law.py"]


OTHERS = {
    "fault": "my_fault.py",
    "metric": "my_metric.py",
    "navigation": "my_noise.py",
    "disturbance": "my_push.py",
    "actuator": "my_valve.py",
    "effect": "my_slosh.py",
    "allocation": "my_allocation.py",
    "guidance": "my_path.py",
}
TOGETHER = (
    ("fault", "metric", "navigation", "disturbance"),
    ("actuator", "effect", "metric", "guidance"),
    ("allocation", "fault"),
)
"""A dead band has no effect behind pulses of one size: the audit would say so."""


@pytest.mark.parametrize("options", TOGETHER, ids=lambda options: options[0])
def test_other_components_join_the_campaign(
    options: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, rvjax: Run
) -> None:
    """`rvjax init` writes several at once, and the campaign flies them: none is without an effect, or the audit would refuse.
    Kills: an entry at the wrong place of the starter campaign."""
    monkeypatch.chdir(tmp_path)
    words = [word for option in options for word in (f"--{option}", OTHERS[option])]
    assert rvjax("init", ".", "--controller", "my_law.py", *words)[0] == 0
    short = [word for value in ("horizon.duration_s=160", "horizon.step_s=0.1", "samples=16") for word in ("--set", value)]
    code, _, err = rvjax("run", "campaign.yaml", "--out", "run", "--quiet", *short)
    assert code in (0, 1, 3), err
    files = {"my_law.py", *(OTHERS[option] for option in options)}
    assert set(RunFolder.open(tmp_path / "run").identity["components"]) == files


def test_the_message_of_the_page_is_that_of_the_program(tmp_path: Path, rvjax: Run) -> None:
    """Kills: a message on the page that nobody gets."""
    (said,) = re.findall(r"```text\n(.*?)\n```", PAGE, re.DOTALL)
    line = int(said.split(":")[1])
    lines = FILES["my_law.py"].splitlines()
    lines[line - 1 : line - 1] = ["    if measured.rho[0] > 0.0: pass"]
    (tmp_path / "my_law.py").write_text("\n".join(lines))
    assert rvjax("check-component", tmp_path / "my_law.py")[2].strip().removeprefix(f"{tmp_path}/") == said
