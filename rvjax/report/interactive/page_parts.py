"""What the page gets for its replay and its linked plots: scripts with their hashes, data blocks, and whether there are any.

The scripts are files beside this one, in the order of `SCRIPTS`. The page runs nothing else: its content security policy names
the SHA-256 of each.
"""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from markupsafe import Markup

from rvjax.analysis.run_totals import PERCENTILES, SETTLING, metric
from rvjax.report.blocks import Section
from rvjax.report.interactive import flights
from rvjax.report.interactive.data_blocks import Block, block
from rvjax.report.interactive.samples import rows_of, samples_block, shown_rows
from rvjax.report.interactive.scene import scene
from rvjax.report.number_format import count
from rvjax.report.run_view import Run
from rvjax.run_folder import RunFolder
from rvjax.stats import quantile_rank

SCRIPTS = (
    "blocks", "vectors", "statistics", "shapes", "webgl", "canvas", "flight", "scene", "camera", "signals", "replay", "controls",
    "samples", "plots", "brushing", "start",
)  # fmt: skip

MOST_FLIGHTS = 50
"""Flights in the page: those at the percentiles, the worst, then by their numbers."""

_HERE = Path(__file__).parent / "scripts"


@dataclass(frozen=True)
class Part:
    """A script element. kind: its type; an empty one is a script that runs."""

    id: str
    kind: str
    content: Markup


@dataclass(frozen=True)
class Interactive:
    """policy: of the page, for scripts; flights, samples: whether the page has them; words: for its texts."""

    policy: str
    parts: tuple[Part, ...]
    flights: int
    samples: int
    words: Mapping[str, str]


def interactive(folder: RunFolder, run: Run, sections: Sequence[Section]) -> Interactive | None:
    """The replay and the linked plots of a run; None for a run without samples."""
    if not len(run.head):
        return None
    numbers = chosen_flights(folder, run)
    replay = _replay_parts(folder, run, numbers) if numbers else []
    shown = shown_rows(run)
    packed, about = samples_block(run, shown, sections, numbers)
    data = [*replay, _json("samples-about", about | {"block": packed.head}), _data("samples-data", packed)]
    codes = [(name, script(name)) for name in SCRIPTS]
    policy = " ".join(f"'sha256-{_hash(text)}'" for _, text in codes)
    parts = (*data, *(Part(f"script-{name}", "", Markup(text)) for name, text in codes))
    return Interactive(policy, parts, len(numbers), len(shown.rows), _words(run, numbers, len(shown.rows), shown.random))


def _words(run: Run, numbers: Sequence[int], rows: int, random: int) -> dict[str, str]:
    if rows == run.flown:
        held = f"all {count(rows)} samples"
    else:
        more = count(rows - random)
        held = (
            f"{count(rows)} of {count(run.flown)} samples: the first {count(random)}, which stand for all of them, and {more} "
            "others that failed or are among the worst. Shares and intervals count only the first ones"
        )
    return {"held": held, "flights": count(len(numbers)), "folder": run.folder}


def chosen_flights(folder: RunFolder, run: Run) -> list[int]:
    """The kept flights that the page replays, the worst first."""
    kept, worst = set(folder.trace_samples()), run.totals.worst["sample"].tolist()
    order = dict.fromkeys([*_percentiles(run), *worst, *sorted(kept)])
    known = set(rows_of(run, [sample for sample in order if sample in kept])["sample"].tolist())
    chosen = [sample for sample in order if sample in known][:MOST_FLIGHTS]
    return [sample for sample in dict.fromkeys([*worst, *chosen]) if sample in chosen]


def _percentiles(run: Run) -> dict[int, float]:
    """sample → percentile of the settling time among the first samples, as `keep.percentiles` keeps them."""
    if SETTLING not in run.totals.metrics:
        return {}
    order = np.argsort(metric(run.head, SETTLING, run.totals.columns), kind="stable")
    return {int(run.head["sample"].iloc[order[quantile_rank(len(order), q)]]): q for q in PERCENTILES}


def _replay_parts(folder: RunFolder, run: Run, samples: Sequence[int]) -> list[Part]:
    """The index of the flights and a block for each; the instants of flights that have the same are in the page once."""
    table = rows_of(run, samples)
    rows = dict(zip(table["sample"].tolist(), table.to_dict("records"), strict=True))
    percentiles, rank = _percentiles(run), {s: k for k, s in enumerate(run.totals.worst["sample"].tolist(), 1)}
    index: list[dict[str, Any]] = []
    parts: list[Part] = []
    clocks: dict[bytes, int] = {}
    for sample in samples:
        trace, row = _finite(folder.trace(sample)), rows[sample]
        packed = block(flights.motion(trace, run.spec, row))
        instants = trace["t_s"].to_numpy(dtype=np.float64)
        clock = clocks.setdefault(instants.tobytes(), len(clocks))
        if clock == len(clocks) - 1 and f"clock-{clock}" not in {part.id for part in parts}:
            text = base64.b64encode(instants.astype("<f8").tobytes()).decode("ascii")
            parts.append(Part(f"clock-{clock}", "application/octet-stream;base64", Markup(text)))
        about = {
            "sample": sample,
            "outcome": str(row["outcome"]),
            "percentile": percentiles.get(sample),
            "worst": rank.get(sample),
            "clock": clock,
            "scene": scene(run.spec, row),
            "faults": flights.faults(run.spec, row),
            "events": flights.events(trace, run.spec, row),
        }
        index.append(about | {"block": packed.head})
        parts.append(_data(f"flight-{sample}", packed))
    about = {"flights": index, "duration": run.spec.horizon.duration_s, "position": run.spec.capture.position_m}
    return [_json("replay-about", about), *parts]


def _finite(trace: pd.DataFrame) -> pd.DataFrame:
    """The rows up to the one where the motion stops being finite; the first row stays."""
    motion = [name for name in trace.columns if str(name).startswith(("rho_", "nu_", "sigma_", "omega_", "target_"))]
    finite = np.isfinite(trace[motion].to_numpy(dtype=float)).all(axis=1)
    return trace.iloc[: max(int(np.argmin(finite)), 1)] if not finite.all() else trace


@cache
def script(name: str) -> str:
    """The text of a script in the page."""
    return (_HERE / f"{name}.js").read_text(encoding="utf-8")


def _hash(text: str) -> str:
    return base64.b64encode(hashlib.sha256(text.encode("utf-8")).digest()).decode("ascii")


def _json(name: str, value: Any) -> Part:
    """A value as JSON in which nothing can end the element."""
    text = json.dumps(_plain(value), ensure_ascii=True, separators=(",", ":"), allow_nan=False)
    for sign in "<>&":
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    return Part(name, "application/json", Markup(text))


def _plain(value: Any) -> Any:
    """NumPy's numbers as Python's, and what is not finite as null."""
    if isinstance(value, Mapping):
        return {str(key): _plain(part) for key, part in value.items()}
    if isinstance(value, Iterable) and not isinstance(value, str):
        return [_plain(part) for part in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not np.isfinite(value) else value


def _data(name: str, packed: Block) -> Part:
    return Part(name, "application/octet-stream;base64", Markup(packed.text))
