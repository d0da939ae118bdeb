"""Help and tables on narrow terminals."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rvjax.cli import COMMANDS
from rvjax.cli._tables import LONGEST, fitted
from tests.program import Run
from tests.short import CAMPAIGN


@pytest.fixture(params=[80, 60, 40])
def width(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> int:
    monkeypatch.setenv("COLUMNS", str(request.param))
    return request.param


def test_every_line_of_help_fits(width: int, rvjax: Run) -> None:
    """Kills: typer's smallest width of 50 columns; a word that is broken; a summary that is cut."""
    whole = re.sub(r"\s+", " ", "".join(rvjax("--help")[1]))
    assert "..." not in whole.replace("[ARGS]...", "")
    for name in COMMANDS:
        code, page, _ = rvjax(name, "--help")
        assert code == 0
        assert max(map(len, page.splitlines())) <= width, name
        summary = page.partition("\n\n")[2].partition("\n\n")[0]
        sentence = re.sub(r"\s+", " ", summary).strip().partition(". ")[0].rstrip(".")
        assert f" {name} {sentence}" in whole
        if "<identity>" in page:
            assert "reports/<name>/<identity>." in page


def test_a_summary_is_one_line_of_80_columns(rvjax: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: a summary that grows beyond its line."""
    monkeypatch.setenv("COLUMNS", "80")
    page = rvjax("--help")[1]
    listed = page.partition("Commands:\n")[2].partition("\n\n")[0].splitlines()
    assert [line.split()[0] for line in listed] == list(COMMANDS)
    assert all(line.endswith(".") and "..." not in line for line in listed)


def test_tables_break_no_number_and_no_name(width: int, rvjax: Run, flown: Path) -> None:
    """Kills: columns that all give way alike, so that "1,049" becomes "1,04" and "9"; a table wider than the terminal."""
    calls = {
        ("plan", "--at-least", 0.99): ("1,049", "1,693", "99.75 %", "1 − 2e-06", "UNDECIDED", "samples, mean"),
        ("list",): ("nominal-backstepping", "Ornstein", "proportional-derivative"),
        ("compare", flown, flown): ("UNDECIDED", "100.00\u00a0%", "B only", "p, Holm"),
        ("check", flown): ("UNDECIDED",),
        ("doctor", flown): ("audit",),
        ("plan", CAMPAIGN): ("99.75 %", "UNDECIDED"),
        ("explain", "saturated-adaptive"): ("true, false", "gains.mass_guess_kg", "quadratic-cos"),
    }
    for words, kept in calls.items():
        out = rvjax(*words)[1]
        flat = re.sub(r"\s+", " ", out)
        for text in kept:
            assert text in flat or text in out, (words, text)
        ruled = [line for line in out.splitlines() if line.startswith(" ─")]
        assert all(len(line) <= width for line in ruled), words


@pytest.mark.parametrize(
    ("head", "rows", "width", "widths"),
    [
        (("a", "b"), [("1", "2")], 10, [1, 1]),
        (("a", "b"), [("1,049", "long words give way")], 20, [5, 10]),
        (("a", "b"), [("1,049", "12 characters")], 20, None),  # a short cell stays whole
        (("UNDECIDED", "b"), [("0 %", "seventh seventh seventh")], 20, None),  # 2 + 9 + 3 leave 6 columns
        (("a",), [("x" * 99,)], 50, [48]),
        (("a",), [("x" * 99,)], LONGEST, None),
        (("a", "b"), [("two\nlines", "日本")], 80, [5, 4]),
    ],
)
def test_widths(head: tuple[str, ...], rows: list[tuple[str, ...]], width: int, widths: list[int] | None) -> None:
    """By hand: 2 columns of edges, 3 between two columns. Kills: a short cell that is broken, a wrong sum, bytes for cells."""
    assert fitted(head, rows, width) == widths


def test_a_table_that_does_not_fit_becomes_blocks(rvjax: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: a block without headings, a cell that is lost."""
    monkeypatch.setenv("COLUMNS", "40")
    out = rvjax("plan", "--at-least", 0.99)[1]
    block = "failures: 5\n  samples: 1,049\n  pass at 99.5 %: 57.3 %\n  pass at 99.75 %: 95.0 %\n  pass at 99.9 %: 99.9 %\n"
    assert block in out
