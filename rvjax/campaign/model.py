"""The campaign file: a frozen and validated value in SI."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self, cast

from pydantic import PrivateAttr, ValidationInfo, field_validator, model_validator

from rvjax.campaign import named_laws
from rvjax.campaign.actuators import AnyActuators, Thrusters
from rvjax.campaign.attachments import attach
from rvjax.campaign.choice import NAME, NAME_WORDS, Choice, ListOfChoices, OneChoice
from rvjax.campaign.correlation import Correlation
from rvjax.campaign.fields import Model, attitude, count, number, option, part, scalar, validate, vector
from rvjax.campaign.formula import Formula, Margins
from rvjax.campaign.horizon import Horizon
from rvjax.campaign.hulls import Hull, KeepOut
from rvjax.campaign.inertia import Inertia, check_centre
from rvjax.campaign.overrides import override, replace_values
from rvjax.campaign.plain_values import Place, exact
from rvjax.campaign.problems import Problem, refuse, unexpected
from rvjax.campaign.propellant import Propellant, check_propellant
from rvjax.campaign.python_files import PythonFile
from rvjax.campaign.quantity import Quantity
from rvjax.campaign.requirement import Requirement, repeated_ids
from rvjax.campaign.source import Source, read
from rvjax.campaign.start import AnyStart, FramedStart, StartOfEitherForm
from rvjax.campaign.trace_retention import Keep
from rvjax.campaign.triples import MaybeDirection
from rvjax.campaign.tuning import Tuning
from rvjax.errors import CampaignError, Finding

EARTH_RADIUS_M = 6378e3


class Orbit(Model):
    """Kepler elements of the target in the perifocal frame, at t = 0."""

    eccentricity: Quantity = scalar("1", default=0.0, at_least=0.0, below=1.0, doc="eccentricity")
    semi_major_axis_m: Quantity = scalar("m", key="semi_major_axis_km", default=6878.0, above=0.0, doc="semi-major axis")
    true_anomaly_rad: Quantity = scalar("rad", key="true_anomaly_deg", default=0.0, doc="true anomaly at t = 0")

    @field_validator("semi_major_axis_m")
    @classmethod
    def _above_ground(cls, axis: Quantity, info: ValidationInfo) -> Quantity:
        if "eccentricity" in info.data:
            ((lowest, _),), ((_, most),) = axis.supports, info.data["eccentricity"].supports
            if lowest * (1.0 - most) <= EARTH_RADIUS_M:
                message = f"the perigee can be as low as {exact(lowest * (1.0 - most) / 1e3)} km"
                refuse(Problem(message, f"accepted: above {exact(EARTH_RADIUS_M / 1e3)} km from the centre, in every draw"))
        return axis


class Target(Model):
    """The body to dock with: its orbit, its tumbling, its docking port. rate_rad_s instead of rate_deg_s gives radians."""

    orbit: Orbit = part(default={}, doc="orbit of the target")
    OTHER_UNITS: ClassVar[Mapping[str, str]] = {"rate_rad_s": "rate_deg_s"}

    attitude_mrp: Quantity = attitude(
        default=0.0, doc="attitude of the target in the perifocal frame at t = 0: MRP, quaternion or yaw_pitch_roll_deg"
    )
    rate_rad_s: Quantity = vector("rad/s", key="rate_deg_s", default=0.0, doc="inertial rate of the target in its frame at t = 0")
    port_m: Quantity = vector("m", default=0.0, doc="docking point in the target's frame")
    port_axis: MaybeDirection = option(
        default=None,
        doc="direction of the docking axis, outward, in the target's frame, of any length but 0; default: that of port_m",
    )
    inertia_kgm2: Inertia = part(default={"principal": [500, 550, 600]}, doc="inertia of the target")
    hull: Hull | None = part(default=None, doc="hull of the target; with pursuer.hull a contact is the outcome `collided`")
    keep_out: KeepOut | None = part(default=None, doc="zone about the target that is entered through the corridor only")

    @property
    def has_docking_axis(self) -> bool:
        """Whether its docking axis is given, or the docking point is not its origin in every sample."""
        return self.port_axis is not None or self.port_m.largest_norm > 0.0


class Pursuer(Model):
    """The body that docks, at t = 0 and with all its propellant. Its controller does not know these numbers."""

    EXAMPLES: ClassVar[tuple[Mapping[str, Any], ...]] = ({"mass_kg": 100, "inertia_kgm2": {"principal": [22, 20, 23]}},)

    mass_kg: Quantity = scalar("kg", above=0.0, doc="mass of the pursuer")
    inertia_kgm2: Inertia = part(doc="inertia of the pursuer about its reference point")
    centre_of_mass_m: Quantity = vector("m", default=0.0, doc="centre of mass, from the reference point, in the pursuer's frame")
    propellant: Propellant | None = part(
        default=None,
        example={"mass_kg": 8, "specific_impulse_s": 220},
        doc="propellant that the actuators burn; without it the mass does not change",
    )
    hull: Hull | None = part(default=None, doc="hull of the pursuer, from its reference point")

    @field_validator("centre_of_mass_m")
    @classmethod
    def _inside_the_body(cls, centre: Quantity, info: ValidationInfo) -> Quantity:
        if {"mass_kg", "inertia_kgm2"} <= info.data.keys():
            check_centre(info.data["inertia_kgm2"], info.data["mass_kg"], centre)
        return centre

    @field_validator("propellant")
    @classmethod
    def _inside_the_mass(cls, propellant: Propellant | None, info: ValidationInfo) -> Propellant | None:
        body = info.data
        if propellant is not None and {"mass_kg", "inertia_kgm2", "centre_of_mass_m"} <= body.keys():
            check_propellant(body["inertia_kgm2"], body["mass_kg"], body["centre_of_mass_m"], propellant)
        return propellant


class Capture(Model):
    """A sample is captured if it stays inside both tubes during the whole closing window."""

    position_m: float = number("m", default=0.01, above=0.0, doc="radius of the position tube")
    attitude_mrp: float = number("1", default=0.002, above=0.0, doc="radius of the attitude tube")
    window_s: float = number("s", default=60.0, above=0.0, doc="length of the closing window")


class Corridor(Model):
    """Approach cone about the docking axis. At the docking point its radius is radius_m."""

    half_angle_rad: float = number("rad", key="half_angle_deg", default=10.0, above=0.0, below=90.0, doc="half angle of the cone")
    radius_m: float = number("m", default=0.0, at_least=0.0, doc="radius at the docking point")
    length_m: float | None = number("m", default=None, above=0.0, doc="largest distance from the docking point; null: no limit")

    @property
    def is_funnel(self) -> bool:
        """Whether its apex is not the docking point, or it ends."""
        return self.radius_m > 0.0 or self.length_m is not None


class AuditRules(Model):
    """Exceptions to the audit."""

    allow: tuple[str, ...] = option(
        default=[],
        example=["pursuer.mass_kg"],
        doc="draws and fixed inputs that may have no effect: names or beginnings of names",
    )


class Spec(Model):
    """A campaign: the flights, their start, their dispersions, and what is required of them."""

    rvjax: Literal[1] = option(doc="version of this format")
    name: str = option(example="docking-study", doc="name of the campaign: small letters, digits and hyphens")
    description: str = option(default="", example="Docking with one weak thruster.", doc="free text, shown in the report")
    samples: int = count(at_least=1, at_most=1_000_000_000, example=1000, doc="number of flights")
    seed: int = count(default=0, doc="seed of every draw")
    precision: Literal["float64", "float32"] = option(default="float64", doc="floating-point precision of the flights")
    engine: Literal["auto", "llvm", "xla"] = option(
        default="auto", doc="what turns a flight into machine code; auto: llvm on a CPU if it knows every operation, else xla"
    )
    horizon: Horizon = part(doc="duration and step")
    target: Target = part(default={}, doc="the body to dock with")
    pursuer: Pursuer = part(doc="the body that docks")
    start: StartOfEitherForm = part(doc="motion of the pursuer at t = 0, relative to the docking point or in a frame")
    actuators: AnyActuators = part(doc="limits of the six channels, or thrusters")
    saturation: Annotated[Choice, OneChoice()] = part(
        default={"use": "smooth-tanh"}, doc="how commands are limited to what the actuators can give"
    )
    disturbances: Annotated[tuple[Choice, ...], ListOfChoices()] = part(
        default=[],
        example=[{"use": "constant", "force_N": [0.01, 0, 0]}],
        doc="forces and torques that do not come from the actuators",
    )
    effects: Annotated[tuple[Choice, ...], ListOfChoices()] = part(
        default=[],
        example=[{"use": "flexible-appendage", "modal_mass_kg": 5, "frequency_Hz": 0.3, "place_m": [1, 0, 0]}],
        doc="what moves in or on the pursuer: propellant, appendages",
    )
    actuation: Annotated[tuple[Choice, ...], ListOfChoices()] = part(
        default=[],
        example=[{"use": "first-order-lag", "time_constant_s": 0.2}],
        doc="how the actuators follow what is commanded, one after the other",
    )
    faults: Annotated[tuple[Choice, ...], ListOfChoices()] = part(
        default=[], example=[{"use": "effectiveness", "onset_s": 60, "remaining": 0.5}], doc="faults of the actuators"
    )
    navigation: Annotated[tuple[Choice, ...], ListOfChoices()] = part(
        default=[],
        example=[{"use": "noise", "position_m": 0.01}],
        doc="errors between the true motion and what the controller sees",
    )
    guidance: Annotated[Choice, OneChoice()] = part(
        default={"use": "direct"},
        example={"use": "corridor", "gate_m": 8},
        doc="where the controller shall be at an instant: the point that it regulates to",
    )
    controller: Annotated[Choice, OneChoice()] = part(example={"use": "pd-plus"}, doc="the controller under test")
    baselines: Annotated[tuple[Choice, ...], ListOfChoices()] = part(
        default=[], example=[{"use": "pd-plus", "name": "plain"}], doc="controllers that fly the same draws, for comparison"
    )
    metrics: Annotated[tuple[Choice, ...], ListOfChoices()] = part(
        default=[],
        example=[{"use": "keep-out", "radius_m": 2}],
        doc="metrics with parameters, besides those of every campaign",
    )
    sampler: Annotated[Choice, OneChoice()] = part(default={"use": "monte-carlo"}, doc="how the samples are drawn")
    correlate: tuple[Correlation, ...] = part(default=[], doc="draws that are not independent")
    epistemic: tuple[str, ...] = option(
        default=(),
        example=["pursuer.mass_kg"],
        doc="epistemic draws, which are unknown but not random: their names, or the beginning of their names",
    )
    capture: Capture = part(default={}, doc="when a sample counts as captured")
    corridor: Corridor = part(default={}, doc="approach cone")
    margins: Annotated[Mapping[str, Formula], Margins()] = part(
        default={},
        example={"speed": {"always": {"signal": "closing_speed_m_s", "below": 1.0}}},
        doc="formulas over signals, by name; the margin by which a flight satisfies each becomes the metric margin.<name>",
    )
    laws: Annotated[Mapping[str, named_laws.Values], named_laws.NamedLaws()] = part(
        default={},
        example={"heavy": {"pursuer.mass_kg": {"uniform": [100, 120]}}},
        doc="other laws of some draws, by name: places and the laws there instead; for `under` in require",
    )
    require: tuple[Requirement, ...] = part(default=[], doc="requirements, judged after the flights")
    keep: Keep = part(default={}, doc="flights that are kept as traces")
    audit: AuditRules = part(default={}, doc="check before the first flight that every draw and every fixed input has an effect")

    tune: Tuning | None = part(default=None, doc="what `rvjax tune` searches; it does not affect flights")

    _source: Source = PrivateAttr(default_factory=lambda: Source(""))

    @field_validator("name")
    @classmethod
    def _plain_name(cls, name: str) -> str:
        if not NAME.fullmatch(name):
            refuse(unexpected(name, NAME_WORDS))
        return name

    @field_validator("start")
    @classmethod
    def _in_a_frame_of_the_target(cls, start: AnyStart, info: ValidationInfo) -> AnyStart:
        if isinstance(start, FramedStart) and "target" in info.data:
            target: Target = info.data["target"]
            start.check("orbit" in target.model_fields_set, target.has_docking_axis)
        return start

    @field_validator("baselines")
    @classmethod
    def _other_names(cls, baselines: tuple[Choice, ...], info: ValidationInfo) -> tuple[Choice, ...]:
        if "controller" in info.data:
            taken = info.data["controller"].name
            accepted = "accepted: a name that differs from that of the controller under test"
            same = [index for index, baseline in enumerate(baselines) if baseline.name == taken]
            if same:
                refuse(*(Problem(f"the name {taken} is used twice", accepted, (index, "name")) for index in same))
        return baselines

    @field_validator("require")
    @classmethod
    def _consistent_requirements(cls, require: tuple[Requirement, ...], info: ValidationInfo) -> tuple[Requirement, ...]:
        wrong = [*named_laws.unknown([each.under for each in require], info.data.get("laws")), *repeated_ids(require)]
        return refuse(*wrong) if wrong else require

    @field_validator("capture")
    @classmethod
    def _inside_flight(cls, capture: Capture, info: ValidationInfo) -> Capture:
        if "horizon" in info.data and capture.window_s > info.data["horizon"].duration_s:
            accepted = f"accepted: at most {exact(info.data['horizon'].duration_s)} s"
            refuse(
                Problem(f"the closing window of {exact(capture.window_s)} s is longer than the flight", accepted, ("window_s",))
            )
        return capture

    @field_validator("tune")
    @classmethod
    def _other_seed(cls, tune: Tuning | None, info: ValidationInfo) -> Tuning | None:
        """The confirmation needs draws that the search has not used."""
        if tune is not None and "seed" in info.data:
            fresh = info.data["seed"] if tune.confirm.seed is None else tune.confirm.seed
            if fresh == (info.data["seed"] + 1 if tune.seed is None else tune.seed):
                place = ("confirm", "seed") if tune.confirm.seed is not None else ("seed",)
                refuse(
                    Problem(
                        f"{fresh} is the seed of both the search and its confirmation", "accepted: two different seeds", place
                    )
                )
        return tune

    @model_validator(mode="after")
    def _arm_of_channels(self) -> Self:
        """Thrusters have places, from which their torques follow."""
        propellant = self.pursuer.propellant
        if propellant is not None and propellant.torque_arm_m is not None and isinstance(self.actuators, Thrusters):
            place = ("pursuer", "propellant", "torque_arm_m")
            refuse(Problem("an arm of the torque channels, but thrusters fly", "accepted: no torque_arm_m", place, at_key=True))
        return self

    @property
    def source(self) -> Source:
        """The file that the campaign was read from; equal campaigns may have different sources."""
        return self._source

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Spec) and self.__dict__ == other.__dict__

    @property
    def flying(self) -> tuple[Choice, ...]:
        """Every component whose numbers a flight gets."""
        around = (*self.actuation, *self.faults, *self.disturbances, *self.effects)
        return (self.controller, self.guidance, *around, *self.navigation, *self.metrics)

    @property
    def components(self) -> tuple[Choice, ...]:
        """Every component that is used."""
        allocations = (self.actuators.allocation,) if isinstance(self.actuators, Thrusters) else ()
        return (*self.flying, self.saturation, *allocations, self.sampler)

    def fingerprint(self, parameters: Mapping[Place, Model] | None = None) -> str:
        """SHA-256 of all that determines draws and flights. The order of keys and written defaults do not matter.

        parameters: of the components by `Choice.path`, as read by the components' models; without them, as written.
        """
        ignored = {"name", "description", "samples", "engine", "baselines", "require", "keep", "audit"}
        ignored |= {"correlate", "epistemic", "tune", "laws"}
        parts: dict[str, Any] = {name: getattr(self, name) for name in type(self).model_fields if name not in ignored}
        parts["parameters"] = self._parameters(parameters or {})
        parts["correlate"] = sorted(group.ordered for group in self.correlate)
        parts["epistemic"] = sorted(set(self.epistemic))
        return _digest(parts)

    def structure(self, parameters: Mapping[Place, Model], periods: tuple[int, ...]) -> str:
        """SHA-256 of all that decides which program is compiled: campaigns of the same structure share a compiled program. They
        differ only in numbers and draws. parameters: as in `fingerprint`; periods: in steps, of what acts now and then."""
        names = ("precision", "actuators", "margins")
        parts: dict[str, Any] = {name: getattr(self, name) for name in names}
        parts |= {"shapes": [self.target.hull, self.pursuer.hull, self.target.keep_out, self.corridor.is_funnel]}
        parts |= {"components": [*self.flying, self.saturation]}
        parts |= {"parameters": self._parameters(parameters), "periods": periods, "propellant": self.pursuer.propellant}
        return _digest(parts, numbers=False)

    def _parameters(self, parameters: Mapping[Place, Model]) -> dict[str, Any]:
        """The parameters of every component, by its place."""
        return {".".join(map(str, choice.path)): parameters.get(choice.path, choice.parameters) for choice in self.components}


def _digest(parts: Mapping[str, Any], numbers: bool = True) -> str:
    text = json.dumps(_canonical(parts, numbers), sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def _canonical(value: Any, numbers: bool) -> Any:
    """Plain JSON values: equal numbers look the same, texts for people are left out. numbers: include the numbers of the
    quantities, which are inputs of the compiled program."""
    if isinstance(value, Model):
        return {name: _canonical(getattr(value, name), numbers) for name in type(value).model_fields}
    if isinstance(value, Choice):
        return [value.use, value.name, *([value.use.digest] if isinstance(value.use, PythonFile) else [])]
    if isinstance(value, Quantity):
        return _canonical([value.shape, value.parts, value.joint] if numbers else [value.shape, len(value.parts)], numbers)
    if is_dataclass(value):
        known = [_canonical(getattr(value, field.name), numbers) for field in fields(value) if field.compare]
        return {type(value).__name__: known}
    if isinstance(value, Mapping):
        return {str(key): _canonical(item, numbers) for key, item in cast("Mapping[Any, Any]", value).items()}
    if isinstance(value, (list, tuple)):
        return [_canonical(item, numbers) for item in cast("Sequence[Any]", value)]
    return int(value) if isinstance(value, float) and value.is_integer() else value


def parse(path: str | Path | Source, overrides: Sequence[str] = ()) -> tuple[Spec | None, list[Finding], Source]:
    """(campaign, findings, source) of a campaign file or a source; the campaign is None exactly if there are findings."""
    return _checked(override(path if isinstance(path, Source) else read(path), overrides))


def parse_with(spec: Spec, values: Mapping[str, float | str]) -> tuple[Spec | None, list[Finding], Source]:
    """A campaign with other values at some places: as `parse` with `place=value`, but the file is not read again."""
    return _checked(replace_values(spec.source, values))


def _checked(source: Source) -> tuple[Spec | None, list[Finding], Source]:
    source = attach(source)
    findings = list(source.findings)
    if source.value is None:
        return None, findings, source
    spec, more = validate(Spec, source.value, (), source)
    known = {(finding.where, finding.path) for finding in findings}
    findings += [finding for finding in more if (finding.where, finding.path) not in known]
    if spec is None or findings:
        return None, findings, source
    spec._source = source  # pyright: ignore[reportPrivateUsage]
    return spec, [], source


def load(path: str | Path | Source, overrides: Sequence[str] = ()) -> Spec:
    """The campaign in a file, or in a source that was read before. overrides: `place=value`, as in `--set`.

    CampaignError with every finding.
    """
    spec, findings, _ = parse(path, overrides)
    if spec is None:
        raise CampaignError(findings)
    return spec
