"""The benchmark of opening and going on with a large run folder runs; what it measures, a machine's owner reads."""

from __future__ import annotations

from collections.abc import Callable

from benchmarks.scan import measure


def test_the_benchmark_runs(figure: Callable[[str], None]) -> None:
    """Kills: a benchmark of a folder that cannot be resumed."""
    found = measure(200)
    assert set(found) == {"open, ended", "resume, ended", "open, killed", "resume, killed"}
    figure("scan of 200 chunks: " + "; ".join(f"{what} {seconds * 1e3:.0f} ms" for what, (seconds, *_) in found.items()))
