"""Correlated draws: rank correlations that a campaign asks for.

Spearman's rank correlation ρ of two numbers with a Gaussian copula belongs to the correlation r of two normal ones,

    r = 2 sin(πρ/6)        (K. Pearson, "On further methods of determining correlation", 1907; W. Kruskal, JASA 53, 1958)

exactly, whatever the laws of the two numbers are, as long as these have no steps. ρ = 1 ties two numbers (each rises with the
other), ρ = −1 ties them in opposite directions.

A covariance matrix C belongs to normal laws: r = Cᵢⱼ/√(Cᵢᵢ Cⱼⱼ), and the numbers are jointly normal. For other laws a covariance
does not decide the dependence, so it is refused.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import model_validator
from pydantic_core import core_schema

from rvjax.campaign.distributions import Normal
from rvjax.campaign.fields import Model, option
from rvjax.campaign.plain_values import exact, is_list, is_number
from rvjax.campaign.problems import Problem, refuse, unexpected
from rvjax.elementary import sin

LEAST = 1e-8
"""Eigenvalue of a correlation matrix that counts as above 0."""

MOST = 64
"""Variables in a group."""

ROUNDING = 1e-12
"""A correlation from a covariance that is as near to 1 or −1 is 1 or −1."""

AGREEMENT = 1e-3
"""Relative difference of a variance from that of the law that is accepted: a variance is written with few digits."""

Matrix = tuple[tuple[float, ...], ...]


def normal_correlation(rank: Matrix) -> Matrix:
    """r = 2 sin(πρ/6) off the diagonal."""
    return tuple(tuple(rho if abs(rho) == 1.0 else 2.0 * float(sin(math.pi * rho / 6.0)) for rho in row) for row in rank)


def ties(matrix: Matrix) -> tuple[tuple[int, float], ...]:
    """Of each variable the first variable that it is tied to, and ±1: whether it rises or falls with it; of most, itself."""
    first = [next(j for j in range(i + 1) if abs(matrix[i][j]) == 1.0) for i in range(len(matrix))]
    return tuple((j, matrix[i][j]) for i, j in enumerate(first))


def check_possible(matrix: Matrix, words: str = "") -> None:
    """Refuse correlations that cannot occur together. Tied variables have the same correlations with all others; without them,
    the matrix is positive definite."""
    tied = ties(matrix)
    for i, (leader, sign) in enumerate(tied):
        for j, entry in enumerate(matrix[i]):
            if abs(entry - sign * matrix[leader][j]) > ROUNDING:
                message = f"variable {i + 1} is tied to variable {leader + 1}, but {exact(entry)} in row {i + 1} is not "
                message += f"{exact(sign * matrix[leader][j])}, as row {leader + 1} demands"
                refuse(Problem(message, "accepted: the same row, with the sign of the tie"))
    free = [i for i, (leader, _) in enumerate(tied) if leader == i]
    least = float(np.linalg.eigvalsh(np.array(matrix)[np.ix_(free, free)])[0])
    if least < LEAST:
        message = f"the matrix is not positive definite{words}, its least eigenvalue is {least:.3g}"
        refuse(Problem(message, "accepted: correlations that can occur together; 1 or -1 ties two variables"))


def _rows(raw: Any) -> list[list[Any]]:
    """The rows of a square matrix."""
    rows = raw if is_list(raw) else []
    square = all(is_list(row) and len(row) == len(rows) for row in rows)
    if not 2 <= len(rows) <= MOST or not square:
        refuse(unexpected(raw, f"accepted: a square matrix, [[1, 0.5], [0.5, 1]], of 2 to {MOST} variables"))
    return rows


def _check_symmetric(rows: list[list[Any]]) -> None:
    for i, row in enumerate(rows):
        for j, entry in enumerate(row):
            if entry != rows[j][i]:
                message = f"{exact(entry)} in row {i + 1} is {exact(rows[j][i])} in row {j + 1}"
                refuse(Problem(message, "accepted: a symmetric matrix"))


class RankMatrix:
    """Reads a correlation matrix: symmetric, 1 on the diagonal, positive definite as it stands and as normal correlations."""

    def read(self, raw: Any) -> Matrix | None:
        """The matrix, or what is wrong with it; None where it is left out."""
        if raw is None:
            return None
        rows = _rows(raw)
        accepted = "accepted: a number from -1 to 1"
        places = [(i, j) for i in range(len(rows)) for j in range(len(rows))]
        wrong = [(i, j) for i, j in places if not is_number(rows[i][j]) or not -1.0 <= rows[i][j] <= 1.0]
        if wrong:
            refuse(*(unexpected(rows[i][j], accepted, (i, j)) for i, j in wrong))
        for i, j in places:
            if i == j and rows[i][j] != 1:
                refuse(Problem(f"{exact(rows[i][j])} on the diagonal", "accepted: 1 on the diagonal"))
        _check_symmetric(rows)
        rank = tuple(tuple(float(entry) for entry in row) for row in rows)
        check_possible(rank)
        check_possible(normal_correlation(rank), " as correlations 2 sin(pi rho/6) of normal numbers")
        return rank

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        row = {"type": "array", "items": {"type": "number", "minimum": -1, "maximum": 1}, "minItems": 2, "maxItems": MOST}
        return {"type": "array", "items": row, "minItems": 2, "maxItems": MOST}


class CovarianceMatrix:
    """Reads a covariance matrix: symmetric, variances on the diagonal, correlations that can occur together."""

    def read(self, raw: Any) -> Matrix | None:
        """The matrix, or what is wrong with it; None where it is left out."""
        if raw is None:
            return None
        rows = _rows(raw)
        places = [(i, j) for i in range(len(rows)) for j in range(len(rows))]
        if wrong := [(i, j) for i, j in places if not is_number(rows[i][j])]:
            refuse(*(unexpected(rows[i][j], "accepted: a number, in SI", (i, j)) for i, j in wrong))
        if low := [i for i, row in enumerate(rows) if row[i] <= 0]:
            refuse(*(unexpected(rows[i][i], "accepted: a variance above 0, in SI", (i, i)) for i in low))
        _check_symmetric(rows)
        covariance = tuple(tuple(float(entry) for entry in row) for row in rows)
        for i, j in places:
            most = math.sqrt(covariance[i][i] * covariance[j][j])
            if abs(covariance[i][j]) > most * (1.0 + ROUNDING):
                message = (
                    f"the covariance {exact(covariance[i][j])} is above {exact(most)}, the product of the standard deviations"
                )
                refuse(Problem(message, f"accepted: from {exact(-most)} to {exact(most)}", (i, j)))
        check_possible(correlations(covariance))
        return covariance

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        row = {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": MOST}
        return {"type": "array", "items": row, "minItems": 2, "maxItems": MOST}


def correlations(covariance: Matrix) -> Matrix:
    """r = Cᵢⱼ/√(Cᵢᵢ Cⱼⱼ); 1 and −1 where it is so up to rounding."""

    def entry(i: int, j: int) -> float:
        r = covariance[i][j] / math.sqrt(covariance[i][i] * covariance[j][j])
        return math.copysign(1.0, r) if i == j or abs(r) > 1.0 - ROUNDING else r

    return tuple(tuple(entry(i, j) for j in range(len(covariance))) for i in range(len(covariance)))


class Correlation(Model):
    """Draws that depend on each other; the law of each stays what it is.

    rank: Spearman's rank correlations of a Gaussian copula, for every law; 1 and −1 tie draws exactly. covariance: of draws with
    `normal` laws, in SI as the draws; its diagonal is their variances within 0.1 %, its other entries become correlations, and
    the draws are jointly normal. One of the two is given.
    """

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = (
        {"variables": ["pursuer.mass_kg", "pursuer.inertia_kgm2.principal.x"], "rank": [[1, 0.5], [0.5, 1]]},
    )

    variables: tuple[str, ...] = option(doc="names of draws, such as pursuer.mass_kg and pursuer.inertia_kgm2.moments.x")
    rank: Annotated[Matrix | None, RankMatrix()] = option(
        default=None, doc="matrix of rank correlations from -1 to 1, in the order of the variables"
    )
    covariance: Annotated[Matrix | None, CovarianceMatrix()] = option(
        default=None, doc="covariance matrix of normal laws instead of rank, in SI, in the order of the variables"
    )

    @model_validator(mode="after")
    def _fitting(self) -> Self:
        if (self.rank is None) == (self.covariance is None):
            words = "neither rank nor covariance" if self.rank is None else "both rank and covariance"
            refuse(Problem(words, "accepted: one of them, rank or covariance"))
        key = "rank" if self.covariance is None else "covariance"
        if len(self.variables) != len(self._given):
            message = f"{len(self.variables)} variables but a matrix of {len(self._given)} rows"
            refuse(Problem(message, "accepted: a row for each variable", (key,)))
        return self

    @property
    def _given(self) -> Matrix:
        return self.rank or self.covariance or ()

    @property
    def ordered(self) -> tuple[tuple[str, ...], Matrix, *tuple[str, ...]]:
        """Variables in the order of their names, and the given matrix in that order; of a covariance its correlations, and a word
        for it: all that decides the draws."""
        given, word = (self.rank, ()) if self.covariance is None else (correlations(self.covariance), ("covariance",))
        names, matrix = self._in_order(given or ())
        return names, matrix, *word

    @property
    def normal(self) -> tuple[tuple[str, ...], Matrix]:
        """Variables in the order of their names, and the correlations of their normal numbers."""
        ranks = self.covariance is None
        return self._in_order(normal_correlation(self.rank or ()) if ranks else correlations(self.covariance or ()))

    def _in_order(self, matrix: Matrix) -> tuple[tuple[str, ...], Matrix]:
        order = sorted(range(len(self.variables)), key=lambda index: self.variables[index])
        names = tuple(self.variables[index] for index in order)
        return names, tuple(tuple(matrix[i][j] for j in order) for i in order)

    def law_problems(self, laws: Mapping[str, object]) -> Iterator[Problem]:
        """Laws that have no such covariance. laws: by the names of the variables."""
        for index, name in enumerate(self.variables if self.covariance is not None else ()):
            law, variance = laws[name], self._given[index][index]
            if not isinstance(law, Normal):
                message = f"{name} is not normal, so a covariance does not decide how it depends on the others"
                yield Problem(message, "accepted: normal laws, or rank instead of covariance", ("variables", index))
            elif abs(variance - law.sd**2) > AGREEMENT * law.sd**2:
                message = f"the variance {exact(variance)} of {name} is not that of its law"
                accepted = f"accepted: {exact(law.sd**2)}, the square of its standard deviation {exact(law.sd)} in SI"
                yield Problem(message, accepted, ("covariance", index, index))
