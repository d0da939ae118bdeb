"""What `rvjax reweigh --slopes` shows."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rvjax.cli._output import Output
    from rvjax.execution.slopes import Row, Slopes
    from rvjax.places import Place

SECANT = "¹"


def show_slopes(folder: Place, confidence: float, shown: int, output: Output) -> None:
    """Prints a table for each requirement, the parameters that matter most first."""
    from rvjax.execution.slopes import slopes

    found = slopes(folder, confidence)
    for table in found.tables:
        _show(table, confidence, shown, output)
    output.text(
        "slope: of the probability per unit (SI) of the parameter; change: in percentage points, where the parameter grows by "
        "1 % of the standard deviation of the draw (places) or of itself (sizes)",
        f"{SECANT} secant to an end that cuts off the outermost 10 % of the law, exact bounds; others: score function, nominal",
    )
    for name, why in found.left_out.items():
        output.text(f"not shown: {name}: {why}")
    output.document(
        {
            "folder": str(folder),
            "samples": found.n,
            "confidence": confidence,
            "tables": [
                {
                    "name": table.name,
                    "failing": asdict(table.failing),
                    "rows": [
                        {
                            "draw": row.draw,
                            "parameter": row.slope.parameter,
                            "value": row.slope.value,
                            "step": row.slope.step,
                            "change": row.change,
                            "why_not": row.slope.why or None,
                            "slope": None if row.slope.estimate is None else asdict(row.slope.estimate),
                        }
                        for row in table.rows
                    ],
                }
                for table in found.tables
            ],
            "left_out": found.left_out,
        }
    )


def _show(table: Slopes, confidence: float, shown: int, output: Output) -> None:
    share = table.failing
    failing = f"{100 * share.value:.2f} % [{100 * share.low:.2f}, {100 * share.high:.2f}]"
    clear = sum(row.is_clear for row in table.rows)
    together = f"at {100 * confidence:g} % confidence for all together"
    output.text(f"{table.name}: {failing}; {clear} of {len(table.rows)} slopes are clearly not 0 {together}")
    rows = [_row(row) for row in table.rows[:shown]]
    output.table(("parameter", "value", "slope", "change, points"), rows)
    for row in table.rows:
        if row.slope.estimate is None:
            output.text(f"no slope over {row.draw}, {row.slope.parameter}: {row.slope.why}")


def _row(row: Row) -> tuple[str, ...]:
    estimate = row.slope.estimate
    text, mark = "–", ""
    if estimate is not None:
        text = f"{estimate.value:+.3g} [{estimate.low:+.3g}, {estimate.high:+.3g}]"
        mark = SECANT if estimate.method.startswith("secant") else ""
    numbers = (f"{row.slope.value:.4g}", text, f"{100 * row.change:+.3f}")
    return f"{row.draw}: {row.slope.parameter}{mark}", *(number.replace("-", "−") for number in numbers)
