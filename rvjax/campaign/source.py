"""The text of a campaign file: its plain values, their positions, and what is wrong with it as a file."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import Any

from rvjax.campaign.plain_values import Place, describe, dotted, is_mapping
from rvjax.campaign.yaml_document import NOT_PRINTABLE, parse
from rvjax.errors import Finding

MOST_BYTES = 128 * 1024
MOST_LINES = 100
"""Upper limit of the reported lines with characters that are not accepted."""

_TAB_INDENT = re.compile(r" *\t(?=\s*[^\s#])")


@dataclass(frozen=True)
class Source:
    """name: of the file; text: unchanged; value: the plain values; marks, key_marks: positions of values and keys; inputs: the
    bytes of the CSV files that it names, by their names in it.

    `value` is None and `findings` is not empty where the text could not be read at all.
    """

    name: str
    text: str = ""
    value: dict[str, Any] | None = None
    marks: dict[Place, str] = field(default_factory=dict[Place, str])
    key_marks: dict[Place, str] = field(default_factory=dict[Place, str])
    findings: tuple[Finding, ...] = ()
    inputs: dict[str, bytes] = field(default_factory=dict[str, bytes], repr=False)

    def where(self, place: Place, key: bool = False) -> str:
        """`file:line:column` of a value, or of its key; of what should hold it where it is not in the file."""
        for length in range(len(place), -1, -1):
            for marks in (self.key_marks, self.marks) if key or length < len(place) else (self.marks,):
                if length and place[:length] in marks:
                    return marks[place[:length]]
        return f"{self.name}:1:1"

    def finding(self, place: Place, message: str, accepted: str = "", key: bool = False) -> Finding:
        """A finding about the value at a place, or about its key."""
        return Finding(self.where(place, key), dotted(place), message, accepted)


def read(path: str | Path) -> Source:
    """The source of a campaign file, with all its findings; never raises for what a file holds or is."""
    name = str(path)

    def refuse(message: str, accepted: str, line: int = 1, column: int = 1) -> Source:
        return Source(name, findings=(Finding(f"{name}:{line}:{column}", "", message, accepted),))

    try:
        with open(path, "rb") as file:
            content = file.read(MOST_BYTES + 1)
    except IsADirectoryError:
        return refuse("this is a folder", "accepted: a campaign file")
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        return refuse(f"cannot be read: {reason}", "accepted: a campaign file, such as `rvjax init` writes")
    if len(content) > MOST_BYTES:
        return refuse(f"the file is larger than {MOST_BYTES // 1024} KiB", "accepted: a smaller file")
    try:
        return read_text(content.decode("utf-8"), name)
    except UnicodeDecodeError as error:
        before = content[: error.start].decode("utf-8", errors="replace")
        message = f"byte 0x{content[error.start]:02x} is not UTF-8"
        return refuse(message, "accepted: text in UTF-8", before.count("\n") + 1, len(before) - before.rfind("\n"))


def read_text(text: str, name: str) -> Source:
    """The source of campaign text that is known under a name."""
    refused = [
        Finding(f"{name}:{line}:{match.start() + 1}", "", f"character U+{ord(match[0]):04X}", "accepted: printable text")
        for line, match in _lines(NOT_PRINTABLE.search, text)
    ] or [
        Finding(f"{name}:{line}:{match.end()}", "", "a tab in the indentation", "accepted: spaces")
        for line, match in _lines(_TAB_INDENT.match, text)
    ]
    if refused:
        return Source(name, text, findings=tuple(refused))
    document = parse(text, name)
    if not is_mapping(document.value):
        if document.value is not None:
            message, accepted = f"found {describe(document.value)}", "accepted: a mapping, such as `samples: 100`"
            document.findings.append(Finding(document.marks[()], "", message, accepted))
        elif not document.findings:
            accepted = "accepted: a campaign, such as `rvjax init` writes"
            document.findings.append(Finding(f"{name}:1:1", "", "the file is empty", accepted))
        return Source(name, text, findings=tuple(document.findings))
    return Source(name, text, document.value, document.marks, document.key_marks, tuple(document.findings))


def _lines(find: Any, text: str) -> Iterator[tuple[int, re.Match[str]]]:
    """(line number, first match) of the lines with a match, up to MOST_LINES."""
    matches = ((number, find(line)) for number, line in enumerate(text.split("\n"), start=1))
    return islice(((number, match) for number, match in matches if match), MOST_LINES)
