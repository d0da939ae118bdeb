"""The stages of the study. Each is a command of rvjax with a run folder, so it resumes, and a finished one flies nothing."""

from __future__ import annotations

import json
import shlex
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from ruamel.yaml import YAML

from benchmarks.study.controllers import CAMPAIGN, Entry

JUDGED = (0, 1, 3)
"""Exit codes of a command that did its work: PASS, FAIL, UNDECIDED."""

SEARCH: Mapping[str, Any] = {
    "objective": {"metric": "delta_v_m_s", "quantile": 0.95},
    "method": {"use": "cma-es"},
    "samples": 1664,
    "race": {"first": 104, "hard": 26},
}
"""Section `tune` of every search, without parameters and sizes."""


class Size(NamedTuple):
    """samples of the campaign; candidates of a search, and samples of its confirmation; flights of a search for collisions,
    beside `ordinary` samples.
    """

    samples: int = 106_496
    candidates: int = 200
    confirmed: int = 8_320
    flights: int = 30_000
    ordinary: int = 4_160


def loaded(path: Path) -> dict[str, Any]:
    """A document in JSON."""
    return json.loads(path.read_text(encoding="utf-8"))


def searched() -> list[dict[str, Any]]:
    """Requirements of every search: those of the campaign that a few thousand samples can judge, so not the one on collisions."""
    given = YAML(typ="safe").load(CAMPAIGN.read_text(encoding="utf-8"))["require"]
    return [{key: value for key, value in each.items() if key != "id"} for each in given if each["id"] != "collision"]


def _setting(place: str, value: Any) -> list[str]:
    return ["--set", f"{place}={json.dumps(value)}"]


def command(arguments: Sequence[str]) -> None:
    """Runs `rvjax …` and shows it. SystemExit where it does not do its work."""
    print(f"\n$ rvjax {shlex.join(arguments)}", flush=True)
    code = subprocess.call([sys.executable, "-m", "rvjax", *arguments, "--quiet"])
    if code not in JUDGED:
        raise SystemExit(code)


def search(entry: Entry, folder: Path, size: Size) -> None:
    """Searches the gains of a controller: the least fuel that 95 % of the flights do with, under the safety requirements."""
    tune = {
        **SEARCH,
        "parameters": entry.searched(),
        "budget": {"candidates": size.candidates},
        "confirm": {"samples": size.confirmed},
    }
    given = [*_setting("controller", dict(entry.controller)), *_setting("require", searched()), *_setting("tune", tune)]
    command(["tune", str(CAMPAIGN), *given, "--out", str(folder)])


class Found(NamedTuple):
    """candidate: its number, 0 for the shipped gains. met: whether it met the requirements on the samples of the search; if not,
    it is the candidate that came closest. flights: of the search; full: of all candidates on all samples. gains: searched and
    tied ones.
    """

    candidate: int
    met: bool
    flights: int
    full: int
    gains: dict[str, float]


def found(folder: Path) -> Found:
    """What a search ended with."""
    record = loaded(folder / "search.json")
    met = not record["missed"]
    number = record["best"] if met else record["closest"]
    row = next(row for row in reversed(record["rows"]) if row["candidate"] == number)
    gains = {name.removeprefix("controller.gains."): value for name, value in row["values"].items()}
    return Found(number, met, record["cost"]["flights"], record["cost"]["full"], gains)


def fly(entries: Sequence[Entry], searches: Path, folder: Path, size: Size, dask: str | None) -> None:
    """Flies all controllers with the gains of their searches on the same draws; the first is the controller under test."""
    first, *others = [entry.named(found(searches / entry.name).gains) for entry in entries]
    given = [*_setting("controller", first), *_setting("baselines", others)]
    given += ["--samples", str(size.samples), *(["--dask", dask] if dask else [])]
    command(["run", str(CAMPAIGN), *given, "--out", str(folder)])


def collisions(entry: Entry, searches: Path, folder: Path, size: Size) -> None:
    """Estimates the probability of a collision, the first requirement, by splitting."""
    controller = entry.named(found(searches / entry.name).gains)
    given = [*_setting("controller", controller), "--samples", str(size.ordinary), "--flights", str(size.flights)]
    command(["rare", str(CAMPAIGN), "--requirement", "1", *given, "--out", str(folder)])


def drivers(folder: Path, result: str) -> list[dict[str, Any]]:
    """What `rvjax drivers` says about a result of a run."""
    arguments = ["drivers", str(folder), "--result", result, "--json", "--quiet"]
    came = subprocess.run([sys.executable, "-m", "rvjax", *arguments], check=True, capture_output=True, encoding="utf-8")
    return json.loads(came.stdout)["pairs"]
