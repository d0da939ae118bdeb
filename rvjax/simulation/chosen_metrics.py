"""The metrics that a campaign chooses, each on its own numbers, besides those of every campaign."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from rvjax.campaign import Model, Source, Spec
from rvjax.campaign.choice import entry_names
from rvjax.campaign.horizon import not_whole
from rvjax.campaign.plain_values import Place
from rvjax.components.metrics.interface import Metric, MetricContext
from rvjax.components.registry import component
from rvjax.errors import Finding
from rvjax.physics.state import Step
from rvjax.physics.vectors import Scalar
from rvjax.simulation.outline import Outline


def with_chosen(
    metrics: tuple[Metric, ...], outline: Outline, parameters: Mapping[Place, Model], spec: Spec | None, source: Source
) -> tuple[tuple[Metric, ...], list[Finding]]:
    """The metrics of every campaign and those that this one chooses. A finding for each column that two of them have, and for
    each period that is not a whole number of steps."""
    entries = [entry for entry in outline.components if entry.section == "metrics"]
    names = entry_names([entry.raw for entry in entries])
    findings: list[Finding] = []
    for index, (entry, name) in enumerate(zip(entries, names, strict=True)):
        if (model := parameters.get(entry.place)) is None:
            continue
        prefix = f"{name.replace('-', '_')}_" if "name" in entry.raw else ""
        metric = _on_its_numbers(component("metrics", entry.raw["use"]).build(model), index, prefix)
        if metric.every_s is not None and spec is not None:
            if wrong := not_whole(metric.every_s, spec.horizon.step_s):
                findings.append(source.finding((*entry.place, "every_s"), wrong.message, wrong.accepted))
            metric = metric._replace(every=max(round(metric.every_s / spec.horizon.step_s), 1))
        taken = {column for known in metrics for column in known.columns}
        if both := sorted(taken & metric.columns.keys()):
            accepted = "accepted: a name with `name:`, which its columns then begin with"
            findings.append(source.finding(entry.place, f"the column {both[0]} is there already", accepted))
        metrics = (*metrics, metric)
    return metrics, findings


def _on_its_numbers(metric: Metric, index: int, prefix: str) -> Metric:
    """The metric on its numbers of the context, with a prefix before the names of its columns."""

    def given(context: MetricContext) -> MetricContext:
        return context._replace(numbers=context.chosen[index])

    def start(context: MetricContext) -> Any:
        return metric.start(given(context))

    def update(acc: Any, step: Step, weight: Scalar, context: MetricContext) -> Any:
        return metric.update(acc, step, weight, given(context))

    def finish(acc: Any, context: MetricContext) -> Mapping[str, Any]:
        return {prefix + name: value for name, value in metric.finish(acc, given(context)).items()}

    columns = {prefix + name: replace(column, name=prefix + name) for name, column in metric.columns.items()}
    return metric._replace(columns=columns, start=start, update=update, finish=finish)
