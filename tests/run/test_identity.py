"""What the identity of a run covers: every module that a flight depends on, and nothing else."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import rvjax
from rvjax.components.registry import FAMILY_OF
from rvjax.execution.identity import FLYING, identity, source_digest
from rvjax.simulation.problem import load
from tests.short import CAMPAIGN

ROOT = Path(rvjax.__file__).parent
WITHOUT_NUMBERS = {
    "errors.py": "messages",
    "cores.py": "the number of cores; which core flies a chunk changes no bit",
    "columns.py": "names, units and meanings of columns",
    "timings.py": "where the time goes",
    "components/effect.py": "says which inputs do nothing; no flight looks at it",
    "components/installed_code.py": "says which code of an installed package a process executes",
    "components/registry.py": "finds a member by its name",
    "components/user_mistakes.py": "messages",
    "components/user_watch.py": "refuses what a user's code reads while it is traced; changes no number",
    "components/wrench_over_time.py": "says which tables and pulses the steps cannot follow; no flight looks at it",
    "stats/densities.py": "what samples of a law say about another one; no draw depends on it",
    "stats/other_laws.py": "which samples are samples of a law that a requirement names",
    "stats/reweighting.py": "the same",
    "stats/__init__.py": "bounds and tests: they refuse a requirement that cannot be decided, and judge the others",
    "stats/sampling_design.py": "says which verdicts a sampler allows; no draw depends on it",
}


def imports(path: Path) -> Iterator[Path]:
    """The modules of rvjax that a module imports. A package that is imported only on the way to a module does not count."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if not isinstance(node, ast.ImportFrom) or not (node.module or "").startswith("rvjax"):
            continue
        for name in node.names:
            module = ROOT.parent / f"{node.module}.{name.name}".replace(".", "/")
            package = ROOT.parent / (node.module or "").replace(".", "/")
            for file in (module.with_suffix(".py"), module / "__init__.py", package.with_suffix(".py"), package / "__init__.py"):
                if file.exists():
                    yield file
                    break


def covered(file: Path, parts: tuple[str, ...] = FLYING) -> bool:
    """Whether the identity holds the source of a file."""
    return any(file.is_relative_to(ROOT / part) for part in parts)


def reached(parts: tuple[str, ...]) -> dict[str, str]:
    """File → the file that imports it, for all that flies by `parts` and all that this imports outside of `WITHOUT_NUMBERS`."""
    todo = [file for part in FLYING for file in (ROOT / part).rglob("*.py")]
    importers = dict.fromkeys(todo, "")
    while todo:
        importer = todo.pop()
        for file in imports(importer):
            if file not in importers and str(file.relative_to(ROOT)) not in WITHOUT_NUMBERS:
                importers[file] = str(importer.relative_to(ROOT))
                todo.append(file)
    return {str(file.relative_to(ROOT)): by for file, by in importers.items() if not covered(file, parts)}


def test_nothing_flies_outside_of_the_identity() -> None:
    """Kills: a module that flights depend on and that can be edited between two halves of a run."""
    assert reached(FLYING) == {}


@pytest.mark.parametrize("part", FLYING[1:4])
def test_a_part_that_is_missing_would_be_noticed(part: str) -> None:
    """The walk sees what it is to see: without a part of the list it names files of that part."""
    missing = reached(tuple(kept for kept in FLYING if kept != part))
    assert any(name.startswith(part) for name in missing)


def test_every_family_that_flies_is_in_the_identity() -> None:
    """Members are found by their names, so no import leads to them. Kills: a new family whose files nobody digests."""
    assert {f"components/{family}" for family in FAMILY_OF.values()} <= set(FLYING)


def test_every_part_exists() -> None:
    """Kills: a renamed package that silently falls out of the identity."""
    assert [part for part in FLYING if not (ROOT / part).exists()] == []


@pytest.mark.parametrize(
    ("overrides", "named"),
    [
        (("engine=llvm",), set[str]()),
        (("engine=llvm", "sampler={use: latin-hypercube}", "require=[]"), set[str]()),
        (("engine=llvm", "sampler={use: sobol}", "require=[]"), {"numpy", "scipy"}),
        (("engine=xla",), {"jax", "jaxlib"}),
    ],
)
def test_versions_that_change_no_bit_are_not_part_of_it(overrides: tuple[str, ...], named: set[str]) -> None:
    """Kills: a run that another NumPy refuses to resume although it draws the same; a sampler of SciPy without its version."""
    assert set(identity(load(CAMPAIGN, overrides))["packages"]) == named


def test_the_digest_is_of_these_files_only(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An edit to a manual page or the benchmark keeps old folders; an edit to an equation does not. Kills: a digest of all."""
    for name in ("physics/a.py", "components/faults/b.py", "components/manual.py", "execution/bench/c.py", "__init__.py"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("x = 1\n")
    for part in FLYING:
        (tmp_path / part).parent.mkdir(parents=True, exist_ok=True)
        if part.endswith(".py"):
            (tmp_path / part).write_text("")
        else:
            (tmp_path / part).mkdir(exist_ok=True)
    monkeypatch.setattr(rvjax, "__file__", str(tmp_path / "__init__.py"))
    before = source_digest(FLYING)
    for name, changes in (("components/manual.py", False), ("execution/bench/c.py", False), ("physics/a.py", True)):
        (tmp_path / name).write_text("x = 2\n")
        assert (source_digest(FLYING) != before) is changes, name
