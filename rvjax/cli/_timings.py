"""The table of `--timings`: where the time of a command went."""

from __future__ import annotations

import sys

from rvjax.cli._output import Output, say
from rvjax.cli._tables import drawn
from rvjax.timings import timings


def show_timings(output: Output) -> None:
    """Prints the seconds of every phase to stderr: of the main thread, and of all other threads together."""
    if output.quiet:
        return
    measured = timings()
    names = dict.fromkeys((*measured.main, *measured.threads))
    rows = [
        (name, f"{measured.main.get(name, 0.0):.2f} s", f"{measured.threads[name]:.2f} s" if name in measured.threads else "")
        for name in sorted(names, key=lambda name: -measured.main.get(name, 0.0))
    ]
    rows += [("other", f"{measured.other:.2f} s", ""), ("total", f"{measured.total:.2f} s", "")]
    say(drawn(("phase", "main thread", "other threads"), rows, sys.stderr), sys.stderr)
