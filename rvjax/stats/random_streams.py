"""Named random streams: a number depends only on (seed, name, sample).

    u = (⌊w/2¹¹⌋ + ½)/2⁵³,   w: 64-bit words of Philox4x64-10 with key = SHA-256("seed:name")[:128 bits], counter = sample

Every name has a separate stream and every sample a separate block of four words in it. So the order and number of samples, and
further variables, change no number (J. Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", SC'11).
"""

from __future__ import annotations

import hashlib

import numpy as np
from numpy.typing import NDArray

WORDS = 4
"""Words per sample and stream: the most numbers that a draw may take."""

NEAR, MOST_AT_ONCE = 200, 2**20
"""Scattered samples are taken from the whole span between the first and the last, if that has at most `NEAR` samples for each and
`MOST_AT_ONCE` in all: starting a stream takes as long as some hundred samples of it."""


def uniforms(seed: int, name: str, samples: NDArray[np.int64]) -> NDArray[np.float64]:
    """(samples, 4) numbers in (0, 1) of the stream `name`, for any sample numbers in any order."""
    key = np.frombuffer(hashlib.sha256(f"{seed}:{name}".encode()).digest()[:16], dtype="<u8")
    words = np.empty((len(samples), WORDS), dtype=np.uint64)
    breaks = np.flatnonzero(np.diff(samples) != 1) + 1
    if len(breaks) and (span := int(np.ptp(samples)) + 1) <= min(NEAR * len(breaks), MOST_AT_ONCE):
        first = int(samples.min())
        return uniforms(seed, name, np.arange(first, first + span))[samples - first]
    for run in np.split(np.arange(len(samples)), breaks):
        if len(run):
            stream = np.random.Philox(key=key, counter=int(samples[run[0]]))
            words[run] = stream.random_raw(len(run) * WORDS).reshape(-1, WORDS)
    return _shares(words)


def _shares(words: NDArray[np.uint64]) -> NDArray[np.float64]:
    """(⌊w/2¹¹⌋ + ½)/2⁵³; the largest word, which would round to 1, gives the largest number below 1."""
    return np.minimum(((words >> np.uint64(11)).astype(np.float64) + 0.5) * 2.0**-53, 1.0 - 2.0**-53)
