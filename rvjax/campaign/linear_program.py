"""A small linear program in plain arithmetic, the same bits on every machine: how far a wrench can be pushed.

    max λ ≤ 1   with   A x = λ e,   0 ≤ x ≤ 1

The simplex method with bounded variables from x = 0, λ = 0 (V. Chvátal, "Linear Programming", 1983, chapter 8), with the rule of
R. Bland (1977), which never turns in a circle. Compared with SciPy's `linprog` in tests/physics/test_thrusters.py: to rounding.
"""

from __future__ import annotations

from collections.abc import Sequence

SMALL = 1e-11
"""A slope or a pivot that is as small is 0; A has entries up to 1."""

MOST_STEPS = 10_000


class _Tableau:
    """The program in the form of Bland's rule: variables 0 … m − 1 are always 0 and begin in the basis, then x, then λ.

    rows: B⁻¹[1, A, −e]; slopes: of λ along each variable; values: of the basis; upper: whether a variable is at its upper bound.
    """

    def __init__(self, a: Sequence[Sequence[float]], e: Sequence[float]) -> None:
        self.fixed, count = len(a), len(a[0])
        self.rows = [[*(float(i == k) for k in range(self.fixed)), *map(float, row), -float(e[i])] for i, row in enumerate(a)]
        self.last = self.fixed + count
        self.slopes = [0.0] * self.last + [1.0]
        self.basis, self.values = list(range(self.fixed)), [0.0] * self.fixed
        self.upper = [False] * (self.last + 1)

    def entering(self) -> int | None:
        """The first variable whose change raises λ."""
        for j in range(self.fixed, self.last + 1):
            if j not in self.basis and (self.slopes[j] < -SMALL if self.upper[j] else self.slopes[j] > SMALL):
                return j
        return None

    def step(self, j: int) -> None:
        """Changes variable j until a bound stops it."""
        way = -1.0 if self.upper[j] else 1.0
        longest, stop = 1.0, None
        for i, row in enumerate(self.rows):
            fall = way * row[j]
            if abs(fall) <= SMALL:
                continue
            top = 0.0 if self.basis[i] < self.fixed else 1.0
            room = max((self.values[i] if fall > 0.0 else self.values[i] - top) / fall, 0.0)
            if room < longest or (room == longest and stop is not None and self.basis[i] < self.basis[stop]):
                longest, stop = room, i
        self.values = [value - way * longest * row[j] for value, row in zip(self.values, self.rows, strict=True)]
        if stop is None:
            self.upper[j] = not self.upper[j]
            return
        self.upper[self.basis[stop]] = way * self.rows[stop][j] < 0.0
        self.values[stop] = (1.0 if self.upper[j] else 0.0) + way * longest
        self._exchange(stop, j)

    def _exchange(self, stop: int, j: int) -> None:
        """Variable j takes the place in the basis."""
        pivot = self.rows[stop][j]
        row = self.rows[stop] = [x / pivot for x in self.rows[stop]]
        for i, other in enumerate(self.rows):
            if i != stop and (factor := other[j]):
                self.rows[i] = [x - factor * y for x, y in zip(other, row, strict=True)]
        factor = self.slopes[j]
        self.slopes = [x - factor * y for x, y in zip(self.slopes, row, strict=True)]
        self.basis[stop] = j

    def value(self) -> float:
        """λ."""
        if self.last in self.basis:
            return self.values[self.basis.index(self.last)]
        return 1.0 if self.upper[self.last] else 0.0


def reach(a: Sequence[Sequence[float]], e: Sequence[float]) -> float:
    """max λ ≤ 1 with A x = λ e, 0 ≤ x ≤ 1. a: rows of A, with entries up to 1."""
    tableau = _Tableau(a, e)
    for _ in range(MOST_STEPS):
        j = tableau.entering()
        if j is None:
            return tableau.value()
        tableau.step(j)
    raise ArithmeticError("the simplex method does not end")
