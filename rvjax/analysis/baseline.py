"""A baseline that is kept with the code: is this run significantly worse on the same draws?

The file holds, sample by sample, which requirements were complied with and the values of some metrics. A run on the same draws is
compared pair by pair, each comparison one-sided against "no worse":

    requirement    McNemar's exact test: samples that complied and no longer do, against those that do now and did not
    metric         sign test: is the metric worse by more than `TOLERANCE` (relative) in more than half of the samples?

and Holm's correction over all of them at the risk `RISK`: so often at most does a change that makes nothing worse fail. The same
code on the same draws gives the same bits, and cannot fail. The tolerance is for what compilers and processors change in the last
digits.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd  # pyright: ignore[reportMissingTypeStubs]
from numpy.typing import NDArray

from rvjax.analysis.verdicts.compliance import RequirementEvaluator, complies
from rvjax.analysis.verdicts.folders import campaign_of
from rvjax.analysis.verdicts.sentences import title
from rvjax.columns import DRAW, Column, drawn_columns, metric_column
from rvjax.errors import UsageError
from rvjax.run_folder import RunFolder, atomic_files
from rvjax.stats import holm, mcnemar

FORMAT = 1
MOST = 2_000
"""Samples in a file, at most: the first ones."""

TOLERANCE = 0.005
RISK = 1e-4
METRICS = (
    *("settling_time_s", "attitude_settling_time_s", "window_position_error_m", "window_attitude_error_deg"),
    *("delta_v_m_s", "angular_impulse_Nms"),
)
"""Compared beside the requirements, as far as a run has them."""

SAME = 1e-9
"""Draws that differ by less than this, relative, are the same: functions of SciPy may differ in their last digits."""

Values = NDArray[np.float64]


@dataclass(frozen=True)
class BaselineComparison:
    """what: in words. worse, better: samples. p: of the one-sided test, corrected. significant: whether it fails."""

    what: str
    worse: int
    better: int
    p: float

    @property
    def significant(self) -> bool:
        """Whether the run is significantly worse."""
        return self.p <= RISK

    def told(self, baseline: str) -> str:
        """In a sentence."""
        found = "significantly worse" if self.significant else "not significantly worse"
        return f"{self.what}: {found} than {baseline}: {self.worse} samples worse, {self.better} better (p = {self.p:.2g})."


def write(folder: str | Path, path: Path) -> None:
    """Makes the baseline of a finished run. Errors as of `account_and_verdicts`, UsageError where nothing can be compared."""
    atomic_files.replace(path, (json.dumps(_document(RunFolder.open(folder)), indent=1, allow_nan=False) + "\n").encode())


def against(folder: str | Path, path: Path) -> list[BaselineComparison]:
    """A finished run against a baseline. UsageError where that is none, or of other draws, requirements or metrics."""
    before, now = read(path), _document(RunFolder.open(folder))
    if wrong := _unlike(before, now):
        raise UsageError(f"{path}: {wrong}; make it again with --write-baseline where the change is meant")
    found: list[tuple[str, int, int, float]] = []
    for name, marks in now["requirements"].items():
        old, new = (np.array(list(text)) == "1" for text in (before["requirements"][name], marks))
        worse, better = int((old & ~new).sum()), int((~old & new).sum())
        found.append((name, worse, better, float(mcnemar(worse, better, better="a"))))
    for name, told in now["metrics"].items():
        old, new = (_values(one["values"], one["better"]) for one in (before["metrics"][name], told))
        worse, better = steps(old, new, told["better"] == "higher")
        found.append((name, int(worse.sum()), int(better.sum()), more_than_half(int(worse.sum()), len(worse))))
    corrected = holm([p for *_, p in found]) if found else []
    return [
        BaselineComparison(name, worse, better, float(p)) for (name, worse, better, _), p in zip(found, corrected, strict=True)
    ]


def steps(old: Values, new: Values, higher: bool) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Which samples are worse, and better, by more than the tolerance; what is not finite is the worst value."""
    sign = -1.0 if higher else 1.0
    old, new = sign * old, sign * new
    with np.errstate(invalid="ignore"):
        room = TOLERANCE * np.maximum(np.abs(old), np.abs(new))
        change = new - old
    both = np.isfinite(old) & np.isfinite(new)
    worse = np.where(both, change > room, ~np.isfinite(new) & np.isfinite(old))
    better = np.where(both, change < -room, ~np.isfinite(old) & np.isfinite(new))
    return worse, better


def more_than_half(count: int, n: int) -> float:
    """P(X ≥ count), X binomial with n and 1/2."""
    from scipy.special import bdtrc  # pyright: ignore[reportMissingTypeStubs, reportUnknownVariableType]

    return 1.0 if count == 0 else float(bdtrc(count - 1, n, 0.5))


