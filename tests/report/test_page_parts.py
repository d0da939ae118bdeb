"""What the page gets for its replay and its linked plots, without a browser: the coding, the motion, the policy."""

from __future__ import annotations

import base64
import hashlib
import json
import math
import re
import tempfile
import zlib
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from rvjax.campaign import Spec, parse
from rvjax.report import build
from rvjax.report.interactive import flights, scene
from rvjax.report.interactive.data_blocks import MOST, Block, block
from rvjax.report.interactive.page_parts import SCRIPTS, script
from rvjax.report.interactive.samples import shown_rows
from rvjax.report.run_view import open_run
from tests.report.conftest import CAMPAIGN
from tests.report.replay_folder import PORT, trace

Make = Callable[..., Path]
Within = Callable[[], AbstractContextManager[None]]


def campaign(*changes: tuple[str, str], more: str = "") -> Spec:
    """The campaign of the made-up folders, changed."""
    text = CAMPAIGN.format(name="x", description="x", samples=9, require="[]")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "campaign.yaml"
        path.write_text(text + more)
        spec, findings, _ = parse(path)
    assert spec is not None, findings
    return spec


def vectors(frame: pd.DataFrame, form: str) -> NDArray[np.float64]:
    """(rows, 3) of a trace."""
    return np.array([frame[form.format(axis)] for axis in "xyz"]).T.copy()


def read(packed: Block) -> dict[str, NDArray[np.float64]]:
    """The columns of a block, decoded number by number as the page does."""
    data = zlib.decompress(base64.b64decode(packed.text), wbits=-15)
    columns = {}
    for place, (name, (offset, scale)) in enumerate(packed.columns.items()):
        begin, code, values = 2 * place * packed.rows, 0, []
        for i in range(packed.rows):
            zigzag = data[begin + i] * 256 + data[begin + packed.rows + i]
            code = (code + ((zigzag >> 1) ^ -(zigzag & 1))) & 0xFFFF
            values.append({65533: math.nan, 65534: -math.inf, 65535: math.inf}.get(code, offset + scale * code))
        columns[name] = np.array(values)
    return columns


@settings(max_examples=60)
@given(st.lists(st.one_of(st.floats(-1e9, 1e9), st.sampled_from([math.nan, math.inf, -math.inf, 0.0])), max_size=80))
def test_numbers_come_back_to_half_a_quantum(values: list[float]) -> None:
    """Kills: a rounding downwards, a quantum of the range / 65535 that takes the codes of what is not finite, a lost sign."""
    x = np.array(values)
    packed = block({"other": np.zeros(x.size), "x": x})
    back, (_, scale) = read(packed)["x"], packed.columns["x"]
    finite = np.isfinite(x)
    assert np.array_equal(back[~finite], x[~finite], equal_nan=True)
    width = np.ptp(x[finite]) if finite.any() else 0.0
    assert scale == pytest.approx(width / MOST, rel=4e-5, abs=1e-300)
    assert np.all(np.abs(back[finite] - x[finite]) <= 0.5 * scale * (1 + 1e-9) + 1e-15 * np.abs(x[finite]))


@settings(max_examples=200)
@given(
    st.floats(1e-9, 1e9),
    st.one_of(st.just(0.0), st.floats(1e-9, 1e9)),
    st.lists(st.floats(-0.49, 0.49), min_size=1, max_size=5),
)
def test_zero_comes_back_as_zero(below: float, above: float, shares: list[float]) -> None:
    """And what is less than half a quantum. Kills: 0 between two codes, which reads as a force of 5.5e-8 N."""
    small = np.array(shares) * (below + above) / MOST
    x = np.array([0.0, -below, *small.clip(-below, above), above])
    back = read(block({"x": x}))["x"]
    assert back[0] == 0.0
    assert not back[2:-1].any()
    assert back[[1, -1]] == pytest.approx(x[[1, -1]], rel=0, abs=0.50002 * (below + above) / MOST)


def test_whole_numbers_and_large_steps_come_back_exactly() -> None:
    """Kills: differences without wrapping around, low bytes before high bytes."""
    ends = np.array([0.0, MOST, 0.0, 1.0, MOST, MOST - 1.0, 32768.0])
    assert read(block({"x": ends}))["x"].tolist() == ends.tolist()


