"""The program in this process, as the fixture `rvjax` runs it."""

from __future__ import annotations

from collections.abc import Callable

Run = Callable[..., tuple[int, str, str]]
"""Of the arguments: exit code, stdout, stderr."""
