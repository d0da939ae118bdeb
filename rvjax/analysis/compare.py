"""Two designs flown on the same draws: A, the reference, and B, the change.

Of n pairs of samples, b succeed with A alone and c with B alone; only these tell the designs apart.

    difference      d = P(B succeeds) - P(A succeeds), observed (c - b) / n
    better, worse   McNemar's exact test of b against c, p adjusted by Holm over all comparisons, <= 1 - confidence
    PASS            with a margin: "d <= -margin" is rejected (Tango's score test, one-sided)
    FAIL            with a margin: "d >= -margin" is rejected (the same test, p adjusted by Holm)
    PASS, FAIL      without a margin: better, worse

and UNDECIDED otherwise. All comparisons pass wrongly with the probability that one of them does, so PASS needs no correction; to
say which of several fail does. McNemar's test is exact. The score test is approximate; where no sample succeeds with B alone,
PASS also takes the exact bound of P(only A succeeds) <= margin, and FAIL that of >= margin. So "no difference seen" passes from
the number of samples on that an all-success verdict takes. A sample that is not finite is a failure, and has the worst value of
every metric.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from scipy import special  # pyright: ignore[reportMissingTypeStubs]

from rvjax import stats
from rvjax.analysis.pairing import Paired, flat, folder_of, pair, said
from rvjax.analysis.run_totals import worst_first
from rvjax.analysis.verdicts.folders import campaign_of
from rvjax.analysis.verdicts.sentences import MANY, success_of
from rvjax.campaign import Requirement, Spec
from rvjax.columns import METRIC, Column, metric_column
from rvjax.components.samplers import sampling_design_of
from rvjax.errors import UsageError
from rvjax.run_folder import BASELINES, OUTCOMES
from rvjax.stats import Estimate, Pairs
from rvjax.stats.sampling_design import Independent

QUANTILES = (("settling_time_s", 0.95), ("delta_v_m_s", 0.5), ("window_position_error_m", 0.95))
"""Metrics whose shifts are shown without being asked for."""

SEED = 20181
"""Of the bootstrap: the same folders always give the same intervals."""

Word = Literal["better", "worse", "no difference shown"]

_ASIDE = {"name", "description", "samples", "seed", "baselines", "require", "keep", "audit", "tune"}
"""Parts of a campaign that no flight of a given sample depends on, or that are compared by themselves."""


@dataclass(frozen=True)
class Change:
    """How often samples succeed with A and with B.

    name: what a success is. pairs: `only_a` succeed with A alone, `only_b` with B alone. difference: B - A with Newcombe's
    two-sided interval; score: with Tango's, whose ends each hold at the confidence. p_exact, p_mid: McNemar's, two-sided; p_holm:
    the exact one, adjusted. log_e: logarithm of the e-value, which one may look at after every sample. p_not_worse: of "worse by
    the margin or more"; p_worse: of "not worse than by the margin", adjusted; both None without a margin. more: roughly how many
    further samples would decide, None where it is decided or no number would. text: one sentence.
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
    """How far the q-quantile of a metric moves, B - A, with its bootstrap interval (two-sided); unit of the metric.

    word: better or worse where the interval leaves 0 out, by itself and approximately; no verdict depends on it.
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
    """A sample that tells A and B apart. lost, won: comparisons in which A alone, B alone succeeds."""

    sample: int
    outcome_a: str
    outcome_b: str
    lost: tuple[str, ...]
    won: tuple[str, ...]


@dataclass(frozen=True)
class Comparison:
    """What B changes. a, b: the folders; n: pairs; differing: parts of the campaigns that differ, one line each.

    only_a, only_b: draws that one side alone has. discordant: the first of all `apart` samples that tell them apart, those that A
    alone wins in front, each group from the worst one on.
    """

    a: Path
    b: Path
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
    """The folders A and B: two that are given, or a baseline of a run (A) and the run (B). UsageError otherwise."""
    if (other is None) == (baseline is None):
        raise UsageError("compare: give two run folders, A and B, or one folder and --baseline NAME")
    if other is not None:
        return folder, other
    there = sorted(path.name for path in (folder / BASELINES).glob("*") if path.is_dir())
    if baseline not in there:
        accepted = ", ".join(there) or "none, this run has no baselines"
        raise UsageError(f"{folder}: no baseline {baseline!r}; accepted: {accepted}")
    return folder / BASELINES / str(baseline), folder


def compare(
    a: str | Path,
    b: str | Path,
    *,
    margin: float = 0.0,
    confidence: float = 0.95,
    quantiles: Sequence[tuple[str, float]] = (),
    common: bool = False,
    shown: int = 10,
) -> Comparison:
    """Compares run B, the change, with run A, the reference, sample by sample.

    margin: how much smaller B's shares may be (0: no smaller). quantiles: metrics and quantiles beside `QUANTILES`. common:
    folders of different size are compared in the samples that both have. shown: how many discordant samples are listed.

    Errors: UsageError where a number is none of those accepted, samples are no independent draws, or draws differ, naming the
    first columns that do; IncompleteError where samples are missing; FolderError where a folder is damaged.
    """
    _check(margin, confidence, quantiles)
    folders = folder_of(Path(a)), folder_of(Path(b))
    specs = campaign_of(folders[0]), campaign_of(folders[1])
    for folder, spec in zip(folders, specs, strict=True):
        if not isinstance(basis := sampling_design_of(spec), Independent):
            raise UsageError(f"{folder.path}: {basis.sentence}; accepted: runs with sampler: {{use: monte-carlo}}")
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
        folders[0].path,
        folders[1].path,
        paired.n,
        (folders[0].requested, folders[1].requested),
        confidence,
        margin,
        _differing(*specs),
        paired.only_a,
        paired.only_b,
        changes,
        tuple(_shift(name, q, paired, confidence) for name, q in wanted),
        discordant,
        apart,
    )


def _check(margin: float, confidence: float, quantiles: Sequence[tuple[str, float]]) -> None:
    if not 0 <= margin < 1:
        raise UsageError(f"margin {margin:g}; accepted: a share from 0 to below 1, as 0.01")
    if not 0.5 < confidence < 1:
        raise UsageError(f"confidence {confidence:g}; accepted: a number between 0.5 and 1, both excluded, as 0.95")
    for name, q in quantiles:
        if not 0 < q < 1:
            raise UsageError(f"quantile {q:g} of {name}; accepted: a number between 0 and 1, both excluded, as 0.95")


def _successes(spec: Spec) -> list[Requirement]:
    """What a sample may succeed in: to be captured, and each requirement on a share, those that mean the same once."""
    captured = Requirement(metric="captured", at_least=0.5)  # pyright: ignore[reportCallIssue]
    kinds = {success_of(one): one for one in (captured, *spec.require) if not one.mean}
    return list(kinds.values())


def _name(requirement: Requirement, columns: Mapping[str, Column]) -> str:
    places = (metric_column(f"{requirement.metric}{end}") for end in ("", f".{requirement.channel or 'any'}"))
    return success_of(requirement, next((columns[place].unit for place in places if place in columns), ""))


def _wanted(
    first: Mapping[str, Column], second: Mapping[str, Column], quantiles: Sequence[tuple[str, float]]
) -> list[tuple[str, float]]:
    """The quantiles to compare: the usual ones that both tables have, and those asked for."""
    there = [name.removeprefix(METRIC) for name in first if name.startswith(METRIC) and name in second]
    for name, _ in quantiles:
        if name not in there:
            raise UsageError(f"metric {name!r} is not in both tables; accepted: {', '.join(there)}")
    return [(name, q) for name, q in (*QUANTILES, *quantiles) if name in there]


def _differing(a: Spec, b: Spec) -> tuple[str, ...]:
    """What the campaigns say differently, one line each."""
    first, second = (dict(flat(spec.source.value, "")) for spec in (a, b))
    keys = [key for key in dict.fromkeys([*first, *second]) if first.get(key) != second.get(key)]
    shown = [key for key in keys if key.split(".")[0] not in _ASIDE]
    return tuple(f"{key}: A has {said(first, key)}, B has {said(second, key)}" for key in shown)


# --- shares -----------------------------------------------------------------------------------------------------------


def _changes(names: Sequence[str], paired: Paired, margin: float, confidence: float) -> tuple[Change, ...]:
    pairs = [stats.pairs_of(a, b) for a, b in zip(paired.a.success, paired.b.success, strict=True)]
    exact = [float(stats.mcnemar(one.only_a, one.only_b)) for one in pairs]
    adjusted = stats.holm(exact)
    worse = stats.holm([_p_worse(one, margin) for one in pairs]) if margin else adjusted
    numbers = zip(names, pairs, exact, adjusted.tolist(), worse.tolist(), strict=True)
    return tuple(_change(*each, margin, confidence) for each in numbers)


def _change(name: str, pairs: Pairs, exact: float, adjusted: float, worse: float, margin: float, confidence: float) -> Change:
    turned = _turned(pairs)
    word: Word = "no difference shown"
    if adjusted <= 1 - confidence:
        word = "better" if pairs.only_b > pairs.only_a else "worse"
    if margin:
        verdict = "PASS" if _not_worse(pairs, margin, confidence) else "FAIL" if worse <= 1 - confidence else "UNDECIDED"
    else:
        verdict = {"better": "PASS", "worse": "FAIL"}.get(word, "UNDECIDED")
    score = stats.tango(turned, 2 * confidence - 1)
    more = _more(pairs, margin, confidence) if verdict == "UNDECIDED" else None
    return Change(
        name,
        pairs,
        (pairs.both + pairs.only_a) / pairs.n,
        (pairs.both + pairs.only_b) / pairs.n,
        stats.newcombe(turned, confidence),
        score,
        exact,
        float(stats.mcnemar(pairs.only_a, pairs.only_b, mid=True)),
        adjusted,
        float(stats.log_e_paired(pairs.only_a, pairs.only_b)),
        _p_not_worse(pairs, margin) if margin else None,
        worse if margin else None,
        word,
        verdict,  # pyright: ignore[reportArgumentType]
        more,
        _sentence(verdict, word, adjusted, score, margin, confidence, more),
    )


def _turned(pairs: Pairs) -> Pairs:
    """B in the first place, so that a difference is B - A."""
    return Pairs(pairs.both, pairs.only_b, pairs.only_a, pairs.neither)


def _p_not_worse(pairs: Pairs, margin: float) -> float:
    """p-value of "P(B succeeds) <= P(A succeeds) - margin"."""
    return stats.noninferiority(_turned(pairs), margin)


def _p_worse(pairs: Pairs, margin: float) -> float:
    """p-value of "P(B succeeds) > P(A succeeds) - margin"; where no sample succeeds with B alone at least the exact one of
    "P(only A succeeds) <= margin", P(X >= only A) with X ~ Bin(n, margin)."""
    p = 1.0 - _p_not_worse(pairs, margin)
    if pairs.only_b or not pairs.only_a:
        return p
    return max(p, float(special.betainc(pairs.only_a, pairs.n - pairs.only_a + 1, margin)))


def _not_worse(pairs: Pairs, margin: float, confidence: float) -> bool:
    """Whether B is shown not to be worse by more than the margin."""
    if not pairs.only_b and stats.clopper_pearson_upper(pairs.only_a, pairs.n, confidence) > margin:
        return False
    return _p_not_worse(pairs, margin) <= 1 - confidence


def _more(pairs: Pairs, margin: float, confidence: float) -> int | None:
    """Roughly how many samples more would decide if all shares stayed as they are; None above `MANY`."""

    def decided(n: int) -> bool:
        grown = Pairs(*(round(cell * n / pairs.n) for cell in pairs))
        if not margin:
            return float(stats.mcnemar(grown.only_a, grown.only_b)) <= 1 - confidence
        return _not_worse(grown, margin, confidence) or _p_worse(grown, margin) <= 1 - confidence

    low, high = pairs.n, 2 * pairs.n
    while not decided(high):
        low, high = high, 2 * high
        if high > MANY:
            return None
    while high - low > max(1, high // 1000):
        middle = (low + high) // 2
        low, high = (low, middle) if decided(middle) else (middle, high)
    return high - pairs.n


def _sentence(verdict: str, word: Word, p: float, score: Estimate, margin: float, confidence: float, more: int | None) -> str:
    sure = f"with {100 * confidence:.6g} % confidence"
    told = f"{word} (p {_equals(p)})" if word == "no difference shown" else f"significantly {word} (p {_equals(p)})"
    outlook = "" if verdict != "UNDECIDED" else " No number of samples would decide if the shares stayed the same."
    if more is not None:
        outlook = f" About {more:,} more samples would decide if the shares stayed the same."
    if not margin:
        hint = " --margin says how much worse would do." if verdict == "UNDECIDED" else ""
        return f"{verdict}: {told}.{outlook}{hint}"
    most = f"{100 * margin:.6g} %"
    low, high = (f"{100 * end:+.3g} %".replace("-", "−") for end in (score.low, score.high))
    said = {
        "PASS": f"not worse by more than {most}: the difference is at least {low}",
        "FAIL": f"worse by more than {most}: the difference is at most {high}",
        "UNDECIDED": f"not shown to be worse by more than {most}, or not to be: the difference is from {low} to {high}, each end",
    }[verdict]
    return f"{verdict}: {said} {sure}; {told}.{outlook}"


def p_value(p: float) -> str:
    """Two digits; what underflows is said to be small."""
    return f"{p:.2g}" if p >= 1e-300 else "<1e-300"


def _equals(p: float) -> str:
    return f"= {p_value(p)}" if p >= 1e-300 else "< 1e-300"


# --- quantiles and single samples ----------------------------------------------------------------------------------


def _shift(name: str, q: float, paired: Paired, confidence: float) -> Shift:
    a, b = paired.a.values[name], paired.b.values[name]
    column = paired.a.columns[metric_column(name)]
    shift = stats.quantile_shift(a, b, q, confidence, rng=np.random.Generator(np.random.Philox(key=SEED)))
    rank = stats.quantile_rank(paired.n, q)
    before, after = (float(np.partition(side, rank)[rank]) for side in (a, b))
    word: Word | None = None
    if column.better and (shift.low > 0 or shift.high < 0):
        word = "better" if (shift.low > 0) == (column.better == "higher") else "worse"
    elif column.better:
        word = "no difference shown"
    return Shift(name, q, column.unit, before, after, shift, word)


def _discordant(names: Sequence[str], paired: Paired, shown: int) -> tuple[tuple[Discordant, ...], int]:
    """The first samples that tell A from B, and how many there are."""
    both = list(zip(names, paired.a.success, paired.b.success, strict=True))
    lost = np.any([a & ~b for _, a, b in both], axis=0)
    won = np.any([b & ~a for _, a, b in both], axis=0)
    order: list[int] = []
    for chosen, side in ((lost, paired.b), (won & ~lost, paired.a)):
        samples = np.flatnonzero(chosen)
        order += samples[worst_first(side.rows(samples), side.columns)].tolist()
    listed = tuple(
        Discordant(
            sample,
            OUTCOMES[paired.a.outcome[sample]],
            OUTCOMES[paired.b.outcome[sample]],
            tuple(name for name, a, b in both if a[sample] and not b[sample]),
            tuple(name for name, a, b in both if b[sample] and not a[sample]),
        )
        for sample in order[:shown]
    )
    return listed, len(order)
