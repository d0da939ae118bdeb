"""The list of slow tests names tests that exist."""

from __future__ import annotations

import ast
from pathlib import Path

from tests.slow import SLOW

TESTS = Path(__file__).parents[1]


def test_every_slow_test_exists() -> None:
    """A test that is renamed would otherwise become quick again unnoticed. Kills: a name without its test."""
    missing: list[str] = []
    for name in SLOW:
        file, _, test = name.partition("[")[0].partition("::")
        tree = ast.parse((TESTS / file).read_text(encoding="utf-8"))
        missing += [name] * (test not in {"", *(node.name for node in tree.body if isinstance(node, ast.FunctionDef))})
    assert not missing
