"""Correlated draws: rank correlations that a campaign asks for.

Spearman's rank correlation ρ of two numbers with a Gaussian copula belongs to the correlation r of two normal ones,

    r = 2 sin(πρ/6)        (K. Pearson, "On further methods of determining correlation", 1907; W. Kruskal, JASA 53, 1958)

exactly, whatever the laws of the two numbers are, as long as these have no steps.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, Self

import numpy as np
from pydantic import model_validator
from pydantic_core import core_schema

from rvjax.campaign.fields import Model, option
from rvjax.campaign.plain_values import is_list, is_number
from rvjax.campaign.problems import Problem, refuse, unexpected

LEAST = 1e-8
"""Eigenvalue of a correlation matrix that counts as above 0."""

MOST = 64
"""Variables in a group."""

Matrix = tuple[tuple[float, ...], ...]


def normal_correlation(rank: Matrix) -> Matrix:
    """r = 2 sin(πρ/6) off the diagonal."""
    return tuple(
        tuple(1.0 if i == j else 2.0 * math.sin(math.pi * rho / 6.0) for j, rho in enumerate(row)) for i, row in enumerate(rank)
    )


class RankMatrix:
    """Reads a correlation matrix: symmetric, 1 on the diagonal, positive definite as it stands and as normal correlations."""

    def read(self, raw: Any) -> Matrix:
        """The matrix, or what is wrong with it."""
        rows = raw if is_list(raw) else []
        square = all(is_list(row) and len(row) == len(rows) for row in rows)
        if not 2 <= len(rows) <= MOST or not square:
            refuse(unexpected(raw, f"accepted: a square matrix, [[1, 0.5], [0.5, 1]], of 2 to {MOST} variables"))
        accepted = "accepted: a number from -1 to 1"
        places = [(i, j) for i in range(len(rows)) for j in range(len(rows))]
        wrong = [(i, j) for i, j in places if not is_number(rows[i][j]) or not -1.0 <= rows[i][j] <= 1.0]
        if wrong:
            refuse(*(unexpected(rows[i][j], accepted, (i, j)) for i, j in wrong))
        for i, j in places:
            if i == j and rows[i][j] != 1:
                refuse(Problem(f"{rows[i][j]:g} on the diagonal", "accepted: 1 on the diagonal"))
            if rows[i][j] != rows[j][i]:
                refuse(Problem(f"{rows[i][j]:g} in row {i + 1} is {rows[j][i]:g} in row {j + 1}", "accepted: a symmetric matrix"))
        rank = tuple(tuple(float(entry) for entry in row) for row in rows)
        for matrix, words in ((rank, ""), (normal_correlation(rank), " as correlations 2 sin(pi rho/6) of normal numbers")):
            least = float(np.linalg.eigvalsh(np.array(matrix))[0])
            if least < LEAST:
                message = f"the matrix is not positive definite{words}, its least eigenvalue is {least:.3g}"
                refuse(Problem(message, "accepted: correlations that can occur together"))
        return rank

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        row = {"type": "array", "items": {"type": "number", "minimum": -1, "maximum": 1}, "minItems": 2, "maxItems": MOST}
        return {"type": "array", "items": row, "minItems": 2, "maxItems": MOST}


class Correlation(Model):
    """Draws with a Gaussian copula: the law of each stays what it is, their Spearman rank correlations are `rank`."""

    variables: tuple[str, ...] = option(doc="names of draws, such as pursuer.mass_kg and pursuer.inertia_kgm2.moments.x")
    rank: Annotated[Matrix, RankMatrix()] = option(doc="matrix of rank correlations, in the order of the variables")

    @model_validator(mode="after")
    def _fitting(self) -> Self:
        if len(self.variables) != len(self.rank):
            message = f"{len(self.variables)} variables but a matrix of {len(self.rank)} rows"
            refuse(Problem(message, "accepted: a row for each variable", ("rank",)))
        return self

    @property
    def ordered(self) -> tuple[tuple[str, ...], Matrix]:
        """Variables in the order of their names, and the matrix in that order."""
        order = sorted(range(len(self.variables)), key=lambda index: self.variables[index])
        names = tuple(self.variables[index] for index in order)
        return names, tuple(tuple(self.rank[i][j] for j in order) for i in order)
