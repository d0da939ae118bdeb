"""Which of a campaign's laws another version of it changes, and whether its flights say anything about the other laws.

A flight depends on its draws, not on their laws. So flights of a campaign are flights of one that differs in the laws of some of
its draws alone, with other weights. Whatever else differs needs flights of its own.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import TYPE_CHECKING, Any, cast

from rvjax.campaign import Model, Quantity
from rvjax.campaign.choice import Choice
from rvjax.campaign.law_words import in_words
from rvjax.campaign.overrides import value_at
from rvjax.campaign.plain_values import Place, dotted, is_list, is_mapping
from rvjax.components.samplers import sampling_design_of
from rvjax.errors import CampaignError, Finding
from rvjax.stats.densities import ratio
from rvjax.stats.other_laws import Change, OtherLaw
from rvjax.stats.reweighting import MOST_BEYOND
from rvjax.stats.sampling_design import Independent

if TYPE_CHECKING:
    from rvjax.simulation.problem import Part, Problem

WITHOUT_EFFECT = {"name", "description", "engine", "baselines", "require", "keep", "audit", "tune", "epistemic", "laws"}
"""Sections that change neither draws nor flights."""


@dataclass(frozen=True)
class Numbers:
    """A quantity of a campaign, and where it stands."""

    quantity: Quantity
    place: Place
    part: Part | None = None


def followers(old: Problem, new: Problem) -> list[str]:
    """`place=value` of the fixed numbers that `new` has other than `old` although its file does not say them, such as the mass
    that a controller assumes: they follow from laws that changed. With these values `new` flies what `old` has flown. Empty where
    more than numbers differs."""
    if _structure_of(old) != _structure_of(new):
        return []
    before, found = numbers_of(old), list[str]()
    for name, now in numbers_of(new).items():
        then = before.get(name)
        if then is None or not (then.quantity.is_fixed and now.quantity.is_fixed) or then.quantity.parts == now.quantity.parts:
            continue
        if not value_at(new.spec.source.value, ".".join(map(str, now.place)))[0]:
            values = [part.low for part in then.quantity.parts]
            found.append(f"{'.'.join(map(str, now.place))}={values[0] if len(values) == 1 else values}")
    return found


def other_law(old: Problem, new: Problem, anchor: Anchor) -> OtherLaw:
    """The laws of `new`, for the samples of `old`. anchor: how findings say where, and what else can be done.

    CampaignError with every finding: whatever differs and is not the law of a draw, and laws without a ratio.
    """
    check = _Check(old, new, anchor)
    findings = [*check.independence(), *check.structure()]
    changes: list[Change] = []
    if not findings:
        for item in check.numbers():
            if isinstance(item, Change):
                changes.append(item)
            else:
                findings.append(item)
    if not findings and not changes:
        findings.append(check.finding((), "no law of a draw changes", "accepted: another law of a draw", instead=False))
    law = OtherLaw(tuple(changes), old.spec.seed)
    if not findings and law.beyond > MOST_BEYOND:
        message = f"{100 * law.beyond:.3g} % of the draws would be where the run has none"
        findings.append(check.finding((), message, f"accepted: at most {100 * MOST_BEYOND:g} %"))
    if findings:
        raise CampaignError(dict.fromkeys(findings))
    return law


@dataclass(frozen=True)
class Anchor:
    """How findings about other laws read. places: by each changed place its `file:line:column` and what stands in front of a
    finding there; instead: what else can be done, behind what is accepted."""

    places: Mapping[str, tuple[str, str]]
    instead: str

    def finding(self, place: Place, message: str, accepted: str, instead: bool = True) -> Finding:
        """A finding at the changed place that is most like a place of the campaign."""
        wanted = dotted(place).split(".")

        def alike(item: str) -> int:
            return sum(a == b for a, b in zip(item.split("."), wanted, strict=False))

        nearest = max(self.places, key=alike)
        where, label = self.places[nearest]
        ending = f"{accepted}; {self.instead}" if instead and self.instead else accepted
        return Finding(where, dotted(place) or nearest, f"{label}: {message}", ending)


class _Check:
    def __init__(self, old: Problem, new: Problem, anchor: Anchor) -> None:
        self.old, self.new, self.finding = old, new, anchor.finding

    def independence(self) -> Iterator[Finding]:
        """A finding if the samples are no independent draws of the old laws."""
        if not isinstance(sampling_design_of(self.old.spec), Independent):
            message = f"samples of {self.old.spec.sampler.use} are not independent"
            found = self.finding(("sampler",), message, "accepted: a run with sampler: {use: monte-carlo}")
            yield replace(found, where=self.old.spec.source.where(("sampler",), key=True))

    def structure(self) -> Iterator[Finding]:
        """A finding for each section that differs in more than the numbers of its quantities."""
        before, after = _structure_of(self.old), _structure_of(self.new)
        for place in dict.fromkeys([*before, *after]):
            if before.get(place) != after.get(place):
                name = ".".join(map(str, place))
                message = f"{name} differs from the run in more than the law of a draw"
                yield self.finding(place, message, "accepted: another law of a draw")

    def numbers(self) -> Iterator[Change | Finding]:
        """The changed laws, or what keeps them from being used."""
        before, after = numbers_of(self.old), numbers_of(self.new)
        for name, new in after.items():
            old = before[name]
            if old.quantity.joint is not None or new.quantity.joint is not None:
                if old.quantity.joint != new.quantity.joint or old.quantity.parts != new.quantity.parts:
                    if old.quantity.joint is None or new.quantity.joint is None:
                        message = f"{name} is drawn jointly in one of the two only"
                        yield self.finding(new.place, message, "accepted: two joint laws, or two laws of each component")
                    else:
                        yield self._change(name, old.quantity.names(name), old.quantity.joint, new.quantity.joint, new)
                continue
            for component, a, b in zip(old.quantity.names(name), old.quantity.parts, new.quantity.parts, strict=True):
                if a != b:
                    yield self._component(component, a, b, new)

    def _component(self, name: str, old: Any, new: Any, where: Numbers) -> Change | Finding:
        if not old.uniforms:
            noise = where.part is not None and where.part.noisy
            what = "is the size of noise in flight" if noise else "was fixed in the run"
            return self.finding(where.place, f"{name} {what}, so no flight has another value", "accepted: draws of the run")
        if not new.uniforms:
            return self.finding(where.place, f"{name} would be fixed", "accepted: a law with a density, such as a narrow uniform")
        return self._change(name, (name,), old, new, where)

    def _change(self, name: str, draws: tuple[str, ...], old: Any, new: Any, where: Numbers) -> Change | Finding:
        if (obstacle := hindrance(self.old, name, draws, where)) is not None:
            return self.finding(where.place, f"{name} {obstacle[0]}", obstacle[1])
        try:
            found = ratio(old, new)
        except TypeError as error:
            message = f"{name}: {in_words(old)} and {in_words(new)}: {error}"
            return self.finding(where.place, message, "accepted: two laws with a density")
        return Change(draws, old, new, found.log_sup, found.beyond)


def hindrance(problem: Problem, name: str, draws: tuple[str, ...], numbers: Numbers) -> tuple[str, str] | None:
    """Why samples say nothing about another law of a variable, and what is accepted; None where they do. draws: its numbers."""
    dispersions = problem.dispersions
    if any(name in group.names for group in dispersions.groups):
        return "is correlated with others", "accepted: draws outside of correlate"
    if any(set(draws) & retry.draws for retry in dispersions.retries):
        message = "is redrawn if a body is unphysical (reject), and the accepted share of the new law is unknown"
        return message, "accepted: draws that are not redrawn"
    if numbers.part is not None and numbers.part.schedule is not None:
        message = "belongs to a fault with a schedule, whose table has only the onsets that take place"
        return message, "accepted: draws of faults without a schedule"
    return None


def numbers_of(problem: Problem) -> dict[str, Numbers]:
    """Every quantity by its name."""
    found = {name: Numbers(quantity, tuple(name.split("."))) for name, quantity in problem.spec.quantities().items()}
    for part in problem.parts:
        assert part.parameters is not None
        for name, quantity in part.parameters.quantities(part.prefix).items():
            below = name.removeprefix(f"{part.prefix}.").split(".")
            found[name] = Numbers(part.quantities.get(".".join(below), quantity), (*part.place, *below), part)
    return found


def _structure_of(problem: Problem) -> dict[Place, Any]:
    """All that is no number of a quantity, by section, and by place of each component."""
    spec = problem.spec
    found: dict[Place, Any] = {
        (name,): _without_numbers(getattr(spec, name)) for name in type(spec).model_fields if name not in WITHOUT_EFFECT
    }
    return found | {part.place: _without_numbers(part.parameters) for part in problem.parts}


def _without_numbers(value: Any) -> Any:
    """A value in which only the shapes of quantities are left."""
    if isinstance(value, Quantity):
        return ["quantity", value.shape]
    if isinstance(value, Choice):
        return ["choice", str(value.use), value.name]
    if isinstance(value, Model):
        return {name: _without_numbers(getattr(value, name)) for name in type(value).model_fields}
    if is_dataclass(value) and not isinstance(value, type):
        return {field.name: _without_numbers(getattr(value, field.name)) for field in fields(value)}
    if is_mapping(value):
        return {str(key): _without_numbers(item) for key, item in cast("Mapping[Any, Any]", value).items()}
    if is_list(value) or isinstance(value, tuple):
        return [_without_numbers(item) for item in cast("list[Any]", value)]
    return value
