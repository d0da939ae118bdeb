"""A trace for viewers of robots: Rerun (.rrd) and MCAP (.mcap, Foxglove), which are packages of extras.

The pursuer is drawn in the frame T of the target, since viewers compute in single precision: at δ + Rᵀρ, with the quaternion of
T → P. Every column of the trace is a signal over time, with its unit.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from rvjax.analysis.trace_frames import quaternions, rotation
from rvjax.export.exported import Exported, Numbers


def poses(trace: Exported, port: Numbers) -> tuple[Numbers, Numbers]:
    """δ + Rᵀρ, (rows, 3), and the quaternion x, y, z, w of T → P, (rows, 4)."""
    relative = rotation(trace.vector("sigma_{}"))
    return port + np.einsum("tij,ti->tj", relative, trace.vector("rho_{}_m")), quaternions(relative)


def write_rerun(path: Path, trace: Exported, port: Numbers) -> None:
    """Writes a recording of Rerun. Needs the package rerun-sdk."""
    import rerun as rr  # pyright: ignore[reportMissingImports]

    places, turns = poses(trace, port)
    recording = rr.RecordingStream("rvjax")
    recording.save(path)
    index = [rr.TimeColumn("flight", duration=trace.frame["t_s"].to_numpy(dtype=float))]
    recording.log("target", rr.TransformAxes3D(1.0) if hasattr(rr, "TransformAxes3D") else rr.Transform3D(), static=True)
    recording.log("target/port", rr.Points3D([port], radii=0.1), static=True)
    recording.log("target/trail", rr.LineStrips3D([places]), static=True)
    recording.send_columns("target/pursuer", index, rr.Transform3D.columns(translation=places, quaternion=turns))
    for name in _signals(trace):
        column, place = trace.columns.get(name), f"signals/{name}"
        words = name if column is None else f"{name} [{column.unit}]: {column.description}"
        recording.log(place, rr.SeriesLines(names=words), static=True)
        recording.send_columns(place, index, rr.Scalars.columns(scalars=trace.frame[name].to_numpy(dtype=float)))
    recording.flush()


def write_mcap(path: Path, trace: Exported, port: Numbers) -> None:
    """Writes an MCAP file with JSON messages: /pose (foxglove.FrameTransform) and /trace, a number for each column. Needs the
    package mcap."""
    from mcap.writer import Writer  # pyright: ignore[reportMissingImports]

    places, turns = poses(trace, port)
    names = _signals(trace)
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="", library="rvjax")
        transform = _channel(writer, "/pose", "foxglove.FrameTransform", _TRANSFORM)
        properties: dict[str, Any] = {}
        for name in names:
            column = trace.columns.get(name)
            said = {} if column is None else {"unit": column.unit, "description": f"{column.description} [{column.unit}]"}
            properties[name] = {"type": "number", **said}
        signals = _channel(writer, "/trace", "rvjax.Trace", {"type": "object", "properties": properties})
        rows = trace.frame[names].to_numpy(dtype=float)
        for t, place, turn, row in zip(trace.frame["t_s"].tolist(), places, turns, rows, strict=True):
            stamp = round(t * 1e9)
            seconds, nanoseconds = divmod(stamp, 1_000_000_000)
            pose = {
                "timestamp": {"sec": seconds, "nsec": nanoseconds},
                "parent_frame_id": "target",
                "child_frame_id": "pursuer",
                "translation": dict(zip("xyz", place.tolist(), strict=True)),
                "rotation": dict(zip("xyzw", turn.tolist(), strict=True)),
            }
            values = {name: value for name, value in zip(names, row.tolist(), strict=True) if np.isfinite(value)}
            for channel, message in ((transform, pose), (signals, values)):
                writer.add_message(channel, log_time=stamp, publish_time=stamp, data=json.dumps(message).encode())
        writer.finish()


def _channel(writer: Any, topic: str, name: str, schema: Mapping[str, Any]) -> int:
    known = writer.register_schema(name=name, encoding="jsonschema", data=json.dumps(schema).encode())
    return writer.register_channel(topic=topic, message_encoding="json", schema_id=known)


def _signals(trace: Exported) -> list[str]:
    return [str(name) for name in trace.frame.columns if name != "t_s"]


def _numbers(*names: str) -> dict[str, Any]:
    return {"type": "object", "properties": {name: {"type": "number"} for name in names}}


_TRANSFORM: Mapping[str, Any] = {
    "type": "object",
    "properties": {
        "timestamp": {"type": "object", "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}}},
        "parent_frame_id": {"type": "string"},
        "child_frame_id": {"type": "string"},
        "translation": _numbers("x", "y", "z"),
        "rotation": _numbers("x", "y", "z", "w"),
    },
}
