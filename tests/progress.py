"""Progress of a run, kept for tests."""

from __future__ import annotations

from collections.abc import Callable

from rvjax.execution.progress import Progress


def append_flown(flown: list[int]) -> Callable[[Progress], None]:
    """Appends the number of flights that have ended at each report of the flights; kept traces do not count."""

    def append(progress: Progress) -> None:
        if progress.phase == "flights":
            flown.append(progress.done)

    return append
