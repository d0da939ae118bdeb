"""Columns of numbers as text in the page: 16 bits a number, delta coded, deflated, base64.

    k = round((x − offset)/scale),  x ≈ offset + scale k,  0 ≤ k ≤ 65532          |x − (offset + scale k)| ≤ scale/2
    65533: not a number     65534: −∞     65535: +∞

Each column has its offset and its scale, the quantum. Where 0 is between its values, offset = −m scale with a whole m, so that a
force of zero is shown as zero; the quantum is then larger by a part in 32,766 at most. Codes follow each other as differences
modulo 2¹⁶, zigzag coded (0, −1, 1, −2, … as 0, 1, 2, 3, …); the high bytes of a column stand before its low bytes. All columns
of a block are deflated together, without a header. `scripts/blocks.js` reads them.
"""

from __future__ import annotations

import base64
import math
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

MOST = 65532
"""The largest code of a finite number."""

NAN, LOW, HIGH = 65533, 65534, 65535
"""The codes of not a number, −∞ and +∞."""


@dataclass(frozen=True)
class Block:
    """rows: of every column; columns: name → (offset, scale); text: base64."""

    rows: int
    columns: Mapping[str, tuple[float, float]]
    text: str

    @property
    def head(self) -> dict[str, Any]:
        """What the page needs to read the text."""
        return {"rows": self.rows, "columns": [[name, *ends] for name, ends in self.columns.items()]}


def block(columns: Mapping[str, NDArray[Any]]) -> Block:
    """Columns of the same length (n,) as a block."""
    coded = {name: quantised(np.asarray(values, dtype=np.float64)) for name, values in columns.items()}
    data = b"".join(_bytes(codes) for codes, _, _ in coded.values())
    packer = zlib.compressobj(9, zlib.DEFLATED, -zlib.MAX_WBITS)
    text = base64.b64encode(packer.compress(data) + packer.flush()).decode("ascii")
    rows = max((codes.size for codes, _, _ in coded.values()), default=0)
    return Block(rows, {name: (offset, scale) for name, (_, offset, scale) in coded.items()}, text)


def quantised(values: NDArray[np.float64]) -> tuple[NDArray[np.uint16], float, float]:
    """(n,) codes, offset and scale. The scale of a constant is 0."""
    usable = np.isfinite(values)
    offset, scale = _grid(values[usable])
    codes = np.zeros(values.shape, dtype=np.uint16)
    if scale > 0.0:
        codes[usable] = np.clip(np.rint(values[usable] / scale - offset / scale), 0, MOST).astype(np.uint16)
    for code, places in ((NAN, np.isnan(values)), (LOW, values == -math.inf), (HIGH, values == math.inf)):
        codes[places] = code
    return codes, offset, scale


def _grid(finite: NDArray[np.float64]) -> tuple[float, float]:
    """Offset and scale, with a code for 0 where it is between two values."""
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)
    scale = high / MOST - low / MOST  # of halves: the width of all floats overflows
    if not (scale > 0.0 and math.isfinite(scale)):
        return low, 0.0
    if not low < 0.0 <= high:
        return low, scale
    below = math.floor(-low / scale)
    grids = [(m, max(-low / m, high / max(MOST - m, 1))) for m in (below, below + 1) if 1 <= m < MOST or (m == MOST and not high)]
    m, wider = min(grids, key=lambda grid: grid[1], default=(0, math.inf))
    return (-m * wider, wider) if math.isfinite(m * wider) else (low, scale)


def _bytes(codes: NDArray[np.uint16]) -> bytes:
    """Differences, zigzag coded, as high bytes and low bytes."""
    steps = np.diff(codes, prepend=np.uint16(0)).astype(np.int16)
    zigzag = ((steps.astype(np.int32) << 1) ^ (steps.astype(np.int32) >> 15)).astype(np.uint16)
    return (zigzag >> 8).astype(np.uint8).tobytes() + (zigzag & 0xFF).astype(np.uint8).tobytes()
