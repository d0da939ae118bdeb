"""Two designs flown on the same draws: A, the reference, and B, the change.

Of n pairs of samples, b succeed with A alone and c with B alone; only these show a difference between the designs.

    difference      d = P(B succeeds) - P(A succeeds), observed (c - b) / n
    better, worse   McNemar's exact test of b against c, p adjusted by Holm over all comparisons, <= 1 - confidence
    PASS            with a margin: "d <= -margin" is rejected (exact unconditional test with Tango's score, one-sided)
    FAIL            with a margin: "d >= -margin" is rejected (the same test, p adjusted by Holm)
    PASS, FAIL      without a margin: better, worse

and UNDECIDED otherwise. The change passes only if all comparisons pass, so PASS needs no correction for their number; FAIL does,
because any of several can fail. Both tests are exact: they err with at most the stated probability, whatever the shares are. The
intervals of d are approximate. At 95 % confidence a pair of runs without a difference passes from the number of samples that an
all-success verdict needs (59, 299 and 2,995 at margins of 5, 1 and 0.1 %). A sample that is not finite is a failure, and has the
worst value of every metric.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from rvjax import stats
from rvjax.analysis import comparison_sentences as sentences
from rvjax.analysis.pairing import Paired, flat, folder_of, pair, value_text
from rvjax.analysis.run_totals import worst_first
from rvjax.analysis.verdicts.folders import campaign_of
from rvjax.analysis.verdicts.sentences import MANY, success_of
from rvjax.campaign import Requirement, Spec
from rvjax.campaign.plain_values import exact
from rvjax.columns import METRIC, OUTCOMES, Column, metric_column
from rvjax.components.samplers import sampling_design_of
from rvjax.components.settings import default
from rvjax.errors import UsageError
from rvjax.places import Place
from rvjax.run_folder import BASELINES, RunFolder
from rvjax.stats import Estimate, Pairs
from rvjax.stats.sampling_design import Independent

QUANTILES = (("settling_time_s", 0.95), ("delta_v_m_s", 0.5), ("window_position_error_m", 0.95))
"""Metrics and quantiles whose shifts are always shown."""

SEED = 20181
"""Seed of the bootstrap: the same folders always give the same intervals."""

Word = Literal["better", "worse", "no difference shown"]

_NOT_COMPARED = {"name", "description", "samples", "seed", "baselines", "require", "keep", "audit", "tune", "laws"}
"""Keys of a campaign that do not change the flight of a given sample, or that are compared separately."""


@dataclass(frozen=True, kw_only=True)
class Change:
    """How often samples succeed with A and with B.

    name: the success condition. pairs: `only_a` succeed with A alone, `only_b` with B alone. difference: B - A with Newcombe's
    two-sided interval; score: with Tango's interval, each end at the confidence. p_exact, p_mid: McNemar's test, two-sided;
    p_holm: p_exact, adjusted. log_e: logarithm of the e-value, which may be looked at after every sample. p_not_worse: p-value of
    "B is worse by the margin or more"; p_worse: adjusted p-value of "B is not worse by more than the margin"; both None without a
    margin. more: roughly how many further samples would decide, None if decided or if no number would. text: a sentence.
    """

    name: str
    pairs: Pairs
    share_a: float
    share_b: float
    difference: Estimate
    score: Estimate
    p_exact: float
    p_mid: float
    p_holm: float
    log_e: float
    p_not_worse: float | None
    p_worse: float | None
    word: Word
    verdict: Literal["PASS", "FAIL", "UNDECIDED"]
    more: int | None
    text: str


@dataclass(frozen=True)
class Shift:
    """The shift of the q-quantile of a metric, B - A, with its bootstrap interval (two-sided), in the unit of the metric.

    word: better or worse if the interval excludes 0, None if the metric has no better direction. It is approximate and not
    adjusted for several metrics; no verdict depends on it.
    """

    metric: str
    q: float
    unit: str
    a: float
    b: float
    shift: Estimate
    word: Word | None


@dataclass(frozen=True)
class Discordant:
    """A sample on which A and B differ. lost, won: comparisons in which A alone, B alone succeeds."""

    sample: int
    outcome_a: str
    outcome_b: str
    lost: tuple[str, ...]
    won: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """The comparison of two runs. a, b: the folders; n: pairs; differing: a line for each part in which the campaigns differ.

    only_a, only_b: draws that only A, only B has. discordant: the first of all `apart` samples on which A and B differ; samples
    that succeed with A alone come first, and each group begins with its worst sample.
    """

    a: Place
    b: Place
    n: int
    requested: tuple[int, int]
    confidence: float
    margin: float
    differing: tuple[str, ...]
    only_a: tuple[str, ...]
    only_b: tuple[str, ...]
    changes: tuple[Change, ...]
    shifts: tuple[Shift, ...]
    discordant: tuple[Discordant, ...]
    apart: int


def sides(folder: Path, other: Path | None = None, baseline: str | None = None) -> tuple[Path, Path]:
    """The folders A and B: two run folders, or a baseline of a run (A) and the run (B). UsageError otherwise."""
    if (other is None) == (baseline is None):
        raise UsageError("compare: give two run folders, A and B, or one folder and --baseline NAME")
    if other is not None:
        return folder, other
    baselines = sorted(path.name for path in (folder / BASELINES).glob("*") if path.is_dir())
    if baseline not in baselines:
        accepted = ", ".join(baselines) or "none, this run has no baselines"
        raise UsageError(f"{folder}: no baseline {baseline!r}; accepted: {accepted}")
    return folder / BASELINES / str(baseline), folder


def compare(
    a: str | Place,
    b: str | Place,
    *,
    margin: float = 0.0,
    confidence: float = 0.95,
    quantiles: Sequence[tuple[str, float]] = (),
    common: bool = False,
    shown: int = 10,
) -> Comparison:
    """Compares run B, the change, with run A, the reference, sample by sample.

    margin: how much smaller B's shares may be (0: no smaller). quantiles: further metrics and quantiles besides `QUANTILES`.
    common: compare folders of different size on the samples that both have. shown: how many discordant samples are listed.

    Errors: UsageError if a number is out of range, the samples are not independent draws, or the draws differ (it names the
    first columns); IncompleteError if samples are missing; FolderError if a folder is damaged.
    """
    _check(margin, confidence, quantiles)
    folders = folder_of(a), folder_of(b)
    specs = campaign_of(folders[0]), campaign_of(folders[1])
    for folder, spec in zip(folders, specs, strict=True):
        if not isinstance(design := sampling_design_of(spec), Independent):
            raise UsageError(f"{folder.path}: {design.sentence}; accepted: runs with sampler: {{use: monte-carlo}}")
    requirements = _successes(specs[0])
    wanted: dict[tuple[str, float], None] = {}

    def metrics(first: Mapping[str, Column], second: Mapping[str, Column]) -> list[str]:
        wanted.update(dict.fromkeys(_wanted(first, second, quantiles)))
        return list(dict.fromkeys(name for name, _ in wanted))

    paired = pair(*folders, requirements, metrics, common)
    names = [_name(requirement, paired.a.columns) for requirement in requirements]
    changes = _changes(names, paired, margin, confidence)
    discordant, apart = _discordant(names, paired, shown)
    return Comparison(
        a=folders[0].path,
        b=folders[1].path,
        n=paired.n,
        requested=(folders[0].requested, folders[1].requested),
        confidence=confidence,
        margin=margin,
        differing=(*_differing(*specs), *_code(*folders)),
        only_a=paired.only_a,
        only_b=paired.only_b,
        changes=changes,
        shifts=tuple(_shift(name, q, paired, confidence) for name, q in wanted),
        discordant=discordant,
        apart=apart,
    )


def _check(margin: float, confidence: float, quantiles: Sequence[tuple[str, float]]) -> None:
    if not 0 <= margin < 1:
        raise UsageError(f"margin {exact(margin)}; accepted: a share from 0 to below 1, as 0.01")
    if not 0.5 < confidence < 1:
        raise UsageError(f"confidence {exact(confidence)}; accepted: a number between 0.5 and 1, both excluded, as 0.95")
    for name, q in quantiles:
        if not 0 < q < 1:
            raise UsageError(f"quantile {exact(q)} of {name}; accepted: a number between 0 and 1, both excluded, as 0.95")


def _successes(spec: Spec) -> list[Requirement]:
    """The success conditions: captured, and each requirement on a share, without duplicates."""
    captured = Requirement(metric="captured", at_least=0.5)  # pyright: ignore[reportCallIssue]
    conditions = {success_of(requirement): requirement for requirement in (captured, *spec.require) if not requirement.mean}
    return list(conditions.values())


def _name(requirement: Requirement, columns: Mapping[str, Column]) -> str:
    places = (metric_column(f"{requirement.metric}{end}") for end in ("", f".{requirement.channel or 'any'}"))
    return success_of(requirement, next((columns[place].unit for place in places if place in columns), ""))


def _wanted(
    first: Mapping[str, Column], second: Mapping[str, Column], quantiles: Sequence[tuple[str, float]]
) -> list[tuple[str, float]]:
    """The quantiles to compare: the standard ones that both tables have, and the requested ones."""
    shared = [name.removeprefix(METRIC) for name in first if name.startswith(METRIC) and name in second]
    for name, _ in quantiles:
        if name not in shared:
            raise UsageError(f"metric {name!r} is not in both tables; accepted: {', '.join(shared)}")
    return [(name, q) for name, q in (*QUANTILES, *quantiles) if name in shared]


def _differing(a: Spec, b: Spec) -> tuple[str, ...]:
    """A line for each key in which the campaigns differ."""
    first, second = (dict(flat(spec.source.value, "")) for spec in (a, b))
    keys = [key for key in dict.fromkeys([*first, *second]) if key.split(".")[0] not in _NOT_COMPARED]
    lines: list[str] = []
    for key in keys:
        values = [given[key] if key in given else default(spec, key) for given, spec in ((first, a), (second, b))]
        if values[0] != values[1]:
            here, there = (value_text(value, key in given) for value, given in zip(values, (first, second), strict=True))
            lines.append(f"{key}: A has {here}, B has {there}")
    return tuple(lines)


def _code(a: RunFolder, b: RunFolder) -> tuple[str, ...]:
    """A line for each file and package of a user's components that the runs flew in different versions, and for rvjax itself."""
    first, second = (folder.identity.get("components", {}) for folder in (a, b))
    lines = [
        sentences.code(name, first.get(name), second.get(name))
        for name in sorted({*first, *second})
        if first.get(name) != second.get(name)
    ]
    own = [folder.identity.get("code") for folder in (a, b)]
    return (*lines, *([sentences.code("rvjax", *own)] if own[0] != own[1] else []))


