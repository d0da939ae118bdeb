"""The site: its reference pages come from the program, and Sphinx builds it without a warning where it is installed."""

from __future__ import annotations

import re
import runpy
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from rvjax.campaign import Spec
from rvjax.cli._app import COMMANDS
from rvjax.components import manual
from rvjax.components.registry import FAMILIES

DOCS = Path(__file__).parents[2] / "docs"
SPHINX = pytest.mark.skipif(find_spec("sphinx") is None, reason="Sphinx is not installed: pip install -e '.[docs]'")
MOST_BYTES = 500_000
HOME = "# Home\n\n## Start\n\n- [Words](glossary.md): [them](glossary.md#words)\n"


@pytest.fixture(scope="module")
def pages() -> dict[str, str]:
    return runpy.run_path(str(DOCS / "reference.py"))["pages"]()


def headings(text: str) -> list[str]:
    return re.findall(r"^##+ (.*)$", re.sub(r"^```.*?^```$", "", text, flags=re.DOTALL | re.MULTILINE), re.MULTILINE)


def test_every_component_is_described_with_its_equations_keys_and_units(pages: dict[str, str]) -> None:
    """Kills: a family that the site leaves out, a page without its table."""
    for page in manual.component_pages():
        text = pages[f"{page.family}.md"].partition(f"\n## {page.name}\n")[2].partition("\n## ")[0]
        assert page.text.rstrip() in text, page.name
        for _, rows in page.tables:
            assert all(f"| `{row[0]}` |" in text for row in rows), page.name
    assert {f"{family}.md" for family in FAMILIES} <= set(pages)


def test_every_key_command_and_public_name_is_described(pages: dict[str, str]) -> None:
    """Kills: a section, a command or a name that the site leaves out."""
    import rvjax
    import rvjax.components

    assert headings(pages["keys.md"]) == list(Spec.keys())
    assert headings(pages["commands.md"]) == [f"rvjax {name}" for name in COMMANDS]
    assert {f"rvjax.{name}" for name in rvjax.__all__ if name[0] != "_"} <= set(headings(pages["api.md"]))
    assert {f"rvjax.components.{name}" for name in rvjax.components.__all__} <= set(headings(pages["api.md"]))
    assert "`--samples`" in pages["commands.md"].partition("## rvjax run")[2].partition("\n## ")[0]


def test_a_cell_is_shown_as_it_stands() -> None:
    """Kills: a bar or a bracket of a text that ends its cell or becomes a link."""
    cell = runpy.run_path(str(DOCS / "reference.py"))["cell"]
    assert cell("a|b *c* `d|e` [f]") == r"a\|b \*c\* `d\|e` \[f\]"
    assert cell("") == " "


def test_the_reference_pages_are_not_in_git() -> None:
    """Kills: a copy that can be older than the program."""
    listed = subprocess.run(["git", "ls-files", "docs/generated"], cwd=DOCS.parent, capture_output=True, text=True, check=False)
    assert listed.stdout == ""


def test_the_picture_that_moves_is_small_and_moves() -> None:
    text = (DOCS / "approach.svg").read_text(encoding="utf-8")
    assert len(text.encode()) < MOST_BYTES
    assert text.count("<animate ") >= 7
    assert "<script" not in text


def test_the_picture_that_moves_is_that_of_its_script() -> None:
    """Kills: a script, a controller or a scene that was changed without its picture."""
    script = runpy.run_path(str(DOCS / "approach.py"))
    assert (DOCS / "approach.svg").read_text(encoding="utf-8") == script["picture"](), "run: python docs/approach.py"


def built(folder: Path, *options: str) -> Any:
    return subprocess.run(
        [sys.executable, str(DOCS / "build.py"), "--out", str(folder), *options], capture_output=True, text=True, check=False
    )


@SPHINX
def test_the_site_is_built_without_a_warning(tmp_path: Path) -> None:
    """Kills: a broken link, a page outside of the navigation, a table that Sphinx cannot read."""
    done = built(tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    written = {path.relative_to(tmp_path / "site").as_posix() for path in (tmp_path / "site").rglob("*.html")}
    assert {"index.html", "tutorials/quickstart.html", "generated/faults.html", "generated/changelog.html"} <= written
    home = (tmp_path / "site" / "index.html").read_text(encoding="utf-8")
    assert all(name in home for name in ("Tutorials", "generated/keys.html", "generated/api.html"))


@SPHINX
@pytest.mark.parametrize(
    "mistake", ["[a](none.md)\n", "[a](glossary.md#none)\n", "![a](none.png)\n"], ids=["page", "anchor", "picture"]
)
def test_a_broken_link_ends_the_build(mistake: str, tmp_path: Path) -> None:
    """Kills: a build that lets warnings pass. A small site with the settings of the real one."""
    for name in ("conf.py", "reference.py"):
        text = (DOCS / name).read_text(encoding="utf-8").replace('reference["write"]()', "")
        (tmp_path / "docs" / name).parent.mkdir(exist_ok=True)
        (tmp_path / "docs" / name).write_text(text, encoding="utf-8")
    (tmp_path / "docs" / "_static").mkdir()
    (tmp_path / "rvjax").mkdir()
    (tmp_path / "rvjax" / "__init__.py").write_text('__version__ = "0"\n')
    (tmp_path / "docs" / "glossary.md").write_text("# Glossary\n\n## Words\n")
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-n", "-q", "-b", "html", "docs", "out"]
    for text, code in (("", 0), (mistake, 1)):
        (tmp_path / "docs" / "index.md").write_text(f"{HOME}\n{text}")
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert (done.returncode, bool(done.stderr)) == (code, bool(code)), done.stderr
