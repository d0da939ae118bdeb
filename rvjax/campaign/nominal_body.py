"""The nominal pursuer of a campaign: the guesses, bounds and gains that the file leaves out follow it.

    m₀ = median of mass_kg,      J₀ = ⅓ tr J_C = ⅓ (tr J_O − 2 m₀ |c|²)

tr J_O: sum of the medians of the moments about the reference point, which no rotation changes; c: the median centre of mass. The
median of a fixed number is the number. `choice: [a, b]` with equal weights has every number from a to b as a median: (a + b)/2
counts.
"""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from typing import Any, NamedTuple

from rvjax.campaign.declarations import declared
from rvjax.campaign.fields import Model, validate
from rvjax.campaign.model import Pursuer, Spec
from rvjax.campaign.plain_values import is_mapping
from rvjax.campaign.reference_body import REFERENCE, Follows, rounded
from rvjax.campaign.source import Source


class NominalBody(NamedTuple):
    """m₀ [kg] and J₀ [kg·m²]."""

    mass: float
    inertia: float

    @classmethod
    def of(cls, pursuer: Pursuer) -> NominalBody:
        """The nominal body of a pursuer."""
        (mass,), centre = pursuer.mass_kg.medians, pursuer.centre_of_mass_m.medians
        about_reference = sum(pursuer.inertia_kgm2.entries[0].medians)
        trace = about_reference - 2.0 * mass * sum(part * part for part in centre)
        return cls(rounded(mass), rounded((trace if trace > 0.0 else about_reference) / 3.0))

    @classmethod
    def of_campaign(cls, spec: Spec | None, source: Source) -> NominalBody:
        """The nominal body of a campaign, even if other parts of it are wrong; REFERENCE if its pursuer is wrong, such as by a
        mass from a CSV file that cannot be read."""
        if spec is not None:
            return cls.of(spec.pursuer)
        raw = (source.value or {}).get("pursuer")
        pursuer, _ = validate(Pursuer, raw, ("pursuer",), source) if is_mapping(raw) else (None, [])
        body = cls(**REFERENCE) if pursuer is None else cls.of(pursuer)
        return body if body.mass > 0.0 and body.inertia > 0.0 else cls(**REFERENCE)

    def scale(self, follows: Follows) -> float:
        """m₀ or J₀ as a multiple of REFERENCE."""
        return rounded(getattr(self, follows) / REFERENCE[follows])

    def complete(self, model: type[Model], raw: Mapping[str, Any]) -> dict[str, Any]:
        """The values of a component as written, with the defaults that follow this body where nothing is written."""
        values = dict(raw)
        for key, info in model.keys().items():
            about, inner = declared(info), info.annotation
            if about is not None and about.follows is not None and key not in raw:
                values[key] = rounded(info.default * self.scale(about.follows))
            elif inspect.isclass(inner) and issubclass(inner, Model) and is_mapping(below := raw.get(key, info.default)):
                full = self.complete(inner, below)
                values |= {key: full} if full != below else {}
        return values
