"""What can go wrong for a user: `str(error)` is the message, `exit_code` what the program returns."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import ClassVar

_UNSEEN = re.compile("[\0-\t\v-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ufeff\ud800-\udfff]")


_BLANK = re.compile("[\u200b]|(?=[^\x20\n])\\s")
"""Characters that look like a space, or like nothing."""


def _spelt(character: str) -> str:
    return character.encode("unicode_escape").decode()


def visible(text: str, spell: Callable[[str], str] = _spelt) -> str:
    """The text with what acts on a terminal instead of being seen (escape sequences, turned directions) spelt out.

    Line ends stay. spell: how one such character is spelt, `\\x1b` if nothing is said.
    """
    return _UNSEEN.sub(lambda found: spell(found[0]), text)


class RvjaxError(Exception):
    """A mistake or a condition that the user can act on; never shown with a traceback."""

    exit_code: ClassVar[int] = 2


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong at one place, one line: `file:line:column: path: found; accepted`.

    where: `file:line:column`, or the argument `--set path=value` that brought it; path: empty for the whole file.
    """

    where: str
    path: str
    found: str
    accepted: str = ""

    def __str__(self) -> str:
        place = f"{self.where}: {self.path}" if self.path else self.where
        said = f"{place}: {self.found}; {self.accepted}" if self.accepted else f"{place}: {self.found}"
        return _BLANK.sub(lambda blank: _spelt(blank[0]), visible(said)).replace("\n", "\\n")

    @property
    def order(self) -> tuple[float, float]:
        """(line, column); arguments of the command come after the file."""
        position = re.search(r":(\d+):(\d+)$", self.where)
        return (float(position[1]), float(position[2])) if position else (float("inf"), 0.0)


class CampaignError(RvjaxError):
    """Everything that is wrong with a campaign, one line per finding, in file order."""

    exit_code: ClassVar[int] = 2

    def __init__(self, findings: Iterable[Finding]) -> None:
        self.findings = tuple(sorted(findings, key=lambda finding: finding.order))
        super().__init__("\n".join(map(str, self.findings)))


class CampaignWarning(UserWarning):
    """What is hardly meant in a campaign: the Python functions warn of it, and fly."""


class UsageError(RvjaxError):
    """The command or the call is wrong."""

    exit_code: ClassVar[int] = 2


class IncompleteError(RvjaxError):
    """Work was stopped or lost; what was committed is kept and the same command goes on from there.

    stopped: the folder that keeps it; go_on_with: the words of the command. Both are empty where no folder was opened.
    """

    exit_code: ClassVar[int] = 4
    stopped: str = ""
    go_on_with: Sequence[str] = ()


class AuditError(RvjaxError):
    """What flies is not what the table says: a component, or this package, is at fault."""

    exit_code: ClassVar[int] = 4


class FolderError(RvjaxError):
    """A run folder's integrity is broken, or it belongs to another run."""

    exit_code: ClassVar[int] = 5


class DamagedError(FolderError):
    """A file of a run folder is missing, or is not what was written."""
