"""Other laws: which samples of a campaign are samples of another law of some of its draws, and with which weights.

    w_i = Π f'_j(x_ij)/f_j(x_ij) over the changed draws,   W = Π sup w_j
    kept: v_i < w_i/W,   v_i from the stream `reweigh.thin` of the campaign's seed

The stream decides no draw and no noise, so what is kept are independent samples of the other law (`rvjax.stats.reweighting`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rvjax.campaign.plain_values import is_list
from rvjax.stats.densities import Law, log_density, ratio
from rvjax.stats.random_streams import uniforms
from rvjax.stats.reweighting import kept

STREAM = "reweigh.thin"


@dataclass(frozen=True)
class Change:
    """Another law of a variable. draws: the names of its numbers; log_sup, beyond: as of `densities.Ratio`."""

    draws: tuple[str, ...]
    old: Law
    new: Law
    log_sup: float
    beyond: float

    def log_weights(self, values: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
        """(n,) ln w of the draws, of the new law within the old one."""
        x = values[0] if len(values) == 1 else np.stack(values, axis=1)
        with np.errstate(invalid="ignore"):
            found = log_density(self.new, x) - log_density(self.old, x)
        return np.where(np.isnan(found), -np.inf, found - math.log1p(-self.beyond))


@dataclass(frozen=True)
class OtherLaw:
    """Other laws of some draws of a campaign. seed: of the campaign."""

    changes: tuple[Change, ...]
    seed: int

    @property
    def draws(self) -> tuple[str, ...]:
        """The names of the draws whose laws change."""
        return tuple(draw for change in self.changes for draw in change.draws)

    @property
    def log_sup(self) -> float:
        """ln W."""
        return math.fsum(change.log_sup for change in self.changes)

    @property
    def beyond(self) -> float:
        """The probability, under the other laws, of draws that the campaign never has."""
        return 1.0 - math.prod(1.0 - change.beyond for change in self.changes)

    @property
    def share_kept(self) -> float:
        """The share of the samples that thinning keeps in the mean, 1/W."""
        return math.exp(-self.log_sup)

    def log_weights(self, drawn: Mapping[str, NDArray[np.float64]]) -> NDArray[np.float64]:
        """(n,) ln w. drawn: (n,) values in SI by the name of the draw."""
        return np.sum([change.log_weights([drawn[name] for name in change.draws]) for change in self.changes], axis=0)

    def keeps(self, samples: NDArray[np.int64], drawn: Mapping[str, NDArray[np.float64]]) -> NDArray[np.bool_]:
        """(n,) which samples thinning keeps. samples: their numbers."""
        return kept(self.log_weights(drawn), self.log_sup, uniforms(self.seed, STREAM, samples)[:, 0])

    def possible(self, drawn: Mapping[str, NDArray[np.float64]]) -> NDArray[np.bool_]:
        """(n,) which draws the other law has."""
        return self.log_weights(drawn) > -np.inf

    def laws(self) -> list[dict[str, Any]]:
        """The laws alone as plain values, which determine the rest: for `OtherLaw.of`."""
        return [
            {"draws": list(change.draws), "old": _law_record(change.old), "new": _law_record(change.new)}
            for change in self.changes
        ]

    @classmethod
    def of(cls, laws: Sequence[Mapping[str, Any]], seed: int) -> OtherLaw:
        """The inverse of `laws`. ValueError, TypeError or KeyError where these are no laws."""
        changes: list[Change] = []
        for item in laws:
            old, new = _law_of(item["old"]), _law_of(item["new"])
            changes.append(Change(tuple(map(str, item["draws"])), old, new, *ratio(old, new)))
        return cls(tuple(changes), seed)

    def record(self) -> dict[str, Any]:
        """Plain values, for a JSON document."""
        numbers = [{"log_sup": change.log_sup, "beyond": change.beyond} for change in self.changes]
        return {"seed": self.seed, "changes": [laws | more for laws, more in zip(self.laws(), numbers, strict=True)]}


def _law_record(law: Any) -> dict[str, Any]:
    """The name of a law and its parameters; an infinite one as text, since JSON has none."""

    def plain(value: Any) -> Any:
        return [*value] if isinstance(value, tuple) else str(value) if value in (math.inf, -math.inf) else value

    return {"law": type(law).__name__, **{name: plain(value) for name, value in asdict(law).items()}}


def _law_of(record: Mapping[str, Any]) -> Law:
    """The inverse of `_law_record`, for laws with a density."""
    kinds = {kind.__name__: kind for kind in log_density.registry if kind is not object}

    def parameter(value: Any) -> Any:
        return tuple(value) if is_list(value) else float(value) if isinstance(value, str) else value

    return kinds[record["law"]](**{name: parameter(value) for name, value in record.items() if name != "law"})
