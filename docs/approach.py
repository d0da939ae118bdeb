"""Draws docs/approach.svg, a flight that moves: `python docs/approach.py`. It flies one sample of campaigns/quickstart.yaml.

The scene is seen in LVLH: V-bar to the right, H-bar mostly up, R-bar mostly out of the page. Below, the error and the
faults over time. The picture has no script; it repeats by itself.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ROOT = Path(__file__).parents[1]
PICTURE = ROOT / "docs" / "approach.svg"
SAMPLE = 17
WIDTH, HEIGHT, STRIP = 880, 560, 130
MIDDLE = (430.0, 222.0)
SCALE = 15.0
"""Pixels per metre."""
STEPS = 100
SECONDS = 15
CONE = (11.0, 0.2, 2.1)
"""Length [m] of the drawn corridor, and its radius at either end: 0.2 m + 11 m tan 10°."""
HOLD = 0.12
"""Share of the picture's period in which the docked pursuer stands still."""
VIEW = np.array([[1.0, 0.0, 0.0], [0.0, 0.82, 0.57], [0.0, -0.57, 0.82]])
"""LVLH to the screen: right, up, out of it."""
STYLE = """
text { font: 14px system-ui, "DejaVu Sans", Arial, sans-serif; fill: #1a1a1a }
.small { font-size: 12px; fill: #555 }
.target { fill: #e3ecf7; fill-opacity: .75; stroke: #2f5d8a; stroke-width: 1.4; stroke-linejoin: round }
.pursuer { fill: #e2f0e2; fill-opacity: .8; stroke: #3b7a3b; stroke-width: 1.4; stroke-linejoin: round }
.cone { fill: #f6e7c8; fill-opacity: .7; stroke: #b5883a; stroke-dasharray: 5 4 }
.zone { fill: none; stroke: #8a97a5; stroke-dasharray: 2 5 }
.path { fill: none; stroke: #3b7a3b; stroke-width: 1.6; stroke-opacity: .6 }
.error { fill: none; stroke: #2f5d8a; stroke-width: 1.6 }
.tube { stroke: #3b7a3b; stroke-dasharray: 4 3 }
.fault { stroke: #c8501e; stroke-width: 1.4 }
.axis { fill: none; stroke: #8a97a5 }
.now { stroke: #1a1a1a }
.captured { fill: #3b7a3b }
"""
BOX = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
FACES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))


def flown() -> tuple[Any, Any]:
    """(trace, row of the samples table) of the sample."""
    import rvjax

    rvjax.configure("float64")
    campaign = rvjax.Campaign(str(ROOT / "campaigns" / "quickstart.yaml")).with_(
        samples=SAMPLE + 1, keep={"worst": 0}, require=[]
    )
    with tempfile.TemporaryDirectory() as folder:
        run = campaign.fly(f"{folder}/run", progress=False)
        return run.replay(SAMPLE), run.samples.set_index("sample").loc[SAMPLE]


def matrix(sigma: Array) -> Array:
    """R(σ), (n, 3, 3), from the target's frame to the pursuer's, by the equation of `rvjax explain dynamics`."""
    square = (sigma**2).sum(1)[:, None, None]
    x, y, z = sigma.T
    zero = np.zeros_like(x)
    cross = np.stack([np.stack([zero, -z, y], 1), np.stack([z, zero, -x], 1), np.stack([-y, x, zero], 1)], 1)
    return np.eye(3) - 4 * (1 - square) / (1 + square) ** 2 * cross + 8 / (1 + square) ** 2 * cross @ cross


def unit(vectors: Array) -> Array:
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def lvlh(trace: Any) -> Array:
    """(n, 3, 3): from the target's frame to LVLH."""
    r, v = (trace[[f"target_{name}_{axis}_{unit_}" for axis in "xyz"]].to_numpy() for name, unit_ in (("r", "m"), ("v", "m_s")))
    z, y = -unit(r), -unit(np.cross(r, v))
    return np.stack([np.cross(y, z), y, z], 1)


def screen(points: Array) -> Array:
    """Places in LVLH, (…, 3), on the screen: right, down, depth toward the reader."""
    seen = points @ VIEW.T
    return np.stack([MIDDLE[0] + SCALE * seen[..., 0], MIDDLE[1] - SCALE * seen[..., 1], seen[..., 2]], -1)


def line(points: Array) -> str:
    return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points[:, :2])


def body(corners: Array) -> str:
    """The visible faces of a box with these corners, (8, 3), on the screen."""
    drawn = ""
    for face in FACES:
        a, b, c, d = (corners[place] for place in face)
        turns = (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0])
        if turns < 0:
            drawn += line(np.array([a, b, c, d])) + "Z"
    return drawn


def outline(port: Array, end: Array) -> str:
    """The outline of the corridor, about its axis on the screen."""
    along = (end - port)[:2]
    across = SCALE * np.array([-along[1], along[0]]) / max(1.0, float(np.hypot(*along)))
    ends = (port[:2] + CONE[1] * across, end[:2] + CONE[2] * across, end[:2] - CONE[2] * across, port[:2] - CONE[1] * across)
    return f"{line(np.array(ends))}Z"


def moving(kind: str, values: Sequence[str], attribute: str = "d", tag: str = "path") -> str:
    """An element whose attribute takes these values, one after the other, and then stands still."""
    share = np.append(np.linspace(0.0, 1.0 - HOLD, len(values)), 1.0)
    times = ";".join(f"{time:.4f}" for time in share)
    listed = ";".join([*values, values[-1]])
    how = f'dur="{SECONDS}s" repeatCount="indefinite" calcMode="discrete"'
    return (
        f'<{tag} class="{kind}" {attribute}="{values[-1]}">'
        f'<animate attributeName="{attribute}" {how} keyTimes="{times}" values="{listed}"/></{tag}>'
    )


