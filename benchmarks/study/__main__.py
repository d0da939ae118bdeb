"""Repeats the study of docs/study.md: `python -m benchmarks.study [--out DIR] [--dask WHERE] [--stage NAME …]`.

In order: a search of gains for each controller, all controllers on the same draws, an estimate of the probability of a collision
for each, then the record of all numbers with the figures. Every stage resumes where it was stopped. `python -m
benchmarks.study.page` then writes the tables of the page from the record.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

from benchmarks.study import figures, stages
from benchmarks.study.controllers import CONTROLLERS, entries
from benchmarks.study.results import RECORD, record

STAGES = ("search", "fly", "collisions", "record")


def _arguments() -> argparse.Namespace:
    size = stages.Size()
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("reports/study"), help="folder of all run folders")
    parser.add_argument("--controllers", type=Path, default=CONTROLLERS, help="file of the controllers; the first is under test")
    parser.add_argument("--record", type=Path, default=RECORD, help="file of all numbers; default that of the repository")
    parser.add_argument("--pictures", type=Path, default=figures.DOCS, help="folder of the figures")
    parser.add_argument("--dask", help="fly the campaign on Dask workers, as in `rvjax run --dask`")
    parser.add_argument("--stage", choices=STAGES, action="append", help="only this stage; repeatable")
    parser.add_argument("--samples", type=int, default=size.samples, help="of the campaign")
    parser.add_argument("--candidates", type=int, default=size.candidates, help="of each search of gains")
    parser.add_argument("--confirmed", type=int, default=size.confirmed, help="samples that confirm a search")
    parser.add_argument("--flights", type=int, default=size.flights, help="of each search for collisions")
    parser.add_argument("--ordinary", type=int, default=size.ordinary, help="samples beside each search for collisions")
    return parser.parse_args()


def main() -> None:
    """All stages, or those that are named."""
    given = _arguments()
    studied, searches = entries(given.controllers), given.out / "searches"
    size = stages.Size(given.samples, given.candidates, given.confirmed, given.flights, given.ordinary)
    for stage in STAGES:
        if stage not in (given.stage or STAGES):
            continue
        begun = time.perf_counter()
        match stage:
            case "search":
                for entry in studied:
                    stages.search(entry, searches / entry.name, size)
            case "fly":
                stages.fly(studied, searches, given.out / "flights", size, given.dask)
            case "collisions":
                for entry in studied:
                    stages.collisions(entry, searches, given.out / "collisions" / entry.name, size)
            case _:
                came = record(studied, given.out)
                given.record.write_text(json.dumps(came, indent=1) + "\n", encoding="utf-8")
                figures.cost(came, given.pictures)
                figures.clearance(came, given.out, given.pictures)
        print(f"\n{stage}: {time.perf_counter() - begun:,.0f} s", flush=True)


if __name__ == "__main__":
    main()
