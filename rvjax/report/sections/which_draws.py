"""Section: which draws matter: tests that see every form of dependence, and the share of failures by class of a draw."""

from __future__ import annotations

from rvjax.analysis import drivers
from rvjax.analysis.comparison_sentences import p_value
from rvjax.analysis.drivers import Driver, Drivers, Result
from rvjax.columns import draw_column
from rvjax.report.blocks import Cell, Code, Number, Section, Table
from rvjax.report.number_format import capital, label, number, percent, quantity
from rvjax.report.run_view import CONFIDENCE, Run
from rvjax.stats import Estimate
from rvjax.stats.sampling_design import Exploration

_RESULTS = ("settling_time_s", "window_position_error_m")
_SHOWN = 8
_IN_CLASSES = 3
_TITLE = "Which draws matter"


def section(run: Run) -> Section | None:
    """ξ, its p-value and the first-order index of the draws with failures, settling time and window position error, and
    P(failure | class of the draw) of those that matter most."""
    drawn = drivers.varied(run.head) if len(run.head) >= drivers.FEWEST else {}
    results = [
        *drivers.failures(run.head, ())[:1],
        *drivers.metrics(run.head, run.totals.columns, [name for name in _RESULTS if run.metrics(name)]),
    ]
    if not drawn or isinstance(run.design, Exploration):
        return None
    found = drivers.drivers(drawn, results, run.design, CONFIDENCE)
    if not found.pairs:
        return None
    tables = [table for result in results if (table := _table(run, found, result)) is not None]
    classes = _classes(run, found, results[0], drawn)
    clear = {pair.draw for result in results for pair in found.clear(result.name)}
    first = found.pairs[0]
    leading = f"; {first.draw} the most clearly, for the {_words(first.result)}" if clear else ""
    lead = f"{len(clear)} of {len(drawn)} draws, lengths of vectors included, clearly matter for a result{leading}."
    return Section("which-draws", _TITLE, lead, (*tables, *classes))


def _words(name: str) -> str:
    return "outcome" if name == drivers.NOT_CAPTURED else label(name)


def _table(run: Run, found: Drivers, result: Result) -> Table | None:
    rows = found.clear(result.name)[:_SHOWN]
    if not rows:
        return None
    caption = (
        f"{capital(_words(result.name))}: draws that matter, the clearest first. ξ (Chatterjee): about 0 if the result does not "
        "depend on the draw, 1 if the draw decides it, whatever the form. p: probability of such a ξ by chance, corrected for "
        f"all {len(found.pairs)} pairs (Holm). S: share of the variance that the draw explains by itself, approximate. "
        f"{run.lost} has the worst rank, and is left out of S.{run.head_note} All metrics: `rvjax drivers`."
    )
    return Table(caption, ("draw", "ξ", "p, Holm", "S"), tuple(_row(pair) for pair in rows))


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
