"""Section: provenance, the command that repeats the run, and the definitions of the metrics."""

from __future__ import annotations

import json
import shlex
from collections.abc import Iterator, Mapping
from typing import Any

from rvjax.report.blocks import Cell, Code, Section, Table
from rvjax.report.number_format import SPACE, count
from rvjax.report.run_view import Run
from rvjax.stats.quantile_sketch import EXACT, RELATIVE_ERROR

_CHUNKS_SHOWN = 32


def section(run: Run) -> Section:
    """Identity, provenance, command, definitions of the metrics, and the hashes of the chunks."""
    lead = "A run with the same identity gives the same samples table, bit for bit."
    chunks = run.chunks[:_CHUNKS_SHOWN]
    start = {name: value for name, value in run.provenance.items() if name != "fixed"}  # has a section
    more = len(run.chunks) - len(chunks)
    rest = f" {count(more)} more {'is' if more == 1 else 'are'} in manifest.json." if more else ""
    tables = (
        Table("Command that repeats this run.", ("command",), ((Code(_command(run)),),)),
        Table("Identity: everything that determines the numbers.", ("key", "value"), _facts(run.identity)),
        Table(
            "Start of the run.",
            ("key", "value"),
            _facts(start),
        ),
        Table("Definitions of the metrics.", ("name", "unit", "meaning", "better"), tuple(_definitions(run))),
        Table(
            f"Chunks of the samples table with their SHA-256.{rest}",
            ("file", "first sample", "samples", "SHA-256"),
            tuple((Code(chunk.file), count(chunk.first), count(chunk.count), Code(chunk.sha256)) for chunk in chunks),
        ),
    )
    body = (_audited(run), *_sketched(run), *(table for table in tables if table.rows))
    return Section("provenance", "Provenance and definitions", lead, body)


def _audited(run: Run) -> str:
    """The result of the audit, which checks that every dispersion and every fixed input acts on the flight, with its warnings."""
    return str(run.audit or "This folder has no record of an audit of its dispersions.")


def _sketched(run: Run) -> tuple[str, ...]:
    """The accuracy of order statistics that were read from sketches; empty if all are exact."""
    if all(run.metric(name).exact for name in run.metrics(".*")):
        return ()
    text = (
        f"The order statistics of the {count(run.flown)} samples are read from sketches, which count values in narrow buckets. "
        f"The {count(EXACT)} smallest and the {count(EXACT)} largest values are exact. Values between them have a relative error "
        f"of up to {100 * RELATIVE_ERROR:.2f}{SPACE}%, and the ends of their intervals are rounded outwards to bucket edges. "
        "Counts and verdicts are exact."
    )
    return (text,)


def _command(run: Run) -> str:
    settings = "".join(f" --set {shlex.quote(item)}" for item in run.overrides if not item.startswith("samples="))
    return f"rvjax run {shlex.quote(run.folder + '/campaign.yaml')} --samples {run.account.requested}{settings}"


def _facts(document: Mapping[str, Any]) -> tuple[tuple[Cell, ...], ...]:
    return tuple((name, Code(value)) for name, value in _leaves(document))


def _leaves(value: object, name: str = "") -> Iterator[tuple[str, str]]:
    """Every scalar of a nested document with its dotted path."""
    if isinstance(value, Mapping):
        for key, item in value.items():
            yield from _leaves(item, f"{name}.{key}" if name else str(key))
    else:
        yield name, value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)


def _definitions(run: Run) -> Iterator[tuple[Cell, ...]]:
    for name in run.metrics(".*"):
        column = run.column(name)
        yield Code(name), column.unit, column.description, column.better