def test_the_motion_is_that_of_the_trace() -> None:
    """Against SciPy's rotations. Kills: Rᵀ for R, the port left out, a sign that jumps where the MRP switch to the shadow set."""
    frame, spec = trace(3), campaign()
    columns = flights.motion(frame, spec, {})
    sigma = vectors(frame, "sigma_{}")
    assert np.abs(np.diff(sigma, axis=0)).max() > 0.5  # it does switch
    turn = Rotation.from_mrp(sigma.copy())
    place = turn.apply(vectors(frame, "rho_{}_m")) + PORT
    assert np.stack([columns[f"p{a}"] for a in "xyz"], axis=1) == pytest.approx(place, abs=1e-12)
    q = np.stack([columns[f"q{i}"] for i in range(4)], axis=1)
    assert (Rotation.from_quat(q, scalar_first=True) * turn.inv()).magnitude().max() < 1e-12
    assert np.abs(np.diff(q, axis=0)).max() < 0.05  # and the quaternion does not
    r, v = (frame[[f"target_{n}_{a}_{u}" for a in "xyz"]].to_numpy() for n, u in (("r", "m"), ("v", "m_s")))
    lvlh = Rotation.from_quat(np.stack([columns[f"l{i}"] for i in range(4)], axis=1), scalar_first=True)
    assert lvlh.apply([0, 0, 1]) == pytest.approx(-r / np.linalg.norm(r, axis=1)[:, None], abs=1e-12)
    assert lvlh.apply([1, 0, 0]) == pytest.approx(v / np.linalg.norm(v, axis=1)[:, None], abs=1e-12)
    assert columns["turn"] == pytest.approx(7612.7 / 6.878e6 * frame["t_s"].to_numpy(), rel=1e-9)


def test_violations_are_those_of_their_definition() -> None:
    """Kills: a zone whose corridor is cut out on one side, an interval that is one instant too long, time inside the tube."""
    zone = ("port_m: [5, 0, 0]", "port_m: [5, 0, 0], keep_out: {radii_m: 12}")
    frame, spec = trace(3), campaign(zone, more="corridor: {half_angle_deg: 4, radius_m: 0.2}\n")
    turn = Rotation.from_mrp(vectors(frame, "sigma_{}"))
    away = turn.apply(vectors(frame, "rho_{}_m"))
    axial, lateral = away[:, 0], np.hypot(away[:, 1], away[:, 2])
    outside = (lateral > 0.2 + axial * math.tan(math.radians(4))) & (np.linalg.norm(away, axis=1) > 0.01)
    inside = outside & (np.linalg.norm(away + PORT, axis=1) < 12)
    assert 5 < inside.sum() < outside.sum() < len(frame)
    events = flights.events(frame, spec, {"outcome": "not_settled"})
    for kind, holds in (("corridor", outside), ("keep_out", inside)):
        marked = np.zeros(len(frame), dtype=bool)
        for event in events:
            if event["kind"] == kind:
                marked |= frame["t_s"].between(event["t"], event["to"]).to_numpy()
        assert np.array_equal(marked, holds), kind


def test_faults_and_limits_are_those_of_the_sample(report: Path) -> None:
    """Kills: the nominal limit for the drawn one, a fault that begins after the end, a fixed onset that is not read."""
    run = open_run(report)
    row = run.head.iloc[4].to_dict()
    listed = flights.faults(run.spec, row)
    drawn = {c: row[f"draw.faults.effectiveness.onset_s.{c}"] for c in ("fx", "fy", "fz", "tx", "ty", "tz")}
    assert {item["actuator"]: item["from"] for item in listed} == drawn
    assert [item["from"] for item in listed] == sorted(drawn.values())
    late = flights.faults(run.spec, row | {"draw.faults.effectiveness.onset_s.fx": math.inf})
    assert {item["actuator"] for item in late} == {"fy", "fz", "tx", "ty", "tz"}
    limits = scene.limits(run.spec, row | {"draw.actuators.spread.lower.fy": 1.1})
    assert limits["upper"] == [4.0] * 3 + [0.8] * 3
    assert limits["lower"] == pytest.approx([3.0, 3.3, 3.0, 0.6, 0.6, 0.6])
    fixed = campaign(("channels: all, onset_s: {uniform: [30, 150]}", "channels: [fy], onset_s: 60, duration_s: 20"))
    assert [(f["actuator"], f["from"], f["to"]) for f in flights.faults(fixed, {})] == [("fy", 60.0, 80.0)]


