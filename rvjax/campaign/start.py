"""The start of the pursuer, in two forms: relative motion in the pursuer's frame, or motion in a frame by its name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, ValidationInfo, field_validator

from rvjax.campaign.fields import Model, attitude, option, vector
from rvjax.campaign.plain_values import is_mapping
from rvjax.campaign.problems import Problem, refuse
from rvjax.campaign.quantity import Quantity

Frame = Literal["port", "lvlh", "pursuer"]
Rest = Literal["port", "lvlh", "inertial"]

REST: Mapping[str, Rest] = {"port": "port", "lvlh": "lvlh", "pursuer": "port"}
"""Frame → what rest means in it where the campaign does not say."""


class Start(Model):
    """Relative motion at t = 0, in the pursuer's frame. omega_deg_s instead of omega_rad_s gives degrees per second."""

    OTHER_UNITS: ClassVar[Mapping[str, str]] = {"omega_deg_s": "omega_rad_s"}

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = ({"rho_m": [10, -5, 3]},)

    rho_m: Quantity = vector("m", doc="position of the pursuer relative to the docking point")
    sigma: Quantity = attitude(
        default=0.0, doc="attitude of the pursuer relative to the target: MRP, quaternion or yaw_pitch_roll_deg"
    )
    nu_m_s: Quantity = vector("m/s", default=0.0, doc="relative velocity")
    omega_rad_s: Quantity = vector("rad/s", default=0.0, doc="relative angular velocity")

    @classmethod
    def _instead(cls, key: str) -> str:
        return _both_forms() if key in _keys(FramedStart) else super()._instead(key)


class FramedStart(Model):
    """Motion at t = 0 in a frame by its name. rate_rad_s instead of rate_deg_s gives radians. See `rvjax explain frames`."""

    OTHER_UNITS: ClassVar[Mapping[str, str]] = {"rate_rad_s": "rate_deg_s"}

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = (
        {"frame": "port", "position_m": [20, 0, 0], "velocity_m_s": [-0.05, 0, 0]},
        {"frame": "lvlh", "position_m": [-100, 0, 0], "relative_to": "lvlh"},
    )

    frame: Frame = option(doc="frame of the position and of the axes of the velocity; without this key: rho_m, sigma, …")
    position_m: Quantity = vector(
        "m", doc="position in the frame; its origin is the docking point, of lvlh the target's centre of mass"
    )
    velocity_m_s: Quantity = vector(
        "m/s", default=0.0, doc="velocity relative to the frame that relative_to names, along the axes of frame"
    )
    attitude_mrp: Quantity = attitude(
        default=0.0,
        doc="attitude of the pursuer relative to the axes of lvlh, else to the target: MRP, quaternion or yaw_pitch_roll_deg",
    )
    rate_rad_s: Quantity = vector(
        "rad/s",
        key="rate_deg_s",
        default=0.0,
        doc="angular velocity relative to the frame that relative_to names, along the pursuer's axes",
    )
    relative_to: Rest | None = option(
        default=None,
        doc="what velocity 0 and rate 0 mean: at rest relative to the port, at rest in LVLH, or with the velocity of the "
        "target and not turning (inertial); default: the frame, with frame pursuer port",
    )

    @classmethod
    def _instead(cls, key: str) -> str:
        return _both_forms() if key in _keys(Start) else super()._instead(key)

    @field_validator("relative_to")
    @classmethod
    def _of_the_frame(cls, given: Rest | None, info: ValidationInfo) -> Rest | None:
        """The default, so that a start is the same whether it is written or not."""
        return REST[info.data["frame"]] if given is None and "frame" in info.data else given

    @property
    def rest(self) -> Rest:
        """What velocity 0 and rate 0 mean."""
        assert self.relative_to is not None, "the validator fills it"
        return self.relative_to

    def check(self, orbit: bool, docking_axis: bool) -> None:
        """Refuses a frame that the target does not have. orbit: the campaign states its orbit; docking_axis: it has one."""
        words = {"frame": self.frame, "relative_to": self.rest}
        if (missing := [key for key, word in words.items() if word == "lvlh"]) and not orbit:
            message = f"{missing[0]} is lvlh, but the campaign states no target.orbit"
            accepted = "accepted: a target.orbit, such as {semi_major_axis_km: 6878, eccentricity: 0}, or another frame"
            refuse(Problem(message, accepted, (missing[0],)))
        if self.frame == "port" and not docking_axis:
            message = "frame is port, but the target has neither port_m nor port_axis"
            refuse(
                Problem(message, "accepted: target.port_m, such as [5, 0, 0], or target.port_axis, or another frame", ("frame",))
            )


AnyStart = Start | FramedStart


def _keys(form: type[Model]) -> list[str]:
    """The keys of a form, in every unit."""
    return [*form.keys(), *form.OTHER_UNITS]


def _both_forms() -> str:
    framed = [key for key in _keys(FramedStart) if key != "frame"]
    return f"accepted: either {', '.join(_keys(Start))}; or frame with {', '.join(framed)}"


def _form(raw: Any, info: ValidationInfo) -> Any:
    """Reads motion in a frame if there is the key `frame`, or only keys that need it; else relative motion."""
    if isinstance(raw, Model):
        return raw
    framed = is_mapping(raw) and ("frame" in raw or (raw.keys() & _keys(FramedStart) and not raw.keys() & _keys(Start)))
    return (FramedStart if framed else Start).model_validate(raw, context=info.context)


StartOfEitherForm = Annotated[AnyStart, BeforeValidator(_form)]