def scene(trace: Any) -> Iterator[str]:
    """Target, corridor, keep-out zone, pursuer and its path."""
    turned, to_pursuer = lvlh(trace), matrix(trace[["sigma_x", "sigma_y", "sigma_z"]].to_numpy())
    rho = trace[["rho_x_m", "rho_y_m", "rho_z_m"]].to_numpy()
    port = np.array([5.0, 0.0, 0.0])
    in_target = np.einsum("nji,nj->ni", to_pursuer, rho) + port
    place = np.einsum("nij,nj->ni", turned, in_target)
    target = screen(np.einsum("nij,kj->nki", turned, BOX * [3.0, 1.6, 1.6]))
    axes = np.einsum("nij,nkj->nik", turned, to_pursuer)
    pursuer = screen(place[:, None, :] + np.einsum("nij,kj->nki", axes, BOX * 0.75))
    axis = screen(np.einsum("nij,kj->nki", turned, port + np.array([[0.0, 0.0, 0.0], [CONE[0], 0.0, 0.0]])))
    arm = screen(np.einsum("nij,kj->nki", turned, np.array([[3.0, 0.0, 0.0], [5.0, 0.0, 0.0]])))
    yield f'<circle class="zone" cx="{MIDDLE[0]}" cy="{MIDDLE[1]}" r="{10 * SCALE}"/>'
    yield moving("cone", [outline(*ends) for ends in axis])
    path = screen(place)
    yield moving("path", [line(path[: max(2, number + 1)]) for number in range(len(path))])
    yield moving("target", [body(corners) for corners in target])
    yield moving("target", [line(corners) for corners in arm])
    yield moving("pursuer", [body(corners) for corners in pursuer])


def strip(trace: Any, full: Any, row: Any) -> Iterator[str]:
    """The error of position over time, the onsets of the faults, and the instant."""
    left, right, top, low = 60.0, WIDTH - 20.0, HEIGHT - STRIP + 20.0, HEIGHT - 24.0
    duration = full["t_s"].iloc[-1]
    error = np.linalg.norm(full[["rho_x_m", "rho_y_m", "rho_z_m"]].to_numpy(), axis=1)

    def x(time: Any) -> Any:
        return left + (right - left) * np.asarray(time) / duration

    def y(metres: Any) -> Any:
        return low - (low - top) * (np.log10(np.clip(metres, 1e-3, 20.0)) + 3.0) / (np.log10(20.0) + 3.0)

    yield f'<path class="axis" d="M{left} {top}V{low}H{right}"/>'
    for metres in (0.01, 0.1, 1.0, 10.0):
        yield f'<text class="small" x="{left - 8}" y="{y(metres) + 4:.1f}" text-anchor="end">{metres:g} m</text>'
    for time in range(0, 301, 60):
        yield f'<text class="small" x="{x(time):.1f}" y="{HEIGHT - 8}" text-anchor="middle">{time} s</text>'
    yield f'<path class="tube" d="M{left} {y(0.01):.1f}H{right}"/>'
    onsets = sorted(float(value) for name, value in row.items() if ".onset_s." in str(name))
    for onset in onsets:
        yield f'<path class="fault" d="M{x(onset):.1f} {low}v-14"/>'
    yield f'<text class="small" x="{x(onsets[0]):.1f}" y="{low - 20}">onsets of {len(onsets)} faults</text>'
    thin = np.arange(0, len(full), max(1, len(full) // 400))
    yield f'<path class="error" d="{line(np.stack([x(full["t_s"].to_numpy()[thin]), y(error[thin])], 1))}"/>'
    yield f'<text class="small" x="{left + 6}" y="{top + 2}">error of position; dashed: tube of capture, 1 cm</text>'
    yield moving("now", [f"M{float(x(time)):.1f} {top}V{low}" for time in trace["t_s"]])
    settled = float(row["metric.settling_time_s"])
    shown = [("1" if time >= settled else "0") for time in trace["t_s"]]
    place = f'x="{x(settled) + 8:.1f}" y="{y(0.01) - 10:.1f}"'
    words = f'<text class="captured" {place}>inside the tube from {settled:.0f} s on</text></g>'
    yield moving("shown", shown, "opacity", "g").replace("</g>", words)


def picture() -> str:
    """The picture as SVG."""
    full, row = flown()
    places = np.unique(np.linspace(0, len(full) - 1, STEPS).round().astype(int))
    trace = full.iloc[places]
    parts = [
        *scene(trace),
        *strip(trace, full, row),
        '<text x="20" y="28">A flight of campaigns/quickstart.yaml, sample 17</text>',
        '<text class="small" x="20" y="48">in LVLH; 300 s in 13 s; blue: tumbling target with its docking axis,</text>',
        '<text class="small" x="20" y="65">green: pursuer, dashed: corridor and keep-out zone</text>',
    ]
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" role="img">\n'
        "<title>A pursuer docks with a tumbling target while its actuators fail</title>\n"
        f'<style>{STYLE}</style>\n<rect width="{WIDTH}" height="{HEIGHT}" fill="#fff"/>\n' + "\n".join(parts) + "\n</svg>\n"
    )


if __name__ == "__main__":
    PICTURE.write_text(picture(), encoding="utf-8")
