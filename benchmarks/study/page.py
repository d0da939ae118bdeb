"""Writes the tables of docs/study.md from the record of the study: `python -m benchmarks.study.page [--check]`.

A table stands between `<!-- table: NAME -->` and `<!-- end of table -->`. With `--check` nothing is written, and the exit code is
1 if a table of the page differs.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from benchmarks.study.results import RECORD
from benchmarks.study.tables import TABLES

PAGE = Path(__file__).parents[2] / "docs" / "study.md"
PLACE = re.compile(r"(<!-- table: (\w+) -->\n)(.*?)(<!-- end of table -->)", re.DOTALL)


def written(page: str, record: Mapping[str, Any]) -> str:
    """The page with the tables of this record. KeyError for a place that no table has."""
    return PLACE.sub(lambda place: f"{place[1]}\n{TABLES[place[2]](record)}\n\n{place[4]}", page)


def main() -> None:
    """Writes, or checks."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="compare only")
    parser.add_argument("--record", type=Path, default=RECORD, help="the record; default that of the repository")
    given = parser.parse_args()
    page = PAGE.read_text(encoding="utf-8")
    new = written(page, json.loads(given.record.read_text(encoding="utf-8")))
    if not given.check:
        PAGE.write_text(new, encoding="utf-8")
    elif new != page:
        sys.exit(f"{PAGE}: a table differs from {given.record}; accepted: what `python -m benchmarks.study.page` writes")
    else:
        print(f"the {len(PLACE.findall(page))} tables of {PAGE.name} are those of {given.record}")


if __name__ == "__main__":
    main()
