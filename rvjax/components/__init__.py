"""Components: the plug-in families. A family is a package; each member is a file and a line in the family's `MEMBERS`.

What a component of a user is written with:

    Controller, DiscreteController     a control law; Command, Measured: what it gives and gets
    Fault, FaultParameters             what the actuators give while it acts
    Actuator                           what the actuators give for a command; Clock: what it gets
    Effect                             what moves in the pursuer; Body: what it gets
    Disturbance                        a force and a torque; Wrench, Scene: what it gives and gets
    NavigationError                    the measured motion; Motion: what it gives and gets
    Guidance, GuidanceParameters       the point that the controller follows; Course, Approach: what it gives and gets
    Metric                             a value of every flight; Instant: what it gets
    Saturation                         how a command is limited
    Allocation                         how a wrench becomes thrusts; Thrusters: what it gets
    Signal                             unit and meaning of a value
    Parameters                         the model of a component's numbers, with the fields
    rotation_matrix                    R(σ) from the target's frame to the pursuer's
    scalar, vector, channels           numbers that may be drawn; number, count, flag, option: the same in every sample

docs/extending.md shows each. Importing this package does nothing else: the names are imported on first use.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rvjax.campaign.fields import Model as Parameters
    from rvjax.campaign.fields import channels, count, flag, number, option, scalar, vector
    from rvjax.components.forms.actuator import Actuator, Clock
    from rvjax.components.forms.allocation import Allocation, Thrusters
    from rvjax.components.forms.arrays import rotation_matrix
    from rvjax.components.forms.called import Wrench
    from rvjax.components.forms.controller import Command, Controller
    from rvjax.components.forms.discrete_controller import DiscreteController
    from rvjax.components.forms.disturbance import Disturbance, Scene
    from rvjax.components.forms.effect import Body, Effect
    from rvjax.components.forms.fault import Fault, FaultParameters
    from rvjax.components.forms.guidance import Approach, Course, Guidance
    from rvjax.components.forms.measured import Measured
    from rvjax.components.forms.metric import Instant, Metric
    from rvjax.components.forms.navigation import Motion, NavigationError
    from rvjax.components.forms.saturation import Saturation
    from rvjax.components.forms.signal import Signal
    from rvjax.components.guidance.interface import GuidanceParameters

__all__ = [
    "Actuator",
    "Allocation",
    "Approach",
    "Body",
    "Clock",
    "Command",
    "Controller",
    "Course",
    "DiscreteController",
    "Disturbance",
    "Effect",
    "Fault",
    "FaultParameters",
    "Guidance",
    "GuidanceParameters",
    "Instant",
    "Measured",
    "Metric",
    "Motion",
    "NavigationError",
    "Parameters",
    "Saturation",
    "Scene",
    "Signal",
    "Thrusters",
    "Wrench",
    "channels",
    "count",
    "flag",
    "number",
    "option",
    "rotation_matrix",
    "scalar",
    "vector",
]

_FIELDS, _FORMS = "rvjax.campaign.fields", "rvjax.components.forms"
_ORIGIN = {
    "Actuator": f"{_FORMS}.actuator",
    "Allocation": f"{_FORMS}.allocation",
    "Approach": f"{_FORMS}.guidance",
    "Body": f"{_FORMS}.effect",
    "Clock": f"{_FORMS}.actuator",
    "Command": f"{_FORMS}.controller",
    "Controller": f"{_FORMS}.controller",
    "Course": f"{_FORMS}.guidance",
    "DiscreteController": f"{_FORMS}.discrete_controller",
    "Disturbance": f"{_FORMS}.disturbance",
    "Effect": f"{_FORMS}.effect",
    "Fault": f"{_FORMS}.fault",
    "FaultParameters": "rvjax.components.faults.interface",
    "Guidance": f"{_FORMS}.guidance",
    "GuidanceParameters": "rvjax.components.guidance.interface",
    "Instant": f"{_FORMS}.metric",
    "Measured": f"{_FORMS}.measured",
    "Metric": f"{_FORMS}.metric",
    "Motion": f"{_FORMS}.navigation",
    "NavigationError": f"{_FORMS}.navigation",
    "Parameters": f"{_FIELDS}:Model",
    "Saturation": f"{_FORMS}.saturation",
    "Scene": f"{_FORMS}.disturbance",
    "Signal": f"{_FORMS}.signal",
    "Thrusters": f"{_FORMS}.allocation",
    "rotation_matrix": f"{_FORMS}.arrays",
    "Wrench": f"{_FORMS}.called",
} | dict.fromkeys(("channels", "count", "flag", "number", "option", "scalar", "vector"), _FIELDS)
"""Public name → module, and the attribute where it has another name."""


def __getattr__(name: str) -> Any:
    """Public names are imported on first use."""
    if name not in _ORIGIN:
        raise AttributeError(f"module 'rvjax.components' has no attribute {name!r}")
    module, _, attribute = _ORIGIN[name].partition(":")
    return getattr(import_module(module), attribute or name)


def __dir__() -> list[str]:
    return __all__
