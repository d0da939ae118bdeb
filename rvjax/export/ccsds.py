"""Inertial motion as CCSDS text: Orbit Ephemeris Message 2.0 (502.0-B-2) and Attitude Ephemeris Message 2.0 (504.0-B-2), KVN.

A message is of a single object. Positions in km, velocities in km/s, angular rates in deg/s. The quaternion Q1 Q2 Q3 QC takes the
axes of REF_FRAME_A to those of REF_FRAME_B: (Q1, Q2, Q3) = e sin(φ/2), QC = cos(φ/2).
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

import numpy as np

from rvjax.analysis.trace_frames import quaternions
from rvjax.errors import UsageError
from rvjax.export.exported import Numbers
from rvjax.export.inertial import Body

J2000 = datetime(2000, 1, 1, 12)
FRAME = "EME2000"
_WIDE = 200
"""Letters of a comment; a line has at most 254."""


@dataclass(frozen=True)
class Epoch:
    """The instant t = 0. system: TIME_SYSTEM."""

    start: datetime
    system: str
    comment: str

    @classmethod
    def of(cls, text: str | None) -> Epoch:
        """ISO 8601 in UTC; None: J2000. UsageError where it is no such text."""
        if text is None:
            return cls(J2000, "TT", "The campaign has no date: t = 0 is J2000.0 (2000-01-01T12:00:00 TT).")
        try:
            start = datetime.fromisoformat(text)
        except ValueError:
            raise UsageError(f"--epoch {text}: no date; accepted: an instant in UTC, such as 2030-05-01T12:00:00") from None
        if start.tzinfo is not None:
            start = start.astimezone(UTC).replace(tzinfo=None)
        if start.year >= 9999:
            raise UsageError(f"--epoch {text}: too late; accepted: a year before 9999")
        return cls(start, "UTC", "t = 0 is the START_TIME, as given when the file was written.")

    def at(self, t: float) -> str:
        """The instant t seconds later, to the nanosecond. Leap seconds are not counted."""
        nanoseconds = round(t * 1e9) + 1000 * self.start.microsecond
        whole, rest = divmod(nanoseconds, 1_000_000_000)
        instant = self.start.replace(microsecond=0) + timedelta(seconds=whole)
        return f"{instant.isoformat()}.{rest:09d}"


@dataclass(frozen=True)
class Message:
    """What the messages of a flight have in common. objects: name of an object by body; comments: of the header."""

    epoch: Epoch
    objects: Mapping[str, str]
    comments: Sequence[str]
    created: datetime

    def oem(self, body: str, t: Numbers, motion: Body) -> str:
        """The Orbit Ephemeris Message of a body."""
        meta = {"CENTER_NAME": "EARTH", "REF_FRAME": FRAME, **self._times(t)}
        numbers = np.concatenate([motion.position, motion.velocity], axis=1) / 1000.0
        rows = [[f"{x:.12f}" for x in row[:3]] + [f"{x:.15f}" for x in row[3:]] for row in numbers]
        return "\n".join([*self._head("OEM", body, meta), "", *self._lines(t, rows), ""])

    def aem(self, body: str, t: Numbers, motion: Body) -> str:
        """The Attitude Ephemeris Message of a body, with its inertial rate in its frame."""
        frames = {"CENTER_NAME": "EARTH", "REF_FRAME_A": FRAME, "REF_FRAME_B": "SC_BODY_1"}
        meta = frames | self._times(t) | {"ATTITUDE_TYPE": "QUATERNION/ANGVEL", "ANGVEL_FRAME": "SC_BODY_1"}
        numbers = np.concatenate([quaternions(motion.attitude), np.degrees(motion.rate)], axis=1)
        rows = [[f"{x:.16f}" for x in row] for row in numbers]
        return "\n".join([*self._head("AEM", body, meta), "", "DATA_START", *self._lines(t, rows), "DATA_STOP", ""])

    def _times(self, t: Numbers) -> dict[str, str]:
        return {
            "TIME_SYSTEM": self.epoch.system,
            "START_TIME": self.epoch.at(float(t[0])),
            "STOP_TIME": self.epoch.at(float(t[-1])),
        }

    def _head(self, kind: str, body: str, meta: Mapping[str, str]) -> list[str]:
        comments = [f"COMMENT {line}" for text in self.comments for line in textwrap.wrap(_plain(text), _WIDE)]
        name = _plain(self.objects[body])
        lines = [f"{key} = {value}" for key, value in {"OBJECT_NAME": name, "OBJECT_ID": name, **meta}.items()]
        created = self.created.strftime("%Y-%m-%dT%H:%M:%S")
        head = [f"CCSDS_{kind}_VERS = 2.0", *comments, f"CREATION_DATE = {created}", "ORIGINATOR = RVJAX", ""]
        return [*head, "META_START", *lines, "META_STOP"]

    def _lines(self, t: Numbers, rows: Sequence[Sequence[str]]) -> list[str]:
        return [" ".join([self.epoch.at(float(instant)), *row]) for instant, row in zip(t, rows, strict=True)]


def _plain(text: str) -> str:
    """Printable ASCII, which is all that a message may contain."""
    return re.sub(r"[^\x20-\x7e]", "?", text)