def test_a_large_run_shows_every_failure(made: Make, tmp_path: Path) -> None:
    """Beside the first samples, which alone count. Kills: failures of the first chunks only, a failed sample that counts."""
    folder = made(tmp_path / "run", 7_000, (0.9, 0.06, 0.04))
    run = open_run(folder)
    assert len(run.head) == 6_400 < run.flown
    shown = shown_rows(run)
    table = pd.concat([pd.read_parquet(path) for path in sorted((folder / "samples").glob("*.parquet"))])
    failed = set(table.loc[table["outcome"] != "captured", "sample"])
    assert shown.random == 6_400
    assert shown.rows["sample"].is_unique
    assert shown.rows["sample"].iloc[:6_400].tolist() == list(range(6_400))
    assert failed <= set(shown.rows["sample"])
    assert set(shown.rows["sample"].iloc[6_400:]) == {k for k in failed if k >= 6_400}
    rebuilt = replace(run, totals=type(run.totals).of(run.totals.record(), run.totals.keep))
    assert shown_rows(rebuilt).rows["sample"].tolist() == shown.rows["sample"].tolist()


def test_the_policy_names_every_script_and_nothing_else(report: Path) -> None:
    """Kills: a script whose hash is of another text, unsafe-inline, a hash that no script has."""
    text = (report / "report.html").read_text()
    (policy,) = re.findall(r'Content-Security-Policy" content="([^"]*)"', text)
    rules = dict(rule.strip().split(" ", 1) for rule in policy.split(";"))
    bodies = [body for kind, body in re.findall(r"<script id=\"[^\"]*\"([^>]*)>(.*?)</script>", text, re.DOTALL) if not kind]
    hashes = [f"'sha256-{base64.b64encode(hashlib.sha256(body.encode()).digest()).decode()}'" for body in bodies]
    assert rules["script-src"].split() == hashes
    assert len(hashes) == len(SCRIPTS)
    assert rules["default-src"] == "'none'"
    assert set(rules) == {"default-src", "style-src", "img-src", "script-src", "base-uri", "form-action"}
    kinds = set(re.findall(r'<script id="[^"]*" type="([^"]*)">', text))
    assert kinds == {"application/json", "application/octet-stream;base64"}
    for body in re.findall(r'type="application/json">(.*?)</script>', text, re.DOTALL):
        assert not set(body) & set("<>&")
        json.loads(body)


def test_scripts_ask_for_nothing_and_write_no_markup() -> None:
    """Kills: a request, code from text, text of the campaign as markup; a file that is too long to read."""
    forbidden = (
        r"\bfetch\(|XMLHttpRequest|WebSocket|EventSource|sendBeacon|import\(|importScripts|innerHTML|outerHTML|insertAdjacentHTML"
    )
    forbidden += (
        r"|document\.write|\beval\(|new Function|setAttribute\(\"on|https?://(?!www\.w3\.org/2000/svg)|localStorage|cookie"
    )
    for name in SCRIPTS:
        text = script(name)
        assert not re.findall(forbidden, text), name
        assert "</script" not in text.lower()
        assert "<!--" not in text
        assert len(text.splitlines()) <= 400, name
        assert max(map(len, text.splitlines())) <= 150, name
    here = {path.stem for path in (Path(flights.__file__).parent / "scripts").glob("*.js")}
    assert here == set(SCRIPTS)
    assert sum(len(script(name)) for name in SCRIPTS) < 110_000


def test_a_run_without_kept_flights_has_no_replay(made: Make, tmp_path: Path, undrawn: Within) -> None:
    with undrawn():
        text = build(made(tmp_path / "run", 40, kept=0)).read_text()
    assert 'id="replay"' not in text
    assert 'id="brushing"' in text