def _document(folder: RunFolder) -> dict[str, Any]:
    campaign, columns = campaign_of(folder), folder.columns()
    drawn = drawn_columns(columns)
    shown = [name for name in METRICS if metric_column(name) in columns]
    readings = [RequirementEvaluator(one) for one in campaign.require if not one.mean]
    needed = dict.fromkeys([*drawn, *(metric_column(name) for name in shown)])
    for reading in readings:
        needed |= dict.fromkeys(reading.columns(list(columns)))
    frame = _first(folder, ["sample", "outcome", *needed])
    if not readings and not shown:
        raise UsageError(f"{folder.path}: neither requirements nor metrics to compare")
    marks = {f"{n}. {title(one.requirement)}": _marks(one, frame) for n, one in enumerate(readings, 1)}
    return {
        "format": FORMAT,
        "campaign": campaign.name,
        "samples": len(frame),
        "draws": {name.removeprefix(DRAW): _digest(frame[name].to_numpy(dtype=float)) for name in drawn},
        "requirements": marks,
        "metrics": {name: _metric(frame, columns, name) for name in shown},
    }


def _first(folder: RunFolder, names: list[str]) -> pd.DataFrame:
    parts: list[pd.DataFrame] = []
    for _, frame, _ in folder.some(names):
        parts.append(frame)
        if sum(map(len, parts)) >= MOST:
            break
    return pd.concat(parts, ignore_index=True).iloc[:MOST]


def _digest(values: Values) -> list[float]:
    """First, last and mean of the finite values: enough to tell draws apart, and blind to last digits."""
    finite = values[np.isfinite(values)]
    return [float(finite[0]), float(finite[-1]), float(finite.mean()), float(finite.size)] if finite.size else []


def _marks(reading: RequirementEvaluator, frame: pd.DataFrame) -> str:
    """1 where a sample complies, or is not of the class."""
    return "".join("1" if one else "0" for one in complies(reading.requirement, frame))


def _metric(frame: pd.DataFrame, columns: Mapping[str, Column], name: str) -> dict[str, Any]:
    column = metric_column(name)
    values = np.where(frame["outcome"] == "not_finite", math.nan, frame[column].to_numpy(dtype=float))
    rounded = [float(f"{x:.9g}") if math.isfinite(x) else None for x in values]
    return {"better": columns[column].better or "lower", "values": rounded}


def _values(given: list[float | None], better: str) -> Values:
    worst = -math.inf if better == "higher" else math.inf
    return np.array([worst if one is None else one for one in given], dtype=float)


def read(path: Path) -> dict[str, Any]:
    """The baseline as it is in its file. UsageError where that is none."""
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise UsageError(f"{path}: no baseline ({error}); accepted: a file that --write-baseline wrote") from error
    wanted = {"format": int, "campaign": str, "samples": int, "draws": dict, "requirements": dict, "metrics": dict}
    if not isinstance(document, dict) or any(not isinstance(document.get(name), kind) for name, kind in wanted.items()):
        raise UsageError(f"{path}: no baseline; accepted: a file that --write-baseline wrote")
    if document["format"] != FORMAT:
        raise UsageError(f"{path}: a baseline of format {document['format']}; accepted: {FORMAT}")
    if damaged := _damaged(document):
        raise UsageError(f"{path}: no baseline ({damaged}); accepted: a file that --write-baseline wrote")
    return document


def _damaged(document: Mapping[str, Any]) -> str:
    """Which part of it cannot have been written by `write`, as after a merge by hand; empty where none."""
    n = document["samples"]

    def numbers(one: Any, *, none: bool) -> bool:
        return isinstance(one, list) and all(isinstance(x, float | int) or (none and x is None) for x in one)

    for name, digest in document["draws"].items():
        if not numbers(digest, none=False):
            return f"draws of {name}"
    for name, marks in document["requirements"].items():
        if not isinstance(marks, str) or len(marks) != n or set(marks) - {"0", "1"}:
            return f"requirement {name}"
    for name, told in document["metrics"].items():
        if not isinstance(told, dict) or told.get("better") not in ("lower", "higher"):
            return f"metric {name}"
        if not numbers(told.get("values"), none=True) or len(told["values"]) != n:
            return f"metric {name}"
    return ""


def _unlike(before: Mapping[str, Any], now: Mapping[str, Any]) -> str:
    """In what the two are not comparable; empty where they are."""
    if before["samples"] != now["samples"]:
        return f"of {before['samples']} samples, the run has {now['samples']}"
    for part in ("draws", "requirements", "metrics"):
        odd = sorted(before[part].keys() ^ now[part].keys())
        if odd:
            return f"other {part} than the run: {', '.join(odd[:3])}"
    for name, digest in now["draws"].items():
        if len(digest) != len(before["draws"][name]) or not np.allclose(digest, before["draws"][name], rtol=SAME, atol=0.0):
            return f"other draws of {name} than the run"
    return ""
