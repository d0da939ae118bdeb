"""Propellant used and left at the end of the flight, in campaigns with `pursuer.propellant`.

used = min(m_c, m_p),   left = m_p − used          equations: `rvjax explain propellant`
"""

from __future__ import annotations

from collections.abc import Mapping

from rvjax.columns import Column
from rvjax.components.metrics.interface import Metric, MetricContext
from rvjax.physics.state import Step, Tank
from rvjax.physics.vectors import Scalar


def start(context: MetricContext) -> Tank:
    zero = context.duration_s * 0.0
    return Tank(zero, zero)


def update(acc: Tank, step: Step, weight: Scalar, context: MetricContext) -> Tank:
    """What is in the tank at the instant."""
    del weight, context
    return step.tank if isinstance(step.tank, Tank) else acc


def finish(acc: Tank, context: MetricContext) -> Mapping[str, Scalar]:
    del context
    return {"propellant_used_kg": acc.used, "propellant_left_kg": acc.left}


_COLUMNS = (
    Column("propellant_used_kg", "kg", "propellant used in the flight", "lower"),
    Column("propellant_left_kg", "kg", "propellant left at the end of the flight", "higher"),
)
COMPONENT = Metric({column.name: column for column in _COLUMNS}, start, update, finish, needs=("pursuer.propellant",))
