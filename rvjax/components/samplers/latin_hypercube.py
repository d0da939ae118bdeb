"""Latin hypercube: u = (π(s) + v)/N, π a permutation of 0 … N−1 of the variable's own, v the variable's stream at sample s.

Of N samples, exactly one is in each of N equally probable strata of each variable (M. McKay, R. Beckman, W. Conover,
Technometrics 21, 1979). π is a Feistel network on the next power of two, walked until it is below N (J. Black, P. Rogaway,
"Ciphers with arbitrary finite domains", CT-RSA 2002), keyed by seed and name: any sample is found without the others, and no
variable changes the permutation of another. The number of samples is part of the plan. Samples are not independent: the plan is
for exploration, and no verdict is issued on it.
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
"""Of the network: one in each half."""

Words = NDArray[np.uint64]


class Parameters(Model):
    """There are none."""


@dataclass(frozen=True)
class LatinHypercube:
    """Strata of N samples."""

    seed: int
    count: int

    def at(self, samples: Samples) -> Strata:
        """The points of some samples."""
        return Strata(self, samples)


@dataclass(frozen=True)
class Strata:
    """The strata of some samples."""

    plan: LatinHypercube
    samples: Samples

    def uniforms(self, name: str, count: int) -> Values:
        """(samples, count) numbers in (0, 1), each in the stratum of its sample."""
        plan = self.plan
        inside = uniforms(plan.seed, name, self.samples)
        numbers = (self.samples % plan.count).astype(np.uint64)
        columns = [
            of_stratum(
                permuted(f"{plan.seed}:{name}:{index}", numbers, plan.count).astype(np.float64), inside[:, index], plan.count
            )
            for index in range(count)
        ]
        return np.stack(columns, axis=1)

    def given(self, name: str) -> None:
        """No draw is given."""


def permuted(key: str, numbers: Words, count: int) -> Words:
    """π(s) for some s below `count`: a permutation of 0 … count − 1, another one for every key."""
    secret = np.frombuffer(hashlib.sha256(f"strata:{key}".encode()).digest()[:16], dtype="<u8")
    keys = np.random.Philox(key=secret).random_raw(ROUNDS)
    bits = max(FEWEST_BITS, (count - 1).bit_length())
    found = _network(numbers, keys, bits)
    while (outside := np.flatnonzero(found >= count)).size:
        found[outside] = _network(found[outside], keys, bits)
    return found


def _network(numbers: Words, keys: Words, bits: int) -> Words:
    """A permutation of 0 … 2^bits − 1: in turn, one half of the bits is changed by a function of the other half and a key."""
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
    basis=Exploration(),
)