# --- shares -----------------------------------------------------------------------------------------------------------


def _changes(names: Sequence[str], paired: Paired, margin: float, confidence: float) -> tuple[Change, ...]:
    pairs = [stats.pairs_of(a, b) for a, b in zip(paired.a.success, paired.b.success, strict=True)]
    exact = [float(stats.mcnemar(cells.only_a, cells.only_b)) for cells in pairs]
    adjusted = stats.holm(exact)
    worse = stats.holm([_p_worse(cells, margin) for cells in pairs]) if margin else adjusted
    numbers = zip(names, pairs, exact, adjusted.tolist(), worse.tolist(), strict=True)
    return tuple(
        _change(name, cells, margin, confidence, p_exact=p_exact, p_holm=p_holm, p_worse=p_worse)
        for name, cells, p_exact, p_holm, p_worse in numbers
    )


def _change(
    name: str, pairs: Pairs, margin: float, confidence: float, *, p_exact: float, p_holm: float, p_worse: float
) -> Change:
    swapped, p_not_worse = _swapped(pairs), _p_not_worse(pairs, margin) if margin else 1.0
    word: Word = "no difference shown"
    if p_holm <= 1 - confidence:
        word = "better" if pairs.only_b > pairs.only_a else "worse"
    if margin:
        verdict = "PASS" if p_not_worse <= 1 - confidence else "FAIL" if p_worse <= 1 - confidence else "UNDECIDED"
    else:
        verdict = {"better": "PASS", "worse": "FAIL"}.get(word, "UNDECIDED")
    score = stats.tango(swapped, 2 * confidence - 1)
    more = _more(pairs, margin, confidence) if verdict == "UNDECIDED" else None
    outlook = sentences.outlook(more) if verdict == "UNDECIDED" else ""
    return Change(
        name=name,
        pairs=pairs,
        share_a=(pairs.both + pairs.only_a) / pairs.n,
        share_b=(pairs.both + pairs.only_b) / pairs.n,
        difference=stats.newcombe(swapped, confidence),
        score=score,
        p_exact=p_exact,
        p_mid=float(stats.mcnemar(pairs.only_a, pairs.only_b, mid=True)),
        p_holm=p_holm,
        log_e=float(stats.log_e_paired(pairs.only_a, pairs.only_b)),
        p_not_worse=p_not_worse if margin else None,
        p_worse=p_worse if margin else None,
        word=word,
        verdict=verdict,  # pyright: ignore[reportArgumentType]
        more=more,
        text=f"{verdict}: {sentences.finding(verdict, score, margin, confidence)}{sentences.result(word, p_holm)}.{outlook}"
        + (sentences.HINT if verdict == "UNDECIDED" and not margin else ""),
    )


