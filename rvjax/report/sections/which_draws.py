"""Section: which draws matter: tests that see every form of dependence, rank correlations that show which way, and the share of
failures by class of a draw."""

from __future__ import annotations

from rvjax.analysis import drivers
from rvjax.analysis.comparison_sentences import p_value
from rvjax.analysis.drivers import Driver, Drivers, Result
from rvjax.columns import draw_column
from rvjax.report.blocks import Cell, Code, Number, Section, Table
from rvjax.report.number_format import capital, label, number, percent, quantity
from rvjax.report.rank_correlations import Correlations, correlations, explained, figure, is_clear, strongest
from rvjax.report.run_view import CONFIDENCE, Run
from rvjax.stats import Estimate
from rvjax.stats.sampling_design import Exploration

_RESULTS = ("settling_time_s", "window_position_error_m")
_SHOWN = 8
_IN_FIGURE = 12
_IN_CLASSES = 3
_TITLE = "Which draws matter"


def section(run: Run) -> Section | None:
    """ξ with its p-value, the first-order index and the rank correlation of the draws with failures, settling time and window
    position error, and P(failure | class of the draw) of those that matter most. Of an exploration, rank correlations only."""
    drawn = drivers.varied(run.head) if len(run.head) >= drivers.FEWEST else {}
    names = [name for name in _RESULTS if run.metrics(name)]
    if not drawn or not names:
        return None
    known = correlations(run, drawn, names)
    if isinstance(run.design, Exploration):
        return _explored(run, known, list(drawn))
    results = [*drivers.failures(run.head, ())[:1], *drivers.metrics(run.head, run.totals.columns, names)]
    found = drivers.drivers(drawn, results, run.design, CONFIDENCE)
    if not found.pairs:
        return None
    tables = [table for result in results if (table := _table(run, found, result, known)) is not None]
    classes = _classes(run, found, results[0], drawn)
    clear = {pair.draw for result in results for pair in _clear(found, result.name, known)}
    first = found.pairs[0]
    leading = f"; {first.draw} the most clearly, for the {_words(first.result)}" if clear else ""
    lead = f"{len(clear)} of {len(drawn)} draws, lengths of vectors included, clearly matter for a result{leading}."
    drawings = (figure(run, known, strongest(known, list(clear))[:_IN_FIGURE]),) if clear else ()
    return Section("which-draws", _TITLE, lead, (*drawings, *tables, *classes))


def _explored(run: Run, known: Correlations, draws: list[str]) -> Section:
    """The strongest rank correlations of samples that are not independent."""
    leading = strongest(known, draws)[:_IN_FIGURE]
    caption = f"The {len(leading)} strongest. {explained(run, len(draws) * len(known))}{run.head_note}"
    rows = tuple((Code(path), *(_correlation(known, name, path) for name in known)) for path in leading)
    lead = f"{leading[0]} has the strongest rank correlation with a result, of {len(draws)} draws."
    table = Table(caption, ("draw", *(label(name) for name in known)), rows)
    return Section("which-draws", _TITLE, lead, (figure(run, known, leading), table))


def _clear(found: Drivers, result: str, known: Correlations) -> list[Driver]:
    """The draws that matter by ξ or by their rank correlation, the clearest by ξ first."""
    clear, of = {pair.draw for pair in found.clear(result)}, known.get(result, {})
    return [pair for pair in found.of(result) if pair.draw in clear or (pair.draw in of and is_clear(of[pair.draw]))]


def _correlation(known: Correlations, result: str, draw: str) -> Cell:
    return Number(f"correlation.{result}.{draw}", known[result][draw])


def _words(name: str) -> str:
    return "outcome" if name == drivers.NOT_CAPTURED else label(name)


def _table(run: Run, found: Drivers, result: Result, known: Correlations) -> Table | None:
    rows, correlated = _clear(found, result.name, known)[:_SHOWN], result.name in known
    if not rows:
        return None
    pairs = len(found.draws) * len(known)
    caption = (
        f"{capital(_words(result.name))}: draws that matter, the clearest first. ξ (Chatterjee): about 0 if the result does not "
        "depend on the draw, 1 if the draw decides it, whatever the form. p: probability of such a ξ by chance, corrected for "
        f"all {len(found.pairs)} pairs (Holm). S: share of the variance that the draw explains by itself, approximate. "
        f"{f'{explained(run, pairs)} ' if correlated else ''}"
        f"{run.lost} has the worst rank, and is left out of S.{run.head_note} All metrics: `rvjax drivers`."
    )
    head = ("draw", "ξ", "p, Holm", "S", *(("rank correlation",) if correlated else ()))
    cells = ((*_row(pair), *((_correlation(known, result.name, pair.draw),) if correlated else ())) for pair in rows)
    return Table(caption, head, tuple(cells))


def _row(pair: Driver) -> tuple[Cell, ...]:
    key = f"which-draws.{pair.result.replace(' ', '_')}.{pair.draw}"
    share: Cell = "–" if pair.share is None else Number(f"{key}.share", pair.share)
    p = "–" if pair.p_holm is None else p_value(pair.p_holm)
    return Code(pair.draw), number(pair.xi), p, share


def _classes(run: Run, found: Drivers, result: Result, drawn: dict[str, drivers.Values]) -> list[Table]:
    """The share of flights that are not captured, in classes of the draws that matter most for it."""
    tables: list[Table] = []
    for pair in found.clear(result.name)[:_IN_CLASSES]:
        column = run.totals.columns.get(draw_column(pair.draw.strip("|"))) or run.totals.columns.get(
            draw_column(pair.draw.strip("|") + ".x")
        )
        unit = column.unit if column is not None else ""
        parts = drivers.failing_classes(drawn[pair.draw], result.values, run.design, CONFIDENCE)
        rows = tuple(
            (
                f"{quantity(part.low, unit)} … {quantity(part.high, unit)}",
                f"{part.share.n:,}",
                Number(f"not_captured.{pair.draw}.class{place}", _of_all(part.share), percent=True),
            )
            for place, part in enumerate(parts, 1)
        )
        caption = (
            f"Not captured, by class of {pair.draw}. Classes of equal size; intervals at {percent(CONFIDENCE)} confidence for "
            f"all classes of the table together (Clopper-Pearson).{run.head_note}"
        )
        tables.append(Table(caption, ("draw", "flights", "not captured"), rows))
    return tables


def _of_all(share: Estimate) -> Estimate:
    """The estimate with the confidence of all classes together."""
    return Estimate(share.value, share.low, share.high, share.n, CONFIDENCE, "Clopper-Pearson, simultaneous")
