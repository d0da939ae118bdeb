"""Holm's p-values: against every subset of hypotheses, and their exact familywise error."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy import stats as oracle

from rvjax.stats import holm, mcnemar


@pytest.mark.parametrize(
    "p",
    [[], [0.3], [0.01, 0.04, 0.03], [0.5, 0.5, 0.5], [0.0, 1.0], [0.2, 0.001, 0.03, 0.03, 0.011, 0.6], [0.012, 0.02, 0.02, 0.04]],
)
def test_adjusted_p_values_are_those_of_the_closed_test(p: list[float]) -> None:
    """A hypothesis is rejected iff Bonferroni rejects every set that holds it. Kills: Bonferroni, Hochberg, a wrong order."""
    expected = np.zeros(len(p))
    for size in range(1, len(p) + 1):
        for chosen in itertools.combinations(range(len(p)), size):
            together = min(1.0, size * min(p[i] for i in chosen))
            expected[list(chosen)] = np.maximum(expected[list(chosen)], together)
    assert holm(p) == pytest.approx(expected, abs=1e-15)


def test_a_known_example() -> None:
    """(.01, .04, .03): .03, .06, .06. Kills: a maximum that does not accumulate, (m - i) for (m - i + 1)."""
    assert holm([0.01, 0.04, 0.03]) == pytest.approx([0.03, 0.06, 0.06])


@pytest.mark.parametrize("alpha", [0.05, 0.2])
def test_familywise_error_is_below_nominal(alpha: float) -> None:
    """Three true hypotheses with 9 pairs each, all outcomes, independent or the same. Kills: no correction."""
    k = np.arange(10)
    p, law = mcnemar(k, 9 - k), oracle.binom.pmf(k, 9, 0.5)
    rejected = sum(
        float(np.prod(law[list(found)])) for found in itertools.product(k, repeat=3) if np.any(holm(p[list(found)]) <= alpha)
    )
    assert rejected <= alpha
    assert sum(law[i] for i in k if np.any(holm([p[i]] * 3) <= alpha)) <= alpha
    assert alpha < 0.2 or 1 - (1 - law[p <= alpha].sum()) ** 3 > alpha, "without correction it would be more"


def test_what_is_no_p_value_is_refused() -> None:
    """Kills: a check that is left out."""
    for values in ([1.1], [-0.1], [float("nan")], [[0.1]]):
        with pytest.raises(ValueError, match="one row of numbers between 0 and 1"):
            holm(values)