def _swapped(pairs: Pairs) -> Pairs:
    """The pairs with B first, so that a difference is B - A."""
    return Pairs(pairs.both, pairs.only_b, pairs.only_a, pairs.neither)


def _p_not_worse(pairs: Pairs, margin: float) -> float:
    """Exact p-value of "P(B succeeds) <= P(A succeeds) - margin"."""
    return stats.noninferiority_exact(_swapped(pairs), margin)


def _p_worse(pairs: Pairs, margin: float) -> float:
    """Exact p-value of "P(B succeeds) > P(A succeeds) - margin"."""
    return stats.inferiority_exact(_swapped(pairs), margin)


def _decides_roughly(pairs: Pairs, margin: float, risk: float) -> bool:
    """Whether the samples would decide, by the score test; if no sample succeeds with B alone, by the bound of P(only A)."""
    if not margin:
        return float(stats.mcnemar(pairs.only_a, pairs.only_b)) <= risk
    p = stats.noninferiority(_swapped(pairs), margin)
    if pairs.only_b:
        return min(p, 1.0 - p) <= risk
    within = stats.clopper_pearson_upper(pairs.only_a, pairs.n, 1.0 - risk) <= margin
    return within or (1.0 - p <= risk and stats.clopper_pearson_lower(pairs.only_a, pairs.n, 1.0 - risk) >= margin)


