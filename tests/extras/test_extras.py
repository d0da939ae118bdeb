"""With the packages of the core only: everything that needs no extra works, and everything else says what to install.

These tests run in two places: by default in a process from which the packages of the extras are hidden; and in an environment
where they were never installed (.github/workflows/wheel.yml):

    pip install . pytest; pytest --noconftest tests/extras
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import xml.etree.ElementTree as ET
from importlib.metadata import requires
from importlib.util import find_spec
from pathlib import Path

import pytest

from rvjax.components import extras
from tests.short import CAMPAIGN, QUICK, SHORT

ROOT = Path(__file__).parents[2]
EXTRAS = {
    "cloud": ("fsspec", "s3fs"),
    "dask": ("dask", "distributed", "bokeh"),
    "tune": ("optuna",),
    "bench": ("diffrax",),
    "crosscheck": ("bsk",),
    "peers": ("openturns", "bsk", "vbar"),
    "rerun": ("rerun-sdk",),
    "mcap": ("mcap",),
}
TUNING = ROOT / "campaigns" / "tuning" / "pd-plus.yaml"
SETS = [word for value in (*SHORT, QUICK, "samples=2", "keep={worst: 1}") for word in ("--set", value)]

Ended = tuple[int, str, str]


def test_the_extras_are_those_of_the_package() -> None:
    """Kills: an extra of pyproject.toml that these tests leave out."""
    named = {match for text in requires("rvjax") or () for match in re.findall(r"extra == '(\w+)'", text.replace('"', "'"))}
    assert named == {*EXTRAS, "dev", "docs"}


@pytest.fixture(scope="module")
def ended(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Ended]:
    """How commands end, by name."""
    place = tmp_path_factory.mktemp("core")
    paths = {}
    for method in ("tpe", "nsga"):
        paths[method] = place / f"{method}.yaml"
        paths[method].write_text(TUNING.read_text().replace("{use: cma-es}", f"{{use: {method}}}"))
    dask = ["--dask", "local:2", *SETS]
    commands = {
        "run --dask": ["run", CAMPAIGN, *dask, "--out", place / "run"],
        "run --dask --json": ["run", CAMPAIGN, *dask, "--json", "--junit-xml", place / "run.xml", "--out", place / "run"],
        "check --dask": ["check", CAMPAIGN, *dask, "--junit-xml", place / "check.xml", "--out", place / "run"],
        "validate tpe": ["validate", paths["tpe"]],
        "tune tpe": ["tune", paths["tpe"], "--out", place / "tune"],
        "tune tpe --json": ["tune", paths["tpe"], "--json", "--out", place / "tune"],
        "validate nsga": ["validate", paths["nsga"]],
        "tune nsga": ["tune", paths["nsga"], "--out", place / "tune"],
        "explain tpe": ["explain", "tpe"],
        "list": ["list"],
        "doctor": ["doctor", "--json"],
        "run": ["run", CAMPAIGN, *SETS, "--out", place / "flown"],
    }
    hidden = [package for packages in EXTRAS.values() for package in packages if find_spec(package) is not None]
    flown = subprocess.run(
        [sys.executable, "-m", "tests.extras.core_only", *hidden],
        input=json.dumps([[str(word) for word in words] for words in commands.values()]),
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
        timeout=300,
    )
    results = {name: tuple(result) for name, result in zip(commands, json.loads(flown.stdout), strict=True)}
    results["place"] = (0, str(place), "")
    return results


@pytest.mark.parametrize("name", ["run --dask", "run --dask --json", "check --dask"])
def test_dask_is_missing(name: str, ended: dict[str, Ended]) -> None:
    """Kills: a traceback, a JUnit file that was promised, a run folder that stays, another package's name."""
    code, out, err = ended[name]
    assert code == 2
    said = json.loads(out)["error"] if "--json" in name else err
    assert "--dask needs dask>=" in said
    assert "distributed>=" in said
    assert said.count("(not installed)") == 2
    assert "pip install 'rvjax[dask]'" in said
    assert "Traceback" not in out + err
    place = Path(ended["place"][1])
    assert not (place / "run").exists()
    for report in ("run.xml", "check.xml"):
        assert "rvjax[dask]" in ET.tostring(ET.parse(place / report).getroot(), encoding="unicode")


@pytest.mark.parametrize("method", ["tpe", "nsga"])
def test_optuna_is_missing(method: str, ended: dict[str, Ended]) -> None:
    """`validate` and `tune` say the same, with line and column. Kills: a traceback; code 4; a folder without a search."""
    lines = TUNING.read_text().splitlines()
    row = next(number for number, line in enumerate(lines, 1) if "{use: cma-es}" in line)
    column = lines[row - 1].index("cma-es") + 1
    expected = (
        rf"{method}\.yaml:{row}:{column}: tune\.method\.use: the method {method} needs optuna>=\d+\.\d+ \(not installed\); "
        r"accepted: pip install 'rvjax\[tune\]'"
    )
    for command in ("validate", "tune"):
        code, out, err = ended[f"{command} {method}"]
        assert code == 2
        assert re.search(expected, err)
        assert "Traceback" not in out + err
    code, out, _ = ended["tune tpe --json"]
    assert code == 2
    assert "rvjax[tune]" in json.dumps(json.loads(out))
    assert not (Path(ended["place"][1]) / "tune").exists()


def test_the_core_needs_no_extra(ended: dict[str, Ended]) -> None:
    """A flight with its report, the manual, the list of components. Kills: an import of an extra by what does without."""
    for name in ("explain tpe", "list", "doctor", "run"):
        code, _, err = ended[name]
        assert code in ((0, 3) if name == "run" else (0,)), (name, err)
    assert (Path(ended["place"][1]) / "flown" / "report.html").stat().st_size > 50_000


@pytest.mark.parametrize(("installed", "lacks"), [("4.9.1", True), ("5.0", False), ("5.1.0.dev0", False), ("11.0", False)])
def test_a_package_that_is_too_old(installed: str, lacks: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Against the bound in pyproject.toml. Kills: a traceback later, from a function that the old version does not have; versions
    compared as text, by which 11 is older than 5."""
    monkeypatch.setattr(extras, "find_spec", lambda package: object())
    monkeypatch.setattr(extras, "version", lambda package: installed)
    assert extras.lacking("optuna") == (f"optuna>=5.0 ({installed} is installed)" if lacks else "")
