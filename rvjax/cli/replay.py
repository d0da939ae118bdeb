"""`rvjax replay`: a single flight again, with its trace."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rvjax.cli import _completion
from rvjax.cli._app import Folder, Json
from rvjax.cli._output import Output
from rvjax.columns import METRIC


def command(
    folder: Folder,
    *,
    sample: Annotated[int, typer.Option("--sample", min=0, help="Number of the sample.", autocompletion=_completion.samples)],
    out: Annotated[Path | None, typer.Option("--out", metavar="F", help="Trace file, .parquet or .csv.")] = None,
    every: Annotated[int, typer.Option("--every", min=1, metavar="N", help="Keep every N-th step.")] = 1,
    as_json: Json = False,
) -> int:
    """Fly a sample of a run again, with its full trace."""
    from rvjax.execution.replay import replay, save, trace_file
    from rvjax.run_folder import atomic_files

    output = Output(as_json)
    target = trace_file(out or Path(f"sample-{sample:07d}.parquet"))
    atomic_files.check_file(target)
    trace, columns, row = replay(folder, sample, every)
    save(target, trace, columns)
    metrics = {name.removeprefix(METRIC): value for name, value in row.items() if name.startswith(METRIC)}
    output.text(f"sample {sample}: {row['outcome']} at {row['outcome_time_s']:.6g} s; {len(trace)} rows in {target}")
    output.table(("metric", "value"), [(name, f"{value:.6g}") for name, value in metrics.items()])
    output.document({"sample": sample, "outcome": row["outcome"], "trace": str(target), "rows": len(trace), "metrics": metrics})
    return 0
