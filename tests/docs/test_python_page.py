"""docs/python.md: its Python is executed as notebook cells, its table of public names is that of the docstrings."""

from __future__ import annotations

import inspect
import re
import sys
from pathlib import Path

import pytest

import rvjax
import rvjax.components
import rvjax.testing
from tests.program import Run
from tests.user_code.cells import Notebook

PAGE = Path(__file__).parents[2] / "docs" / "python.md"


def table() -> str:
    """The names and the first paragraph of each docstring."""
    lines = ["| name | what it is |", "|---|---|"]
    for module in (rvjax, rvjax.components, rvjax.testing):
        for name in module.__all__:
            if not name.startswith("__"):
                text = (inspect.getdoc(getattr(module, name)) or "").partition("\n\n")[0].replace("\n", " ")
                lines.append(f"| `{module.__name__}.{name}` | {text} |")
    return "\n".join(lines)


def test_the_table_has_every_public_name() -> None:
    """Kills: a name that is public and not on the page, a sentence that is older than the docstring. `python -m
    tests.docs.test_python_page` writes the table."""
    assert PAGE.read_text(encoding="utf-8").endswith(f"{table()}\n")


@pytest.mark.usefixtures("bare")
def test_the_page_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, rvjax: Run, capsys: pytest.CaptureFixture[str]) -> None:
    """Kills: a fence with a name that is no longer there, a number of another type."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    assert rvjax("init", ".")[0] == 0
    assert rvjax("init", ".", "--controller", "my_law.py")[0] == 0
    notebook = Notebook(monkeypatch)
    for fence in re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL):
        notebook.run_cell(fence)
    monkeypatch.delitem(sys.modules, "my_law")
    printed = capsys.readouterr().out
    assert "['my_law.py']" in printed
    assert re.search(r"\['cell_[0-9a-f]{8}\.py'\]", printed)
    assert "captured" in printed


if __name__ == "__main__":
    text = PAGE.read_text(encoding="utf-8")
    PAGE.write_text(text[: text.index("| name | what it is |")] + table() + "\n", encoding="utf-8")
