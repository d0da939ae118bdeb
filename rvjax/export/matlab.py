"""MAT-files of version 5 ("MAT-File Format", The MathWorks), written piece by piece, so that a large table is never there twice.

    file      = 128 bytes of text and version, then a variable after the other
    variable  = tag(14, size), flags, shape, name, contents                          each contents a multiple of 8 bytes
    tag       = data type and size as 32-bit numbers; all numbers are little endian, and nothing is compressed

Texts are UTF-16: MATLAB has it inside, and Octave cuts UTF-8 texts with letters outside of ASCII after as many bytes as they have
letters ("kg·m²" becomes "kg·m").
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator, Mapping
from itertools import chain
from typing import NamedTuple

import numpy as np
import pandas as pd

LARGEST = 2**31 - 1
"""Bytes of a variable."""

LONGEST = 63
"""Letters of a name in MATLAB 7 and later."""

HEADER = b"MATLAB 5.0 MAT-file, written by rvjax".ljust(124) + struct.pack("<HH", 0x0100, 0x4D49)
"""Before the first variable."""

ROWS = 65_536
"""Texts that are written at once."""

_INT8, _INT32, _UINT32, _DOUBLE, _INT64, _UINT64, _MATRIX, _UTF16 = 1, 5, 6, 9, 12, 13, 14, 17
_CELLS, _STRUCT, _CHARS, _DOUBLES, _INT64S, _UINT64S = 1, 2, 4, 6, 14, 15


class Piece(NamedTuple):
    """size: bytes. parts: makes them."""

    size: int
    parts: Callable[[], Iterator[bytes]]


def record(fields: Mapping[str, Piece], name: str = "") -> Piece:
    """A struct of one element. name: of the variable, empty inside of another."""
    names = b"".join(field.encode("ascii").ljust(LONGEST + 1, b"\0") for field in fields)
    head = struct.pack("<HHi", _INT32, 4, LONGEST + 1) + _element(_INT8, names)
    return _matrix(_STRUCT, (1, 1), name, (Piece(len(head), lambda: iter([head])), *fields.values()))


def text(value: str) -> Piece:
    """A row of characters."""
    data = value.encode("utf-16-le")
    whole = _element(_UTF16, data)
    shape = (1, len(data) // 2) if data else (0, 0)
    return _matrix(_CHARS, shape, "", (Piece(len(whole), lambda: iter([whole])),))


def integer(value: int) -> Piece:
    """A whole number of 64 bits."""
    kind, form, code = (_INT64S, _INT64, "<q") if value < 2**63 else (_UINT64S, _UINT64, "<Q")
    whole = _element(form, struct.pack(code, value))
    return _matrix(kind, (1, 1), "", (Piece(len(whole), lambda: iter([whole])),))


def column(values: pd.Series) -> Piece:
    """(n, 1): numbers and truths as float64, anything else as a cell array of texts."""
    if pd.api.types.is_numeric_dtype(values) or pd.api.types.is_bool_dtype(values):
        return _doubles(values)
    return _texts(values)


def _doubles(values: pd.Series) -> Piece:
    head = struct.pack("<II", _DOUBLE, 8 * len(values))

    def parts() -> Iterator[bytes]:
        yield head + values.to_numpy(dtype="<f8").tobytes()

    return _matrix(_DOUBLES, (len(values), 1), "", (Piece(len(head) + 8 * len(values), parts),))


def _texts(values: pd.Series) -> Piece:
    """Each different text is coded once."""
    codes, different = pd.factorize(values.astype(str), sort=False)
    coded = [b"".join(text(str(value)).parts()) for value in different]
    size = int(np.array([len(part) for part in coded], dtype=np.int64)[codes].sum())

    def parts() -> Iterator[bytes]:
        for begin in range(0, len(codes), ROWS):
            yield b"".join(coded[code] for code in codes[begin : begin + ROWS])

    return _matrix(_CELLS, (len(values), 1), "", (Piece(size, parts),))


def _matrix(kind: int, shape: tuple[int, int], name: str, contents: tuple[Piece, ...]) -> Piece:
    head = _element(_UINT32, struct.pack("<II", kind, 0)) + _element(_INT32, struct.pack("<ii", *shape))
    head += _element(_INT8, name.encode("ascii"))
    size = len(head) + sum(piece.size for piece in contents)

    def parts() -> Iterator[bytes]:
        yield struct.pack("<II", _MATRIX, size) + head
        yield from chain.from_iterable(piece.parts() for piece in contents)

    return Piece(8 + size, parts)


def _element(form: int, data: bytes) -> bytes:
    """With zeros up to a multiple of 8 bytes."""
    return struct.pack("<II", form, len(data)) + data + b"\0" * (-len(data) % 8)
