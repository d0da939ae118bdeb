"""Studies of the package Optuna, from which the methods `tpe` and `nsga` get their candidates.

Optuna is imported when a search runs. Its log level is restored after every use.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from rvjax.campaign.problems import Problem
from rvjax.components.extras import lacking
from rvjax.components.search_methods.interface import Axis, Values

if TYPE_CHECKING:
    from optuna import Study
    from optuna.distributions import BaseDistribution
    from optuna.samplers import BaseSampler
    from optuna.trial import Trial


def problems(method: str) -> Iterator[Problem]:
    """That the package Optuna is not installed, or too old."""
    if lack := lacking("optuna"):
        yield Problem(f"the method {method} needs {lack}", "accepted: pip install 'rvjax[tune]'", ("use",))


@contextmanager
def silent() -> Iterator[None]:
    """Suppresses messages of Optuna and its warnings about experimental features."""
    from optuna import logging

    before = logging.get_verbosity()
    logging.set_verbosity(logging.ERROR)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        logging.set_verbosity(before)


def study_of(sampler: BaseSampler, objectives: int = 1) -> Study:
    """A study in memory that minimises every objective."""
    from optuna import create_study
    from optuna.storages import InMemoryStorage
    from optuna.study import StudyDirection

    return create_study(storage=InMemoryStorage(), sampler=sampler, directions=[StudyDirection.MINIMIZE] * objectives)


@dataclass(frozen=True)
class Space:
    """The axes as Optuna's distributions; whole numbers and choices by the index of their level."""

    axes: Sequence[Axis]

    @property
    def distributions(self) -> dict[str, BaseDistribution]:
        """Distribution of each axis, by name."""
        return {f"x{index}": _distribution(axis) for index, axis in enumerate(self.axes)}

    def parameters(self, point: Values) -> dict[str, Any]:
        """The parameters of a point."""
        coordinates = zip(self.axes, point, strict=True)
        return {f"x{index}": _level(axis, x) if axis.levels else float(x) for index, (axis, x) in enumerate(coordinates)}

    def points(self, asked: Sequence[Trial]) -> Values:
        """(m, d) the points of some candidates."""
        points = np.array([[trial.params[f"x{index}"] for index in range(len(self.axes))] for trial in asked], dtype=float)
        for column, axis in zip(points.T, self.axes, strict=True):
            if axis.levels:
                column[:] = (column + 0.5) / axis.levels
        return points


def _distribution(axis: Axis) -> BaseDistribution:
    from optuna.distributions import CategoricalDistribution, FloatDistribution, IntDistribution

    if not axis.levels:
        return FloatDistribution(0.0, 1.0)
    return IntDistribution(0, axis.levels - 1) if axis.ordered else CategoricalDistribution(range(axis.levels))


def _level(axis: Axis, x: float) -> int:
    return min(int(x * axis.levels), axis.levels - 1)
