"""What a stopped command prints: what is kept, and the command that resumes it."""

from __future__ import annotations

import shlex
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from rvjax.cli._app import Terminated
from rvjax.cli._output import Output, say
from rvjax.errors import IncompleteError
from rvjax.places import Place


@contextmanager
def resumable(output: Output, out: Place | None) -> Iterator[Callable[[Place], None]]:
    """Prints the time of what runs inside, or where it is stopped the command that resumes it. Gives the function to call with
    the run folder. out: the folder that the command line names."""
    started = time.monotonic()
    folders: list[Place] = []
    try:
        yield folders.append
    except (KeyboardInterrupt, Terminated, IncompleteError) as error:
        if folders:
            command = resuming(sys.argv[1:], None if out is not None else folders[0])
            say(f"stopped; what was flown is kept in {folders[0]}. Resume with\n  {shlex.join(command)}", sys.stderr)
            if isinstance(error, IncompleteError):
                error.stopped, error.go_on_with = str(folders[0]), command
            else:
                output.document({"stopped": str(folders[0]), "go_on_with": command})
        raise
    output.note(f"done in {time.monotonic() - started:.0f} s")


def resuming(arguments: Sequence[str], folder: Place | None) -> list[str]:
    """The command with every option of `arguments`. folder: to add as --out."""
    words = ["rvjax", *arguments]
    if folder is not None:
        end = words.index("--") if "--" in words else len(words)
        words[end:end] = ["--out", str(folder)]
    return words
