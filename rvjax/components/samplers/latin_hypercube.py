"""Latin hypercube: u = (π(s) + v)/N; π: permutation of 0 … N−1 for each variable, v: stream of the variable at sample s.

Each variable has N equally probable strata, and each stratum holds exactly 1 of N samples (M. McKay, R. Beckman, W. Conover,
Technometrics 21, 1979). π is a Feistel network on the next power of two with cycle walking below N (J. Black, P. Rogaway,
"Ciphers with arbitrary finite domains", CT-RSA 2002), keyed by seed and name: any sample is computed without the others, and no
variable changes the permutation of another. Another number of samples gives other samples. Samples are not independent, so this
design is for exploration and gives no verdict.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rvjax.campaign import Model
from rvjax.components.samplers.interface import Samples, Sampling, Scheme, Values, of_stratum
from rvjax.stats.random_streams import uniforms
from rvjax.stats.sampling_design import Exploration

ROUNDS = 12
FEWEST_BITS = 2
"""Fewest bits of the network, 1 in each half."""

Words = NDArray[np.uint64]


class Parameters(Model):
    """No parameters."""


@dataclass(frozen=True)
class LatinHypercube:
    """A Latin hypercube of `count` samples."""

    seed: int
    count: int

    def at(self, samples: Samples) -> Strata:
        """The points of some samples."""
        return Strata(self, samples)


@dataclass(frozen=True)
class Strata:
    """The strata of some samples."""

    hypercube: LatinHypercube
    samples: Samples

    def uniforms(self, name: str, count: int) -> Values:
        """(samples, count) numbers in (0, 1), each in the stratum of its sample."""
        seed, total = self.hypercube.seed, self.hypercube.count
        inside = uniforms(seed, name, self.samples)
        numbers = (self.samples % total).astype(np.uint64)
        strata = (permuted(f"{seed}:{name}:{index}", numbers, total).astype(np.float64) for index in range(count))
        columns = [of_stratum(stratum, inside[:, index], total) for index, stratum in enumerate(strata)]
        return np.stack(columns, axis=1)

    def prescribed(self, name: str) -> None:
        """No draw is prescribed."""


def permuted(key: str, numbers: Words, count: int) -> Words:
    """π(s) for some s below `count`: a permutation of 0 … count − 1 for each key."""
    secret = np.frombuffer(hashlib.sha256(f"strata:{key}".encode()).digest()[:16], dtype="<u8")
    keys = np.random.Philox(key=secret).random_raw(ROUNDS)
    bits = max(FEWEST_BITS, (count - 1).bit_length())
    places = _network(numbers, keys, bits)
    while (outside := np.flatnonzero(places >= count)).size:
        places[outside] = _network(places[outside], keys, bits)
    return places


def _network(numbers: Words, keys: Words, bits: int) -> Words:
    """A permutation of 0 … 2^bits − 1: each round changes a half of the bits by a function of the other half and a key."""
    low_bits = np.uint64(bits // 2)
    low_mask, high_mask = np.uint64((1 << (bits // 2)) - 1), np.uint64((1 << (bits - bits // 2)) - 1)
    low, high = numbers & low_mask, numbers >> low_bits
    for index, key in enumerate(keys):
        if index % 2:
            low = low ^ (_mixed(high + key) & low_mask)
        else:
            high = high ^ (_mixed(low + key) & high_mask)
    return (high << low_bits) | low


def _mixed(words: Words) -> Words:
    """The finaliser of SplitMix64 (G. Steele, D. Lea, C. Flood, OOPSLA 2014): every bit depends on every bit."""
    words = (words ^ (words >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    words = (words ^ (words >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return words ^ (words >> np.uint64(31))


COMPONENT = Sampling(
    Parameters,
    lambda parameters: Scheme(lambda setting: LatinHypercube(setting.seed, setting.samples), extends=False),
    design=Exploration(),
)
