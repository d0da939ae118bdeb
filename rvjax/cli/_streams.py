"""stdout and stderr of the program: every text can be printed in every encoding, and a closed pipe stops no flight.

A character that the encoding lacks is spelt in ASCII: ≥ as >=, Δ as d, ² as ^2; one without such a spelling is escaped: \\u2603.
Where writing fails, the rest of the output is dropped and the work goes on. The exit code shows the loss.
"""

from __future__ import annotations

import codecs
import io
import os
import sys
import unicodedata
from collections.abc import Iterator
from typing import Any, TextIO

READABLE = "rvjax-readable"
"""The name of the error handler, for `errors=`."""

BROKEN_PIPE = 141
"""Exit code where a reader closed the pipe: 128 + SIGPIPE, as of a program that the signal ends."""

LOST = 4
"""Exit code where output was lost for another reason, such as a full disk."""

_INTERRUPTED = (130, 143)

_SIGNS = """
≥>= ≤<= ≠!= ≈~ ∝~ ±+/- ×x ·* ∘* ÷/ ⁄/ √sqrt ∛cbrt −- –- —- ‐- ‑- ─- ━- │| ┃| ‖|| …... →-> ←<- ↔<-> ↦-> ▸> ∈in ∞inf ∂d Δd
⌈ceil( ⌉) ⌊floor( ⌋) µu ϱrho ‘' ’' “" ”" „" «" »" •* ✅+ ❌x ❔? ¼1/4 ½1/2 ¾3/4 ⅓1/3 ⅔2/3
"""
_MARKS = {"\u0302": "_hat", "\u0303": "_tilde", "\u0304": "_bar", "\u0307": "_dot", "\u0308": "_ddot"}
_WORDS = {"∫": "int ", "∏": "prod ", "∑": "sum ", "∇": "grad ", "§": "section ", "°": " deg"}
_SPACES = dict.fromkeys("\u00a0\u2002\u2003\u2007\u2009\u202f", " ")
_SPELLINGS = {sign[0]: sign[1:] for sign in _SIGNS.split()} | _MARKS | _WORDS | _SPACES

_LATIN_1 = 0xFF
"""Letters with marks up to here belong to a language; those beyond (ĥ, ẋ) are symbols with a hat, a bar or a dot."""


def prepare() -> None:
    """Lets stdout and stderr print any text, and survive a reader that closes the pipe."""
    codecs.register_error(READABLE, _readable)
    if sys.stdout is None or sys.stderr is None:  # closed by the shell, `>&-`: no file of a run may get their numbers
        while (handle := os.open(os.devnull, os.O_RDWR)) <= 2:
            pass
        os.close(handle)
    sys.stdout, sys.stderr = _guarded(sys.stdout), _guarded(sys.stderr)


def is_unicode(stream: TextIO) -> bool:
    """Whether a stream can print every character."""
    return codecs.lookup(getattr(stream, "encoding", None) or "utf-8").name.startswith("utf")


def printable(text: str, stream: TextIO) -> str:
    """The text as the stream prints it, for layouts that depend on its length."""
    encoding = getattr(stream, "encoding", None)
    return text if encoding is None or is_unicode(stream) else text.encode(encoding, READABLE).decode(encoding)


def exit_code(code: int) -> int:
    """The exit code of the program after its last output: `code`, unless output was lost. A stop signal keeps its code."""
    failures: list[OSError] = []
    for stream in (sys.stdout, sys.stderr):
        stream.flush()
        raw = _raw(stream)
        if isinstance(raw, _Sink) and raw.failure is not None:
            failures.append(raw.failure)
    if not failures or code in _INTERRUPTED:
        return code
    if any(isinstance(failure, BrokenPipeError) for failure in failures):
        return BROKEN_PIPE
    print(f"rvjax: the output cannot be written: {failures[0].strerror}", file=sys.stderr, flush=True)
    return LOST


class _Sink(io.FileIO):
    """A file descriptor that takes everything: after a failure the rest goes to /dev/null."""

    failure: OSError | None = None

    def write(self, data: Any, /) -> int:
        try:
            return super().write(data)
        except OSError as error:
            self.failure = error
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self.fileno())
            os.close(nowhere)
            return memoryview(data).nbytes


def _guarded(stream: TextIO | None) -> TextIO:
    """The stream with the error handler; one of a process also with `_Sink`. A stream of a test keeps its buffer."""
    if stream is None:
        return open(os.devnull, "w", encoding="utf-8")
    if not isinstance(stream, io.TextIOWrapper):
        return stream
    raw = _raw(stream)
    if type(stream) is io.TextIOWrapper and type(raw) is io.FileIO:
        stream.flush()
        buffer = io.BufferedWriter(_Sink(raw.fileno(), "wb", closefd=False))
        lines = stream.line_buffering or stream.write_through
        return io.TextIOWrapper(buffer, stream.encoding, READABLE, line_buffering=lines)
    stream.reconfigure(errors=READABLE)
    return stream


def _raw(stream: TextIO) -> object:
    buffer = getattr(stream, "buffer", None)
    return getattr(buffer, "raw", buffer)


def _readable(error: UnicodeError) -> tuple[str, int]:
    """The error handler: ASCII for characters that the encoding lacks."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(_spelt(error.object[error.start : error.end])), error.end


def _spelt(text: str) -> Iterator[str]:
    """ASCII for each character of a text: ⁻³ is ^-3, σ̇ is sigma_dot."""
    before = ""
    for character in text:
        form, _, codes = unicodedata.decomposition(character).rpartition("> ")
        plain = "".join(chr(int(code, 16)) for code in codes.split())
        if character in _SPELLINGS:
            yield _SPELLINGS[character]
        elif form in ("<super", "<sub"):
            mark = "" if form == before else "^" if form == "<super" else "_"
            yield mark + "".join(_spelt(plain))
        elif ord(character) > _LATIN_1 and plain[1:] in _MARKS and plain[0].isascii():
            yield plain[0] + _MARKS[plain[1:]]
        elif character.isascii():
            yield character
        else:
            yield _named(character)
        before = form


def _named(character: str) -> str:
    """The name of a Greek letter, the look of a line of a box, or an escape."""
    name = unicodedata.name(character, "")
    if name.startswith("GREEK") and " LETTER " in name and " WITH " not in name:
        word = name.partition(" LETTER ")[2].replace("LAMDA", "LAMBDA")
        return word.lower() if character.islower() else word.capitalize()
    if name.startswith("BOX DRAWINGS"):
        return "+"
    return character.encode("ascii", "backslashreplace").decode()