def _more(pairs: Pairs, margin: float, confidence: float) -> int | None:
    """Roughly how many further samples would decide if all shares stayed the same; None above `MANY`."""

    def decided(n: int) -> bool:
        return _decides_roughly(Pairs(*(round(cell * n / pairs.n) for cell in pairs)), margin, 1 - confidence)

    low, high = pairs.n, 2 * pairs.n
    while not decided(high):
        low, high = high, 2 * high
        if high > MANY:
            return None
    while high - low > max(1, high // 1000):
        middle = (low + high) // 2
        low, high = (low, middle) if decided(middle) else (middle, high)
    return high - pairs.n


# --- quantiles and single samples ----------------------------------------------------------------------------------


def _shift(name: str, q: float, paired: Paired, confidence: float) -> Shift:
    a, b = paired.a.values[name], paired.b.values[name]
    column = paired.a.columns[metric_column(name)]
    shift = stats.quantile_shift(a, b, q, confidence, rng=np.random.Generator(np.random.Philox(key=SEED)))
    rank = stats.quantile_rank(paired.n, q)
    before, after = (float(np.partition(values, rank)[rank]) for values in (a, b))
    word: Word | None = None
    if column.better and (shift.low > 0 or shift.high < 0):
        word = "better" if (shift.low > 0) == (column.better == "higher") else "worse"
    elif column.better:
        word = "no difference shown"
    return Shift(metric=name, q=q, unit=column.unit, a=before, b=after, shift=shift, word=word)


def _discordant(names: Sequence[str], paired: Paired, shown: int) -> tuple[tuple[Discordant, ...], int]:
    """The first samples on which A and B differ, and how many there are."""
    both = list(zip(names, paired.a.success, paired.b.success, strict=True))
    lost = np.any([a & ~b for _, a, b in both], axis=0)
    won = np.any([b & ~a for _, a, b in both], axis=0)
    order: list[int] = []
    for chosen, side in ((lost, paired.b), (won & ~lost, paired.a)):
        samples = np.flatnonzero(chosen)
        order += samples[worst_first(side.rows(samples), side.columns)].tolist()
    listed = tuple(
        Discordant(
            sample=sample,
            outcome_a=OUTCOMES[paired.a.outcome[sample]],
            outcome_b=OUTCOMES[paired.b.outcome[sample]],
            lost=tuple(name for name, a, b in both if a[sample] and not b[sample]),
            won=tuple(name for name, a, b in both if b[sample] and not a[sample]),
        )
        for sample in order[:shown]
    )
    return listed, len(order)
