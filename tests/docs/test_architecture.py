"""docs/architecture.md and its picture agree with the imports and the layers of pyproject.toml."""

from __future__ import annotations

import re
import runpy
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def script() -> dict[str, Any]:
    return runpy.run_path(str(ROOT / "docs" / "architecture.py"))


def test_the_picture_shows_the_imports(script: dict[str, Any]) -> None:
    committed = (ROOT / "docs" / "architecture.svg").read_text(encoding="utf-8")
    assert committed == script["picture"](), "run: python docs/architecture.py"


def test_the_picture_has_every_package(script: dict[str, Any]) -> None:
    drawn = {name for names in script["boxes"]() for name in names}
    assert drawn == {path.stem for path in (ROOT / "rvjax").iterdir() if path.suffix in ("", ".py") and path.name[0] != "_"}


def test_the_text_has_the_packages_in_the_order_of_their_layers(script: dict[str, Any]) -> None:
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    table = text.partition("| package |")[2].partition("\n\n")[0]
    rows = [re.findall(r"`(\w+)`", row.split("|")[1]) for row in table.splitlines()[2:]]
    expected = [[name for name in layer if name not in ("notebook", "pytest_plugin", "testing")] for layer in script["layers"]()]
    assert [sorted(row) for row in rows] == [sorted(layer) for layer in expected]
    packages = [name for layer in expected for name in layer if (ROOT / "rvjax" / name).is_dir()]
    assert len(packages) == 13, "the text says thirteen packages"
