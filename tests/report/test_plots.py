"""`run.plot`: the figures of the report, and a picture for a notebook. `rvjax view`, `rvjax report --pdf`."""

from __future__ import annotations

import json
import shutil
import webbrowser
from collections.abc import Callable
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from numpy.typing import NDArray

import rvjax
from rvjax.errors import UsageError
from rvjax.report import pdf, plots
from rvjax.report.plotting import STYLE
from rvjax.report.run_view import open_run
from rvjax.report.sections import sections
from tests.once import made_once
from tests.program import Run
from tests.report.browser import required
from tests.report.conftest import Within


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, made: Callable[..., Path]) -> Path:
    return made_once(tmp_path_factory, "plots", lambda path: made(path, 60))


def _same(a: NDArray[np.float64], b: NDArray[np.float64]) -> bool:
    return np.array_equal(a, b, equal_nan=True)


def test_every_figure_is_that_of_the_report(folder: Path) -> None:
    """The same points in every line. Kills: a figure of the report that a run does not have; a method with another's figure."""
    with matplotlib.rc_context(STYLE):
        report = {drawing.name: drawing.figure for part in sections(open_run(folder)) for drawing in part.drawings}
    run = rvjax.Run(folder)
    others = ("of", "evidence", "comparison", "safety")
    methods = [name for name in dir(run.plot) if not name.startswith("_") and name not in others]
    drawn = {}
    for name in methods:
        panels = getattr(run.plot, name)()
        drawn[name] = [line.get_xydata() for axis in panels for line in axis.get_lines()]
        assert panels.figure.axes == [*panels]
    assert len(methods) == len(report)
    expected = [[line.get_xydata() for axis in figure.axes for line in axis.get_lines()] for figure in report.values()]
    for lines in drawn.values():
        same = [i for i, other in enumerate(expected) if len(other) == len(lines) and all(map(_same, other, lines))]
        assert same
        del expected[same[0]]


def test_a_notebook_shows_the_picture(folder: Path) -> None:
    """Kills: a repr of axes in the place of a picture; axes that cannot be changed."""
    (axis,) = panels = rvjax.Run(folder).plot.settling()
    axis.set_title("mine")
    assert panels._repr_png_().startswith(b"\x89PNG")
    assert panels.figure.axes[0].get_title(loc="center") or panels.figure.axes[0].get_title(loc="left") == "mine"


def test_a_figure_that_a_run_does_not_have(folder: Path) -> None:
    """Kills: an empty picture, a traceback."""
    with pytest.raises(UsageError, match="nothing for the figure evidence"):
        rvjax.Run(folder).plot.evidence()
    assert set(plots._MADE_BY) >= {"settling-times", "trajectories"}


def test_view_opens_the_report(folder: Path, rvjax: Run, undrawn: Within, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kills: a browser with --print; a missing browser that is an error; a folder without a report that opens nothing."""
    opened: list[str] = []
    monkeypatch.setattr(webbrowser, "open", lambda address: bool(opened.append(address)) or len(opened) == 1)
    code, _, err = rvjax("view", folder)
    assert code == 2
    assert "no report; accepted: " in err
    with undrawn():
        assert rvjax("report", folder)[0] == 0
    address = (folder / "report.html").resolve().as_uri()
    assert rvjax("view", folder, "--print") == (0, f"{address}\n", "")
    assert rvjax("view", folder, "--print", "--sample", 17, "--at", 83.2)[1] == f"{address}#sample=17&t=83.2\n"
    assert rvjax("view", folder, "--print", "--at", 83.2)[0] == 2
    assert opened == []
    code, out, _ = rvjax("view", folder, "--json")
    assert (code, json.loads(out)) == (0, {"report": address, "opened": True})
    code, out, err = rvjax("view", folder)
    assert (code, out) == (0, f"{address}\n")
    assert "no browser here" in err


def test_pdf_without_a_browser_is_refused_at_once(
    folder: Path, rvjax: Run, undrawn: Within, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Kills: a report that is built first; a traceback; a browser that prints nothing and is believed."""
    monkeypatch.setenv(pdf.CHOSEN, "no-such-browser")
    code, _, err = rvjax("report", folder, "--pdf")
    assert code == 2
    assert "RVJAX_CHROMIUM=no-such-browser: no Chromium that can print the report; accepted: Chromium, Chrome or Edge" in err
    monkeypatch.setenv(pdf.CHOSEN, shutil.which("true") or "true")
    with undrawn():
        code, _, err = rvjax("report", folder, "--pdf")
    assert code == 2
    assert "printed no PDF (exit code 0: it said nothing)" in err


def test_a_chromium_prints_the_report(folder: Path, rvjax: Run) -> None:
    """Kills: a PDF that is not sealed; one of an earlier report that stays."""
    required()
    code, out, _ = rvjax("report", folder, "--pdf", "--json")
    assert code == 0
    printed = Path(json.loads(out)["pdf"])
    assert printed.read_bytes().startswith(b"%PDF")
    assert rvjax("doctor", folder)[0] == 0
    assert rvjax("report", folder)[0] == 0
    assert not printed.exists()
