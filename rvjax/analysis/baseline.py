"""A baseline file, kept with the code: is a new run significantly worse on the same draws?

For each sample the file says which requirements it complies with, and the values of some metrics. A run on the same draws is
compared pair by pair; the null hypothesis of each one-sided test is "no worse":

    requirement    McNemar's exact test: samples that complied and no longer do, against those that do now and did not
    metric         sign test: is the metric worse by more than `TOLERANCE` (relative) in more than half of the samples?

and Holm's correction over all tests at the risk `RISK`: a change that makes nothing worse fails with at most this probability.
The same code on the same draws gives the same bits, and cannot fail. The tolerance covers last digits that depend on the compiler
or processor.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd  # pyright: ignore[reportMissingTypeStubs]
from numpy.typing import NDArray

from rvjax.analysis.baseline_file import FORMAT, MOST, BaselineFile, MetricValues, read
from rvjax.analysis.verdicts.compliance import RequirementEvaluator, complies
from rvjax.analysis.verdicts.folders import campaign_of
from rvjax.analysis.verdicts.sentences import title
from rvjax.campaign import Requirement
from rvjax.columns import DRAW, FAILED, Column, drawn_columns, metric_column
from rvjax.errors import UsageError
from rvjax.places import Place
from rvjax.run_folder import RunFolder, atomic_files
from rvjax.stats import holm, mcnemar

TOLERANCE = 0.005
RISK = 1e-4
METRICS = (
    *("settling_time_s", "attitude_settling_time_s", "window_position_error_m", "window_attitude_error_deg"),
    *("delta_v_m_s", "angular_impulse_Nms"),
)
"""Metrics that are compared besides the requirements, if the run has them."""

SAME = 1e-9
"""Draws count as the same up to this relative difference, since SciPy versions may differ in the last digits."""

Values = NDArray[np.float64]


@dataclass(frozen=True)
class BaselineComparison:
    """A run against its baseline in a requirement or metric.

    what: in words. worse, better: numbers of samples. p: corrected p-value of the one-sided test.
    """

    what: str
    worse: int
    better: int
    p: float

    @property
    def significant(self) -> bool:
        """Whether the run is significantly worse: the comparison fails."""
        return self.p <= RISK

    def sentence(self, baseline: str) -> str:
        """The result as a sentence. baseline: the name of its file."""
        result = "significantly worse" if self.significant else "not significantly worse"
        return f"{self.what}: {result} than {baseline}: {self.worse} samples worse, {self.better} better (p = {self.p:.2g})."


def write(folder: str | Place, path: Path) -> None:
    """Writes the baseline of a finished run. Errors as in `account_and_verdicts`; UsageError if nothing can be compared."""
    atomic_files.replace(path, _of(RunFolder.open(folder)).encode())


def against(folder: str | Place, path: Path) -> list[BaselineComparison]:
    """Compares a finished run with a baseline.

    UsageError if the file is not a baseline, or if its draws, requirements or metrics differ from the run.
    """
    before, now = read(path), _of(RunFolder.open(folder))
    _refuse(path, _difference(before, now))
    results: list[tuple[str, int, int, float]] = []
    for name, marks in now.requirements.items():
        old, new = (np.array(list(text)) == "1" for text in (before.requirements[name], marks))
        worse, better = int((old & ~new).sum()), int((~old & new).sum())
        results.append((name, worse, better, float(mcnemar(worse, better, better="a"))))
    for name, metric in now.metrics.items():
        old, new = (_values(entry) for entry in (before.metrics[name], metric))
        worse, better = steps(old, new, metric.better == "higher")
        results.append((name, int(worse.sum()), int(better.sum()), more_than_half(int(worse.sum()), len(worse))))
    corrected = holm([p for *_, p in results]) if results else []
    return [
        BaselineComparison(name, worse, better, float(p)) for (name, worse, better, _), p in zip(results, corrected, strict=True)
    ]


def check(path: Path, requirements: Sequence[Requirement], samples: int | None) -> None:
    """What `against` refuses of a run that is about to fly. samples: None where their number is not yet known."""
    before = read(path)
    if samples is not None:
        _refuse(path, _other_samples(before, min(samples, MOST)))
    judged = [requirement for requirement in requirements if not requirement.mean]
    _refuse(path, _other_names("requirements", before.requirements, _titles(judged)))


def _refuse(path: Path, difference: str) -> None:
    """UsageError where there is a difference."""
    if difference:
        raise UsageError(f"{path}: {difference}; if the change is intended, make it again with --write-baseline")


def _titles(requirements: Sequence[Requirement]) -> list[str]:
    """The names of requirements in a baseline."""
    return [f"{n}. {title(requirement)}" for n, requirement in enumerate(requirements, 1)]


def steps(old: Values, new: Values, higher: bool) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """(n,) which samples are worse, and which better, by more than the tolerance. Not finite is the worst value."""
    sign = -1.0 if higher else 1.0
    old, new = sign * old, sign * new
    with np.errstate(invalid="ignore"):
        tolerance = TOLERANCE * np.maximum(np.abs(old), np.abs(new))
        change = new - old
    both = np.isfinite(old) & np.isfinite(new)
    worse = np.where(both, change > tolerance, ~np.isfinite(new) & np.isfinite(old))
    better = np.where(both, change < -tolerance, ~np.isfinite(old) & np.isfinite(new))
    return worse, better


def more_than_half(count: int, n: int) -> float:
    """P(X ≥ count), X binomial with n and 1/2."""
    from scipy.special import bdtrc  # pyright: ignore[reportMissingTypeStubs, reportUnknownVariableType]

    return 1.0 if count == 0 else float(bdtrc(count - 1, n, 0.5))


def _of(folder: RunFolder) -> BaselineFile:
    """The baseline of a run."""
    campaign, columns = campaign_of(folder), folder.columns()
    drawn = drawn_columns(columns)
    shown = [name for name in METRICS if metric_column(name) in columns]
    evaluators = [RequirementEvaluator(requirement) for requirement in campaign.require if not requirement.mean]
    needed = dict.fromkeys([*drawn, *(metric_column(name) for name in shown)])
    for evaluator in evaluators:
        needed |= dict.fromkeys(evaluator.columns(list(columns)))
    frame = _first(folder, ["sample", "outcome", *needed])
    if not evaluators and not shown:
        raise UsageError(f"{folder.path}: no requirement and no metric to compare")
    requirements = [evaluator.requirement for evaluator in evaluators]
    marks = {name: _marks(requirement, frame) for name, requirement in zip(_titles(requirements), requirements, strict=True)}
    return BaselineFile(
        format=FORMAT,
        campaign=campaign.name,
        samples=len(frame),
        draws={name.removeprefix(DRAW): _digest(frame[name].to_numpy(dtype=float)) for name in drawn},
        requirements=marks,
        metrics={name: _metric(frame, columns, name) for name in shown},
    )


def _first(folder: RunFolder, names: list[str]) -> pd.DataFrame:
    parts: list[pd.DataFrame] = []
    for _, frame, _ in folder.some(names):
        parts.append(frame)
        if sum(map(len, parts)) >= MOST:
            break
    return pd.concat(parts, ignore_index=True).iloc[:MOST]


def _digest(values: Values) -> list[float]:
    """First, last, mean and number of the finite values: enough to notice other draws."""
    finite = values[np.isfinite(values)]
    return [float(finite[0]), float(finite[-1]), float(finite.mean()), float(finite.size)] if finite.size else []


def _marks(requirement: Requirement, frame: pd.DataFrame) -> str:
    """A digit for each sample: 1 if it complies or is not of the class, otherwise 0."""
    return "".join("1" if complying else "0" for complying in complies(requirement, frame))


def _metric(frame: pd.DataFrame, columns: Mapping[str, Column], name: str) -> MetricValues:
    column = metric_column(name)
    values = np.where(frame["outcome"].isin(FAILED), math.nan, frame[column].to_numpy(dtype=float))
    rounded = [float(f"{x:.9g}") if math.isfinite(x) else None for x in values]
    return MetricValues(better="higher" if columns[column].better == "higher" else "lower", values=rounded)


def _values(metric: MetricValues) -> Values:
    worst = -math.inf if metric.better == "higher" else math.inf
    return np.array([worst if value is None else value for value in metric.values], dtype=float)


def _difference(before: BaselineFile, now: BaselineFile) -> str:
    """Why a baseline and a run cannot be compared; empty if they can."""
    names = (_other_names(part, getattr(before, part), getattr(now, part)) for part in ("draws", "requirements", "metrics"))
    if difference := _other_samples(before, now.samples) or next(filter(None, names), ""):
        return difference
    for name, digest in now.draws.items():
        if len(digest) != len(before.draws[name]) or not np.allclose(digest, before.draws[name], rtol=SAME, atol=0.0):
            return f"its draws of {name} differ from the run"
    for name, metric in now.metrics.items():
        if before.metrics[name].better != metric.better:
            return f"its metric {name} says that {before.metrics[name].better} is better, the run says {metric.better}"
    return ""


def _other_samples(before: BaselineFile, samples: int) -> str:
    """That a baseline has another number of samples; empty if it has not."""
    return "" if before.samples == samples else f"it has {before.samples} samples, the run has {samples}"


def _other_names(part: str, before: Iterable[str], now: Iterable[str]) -> str:
    """That a baseline has other draws, requirements or metrics; empty if it has not."""
    odd = sorted({*before} ^ {*now})
    return f"its {part} differ from the run: {', '.join(odd[:3])}" if odd else ""
