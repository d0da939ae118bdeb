"""Draws docs/guidance-path.svg, the way of the guidance `corridor`: `python docs/guidance_path.py`.

In the frame of the port, in the plane of the docking axis, to scale: the law of `rvjax explain corridor` with its default gains,
for a target at rest and a pursuer that is aligned and keeps up. Needs the standard library only.
"""

from __future__ import annotations

import math
from pathlib import Path

PICTURE = Path(__file__).parents[1] / "docs" / "guidance-path.svg"
WIDTH, HEIGHT, SCALE = 940, 650, 20.0
PORT_AT = (560.0, 365.0)
"""The docking point in the picture. x: docking axis, to the right; y: up."""
PORT, GATE, KEEP_OUT = 5.0, 8.0, 11.0
"""|δ|, gate_m and the radius of the keep-out zone [m]."""
CONE, RADIUS, LENGTH = math.radians(10.0), 0.4, 15.0
START = (-20.0, 13.0)
FAR, NEAR, END, SLOPE, ACCELERATION, TIME = 0.4, 0.2, 0.02, 0.05, 0.02, 1.0
BEYOND, ENTRY, BESIDE, LEAST = 1.05, 1.1, 0.1, 0.02
STEP, SHOWN_S, BEHIND_S = 0.1, 92.0, 2.3
"""Step of the integration, the instant at which the reference point is drawn, how far the pursuer is behind it [s]."""
STYLE = """
text { font: 15px system-ui, "DejaVu Sans", Arial, sans-serif; fill: #1a1a1a }
.small { font-size: 13px; fill: #444 }
.zone { fill: #f7e3e3; stroke: #b04a4a; stroke-width: 1.5; stroke-dasharray: 6 4 }
.cone { fill: #f6e7c8; stroke: #b5883a; stroke-dasharray: 5 4 }
.hull { fill: #e3ecf7; stroke: #2f5d8a; stroke-width: 1.5 }
.own { fill: #e2f0e2; stroke: #3b7a3b; stroke-width: 1.5 }
.way { fill: none; stroke: #3b7a3b; stroke-width: 2.5 }
.ahead { fill: none; stroke: #3b7a3b; stroke-width: 2; stroke-dasharray: 2 5 }
.thin { fill: none; stroke: #8a97a5; stroke-width: 1; stroke-dasharray: 3 3 }
.blue { fill: #2f5d8a } .brown { fill: #a0522d } .green { fill: #3b7a3b } .red { fill: #b04a4a }
"""

Point = tuple[float, float]


def limited(x: float, y: float, most: float) -> Point:
    size = math.hypot(x, y)
    return (x, y) if size <= most else (x * most / size, y * most / size)


def wanted(p: Point) -> Point:
    """u of the law at a place from the docking point, with c₁ = c₂ = 1 and the target at rest."""
    x, y = p
    if abs(y) <= BESIDE * x + LEAST and x <= ENTRY * GATE:
        speed = min(NEAR, ACCELERATION / SLOPE, max(SLOPE * x, min(END, x / (4.0 * TIME))))
        return -speed, -min(2.0 * SLOPE, 0.25 / TIME) * y
    qx, gate, most = x + PORT, PORT + BEYOND * GATE, min(FAR, ACCELERATION / SLOPE)
    size = math.hypot(qx, y)
    ex, ey = qx / size, y / size
    down = max(-most, min(most, SLOPE * (gate - size)))
    across = math.hypot(1.0 - ex * ex, ex * ey)
    tx, ty = (1.0 - ex * ex) / across, -ex * ey / across
    rest = max(0.0, min(1.0, (size - gate) / (0.5 * gate)))
    turn = (1.0 - rest) * min(most, SLOPE * size * math.hypot(1.0 - ex, ey))
    return ex * down + tx * turn, ey * down + ty * turn


def way() -> list[Point]:
    """Places of the reference point from the start to the docking point, at every step."""
    place, velocity, places = START, (0.0, 0.0), [START]
    while math.hypot(*place) > 0.02 and len(places) < 10_000:
        u = wanted(place)
        b = limited((u[0] - velocity[0]) / TIME, (u[1] - velocity[1]) / TIME, ACCELERATION)
        velocity = (velocity[0] + b[0] * STEP, velocity[1] + b[1] * STEP)
        place = (place[0] + velocity[0] * STEP, place[1] + velocity[1] * STEP)
        places.append(place)
    return places


def at(p: Point) -> Point:
    """In the picture."""
    return PORT_AT[0] + SCALE * p[0], PORT_AT[1] - SCALE * p[1]


def text(place: Point, words: str, kind: str = "") -> str:
    return f'<text x="{place[0]:.1f}" y="{place[1]:.1f}" class="{kind}">{words}</text>'


def dot(p: Point, colour: str) -> str:
    x, y = at(p)
    return f'<circle class="{colour}" cx="{x:.1f}" cy="{y:.1f}" r="4.5"/>'


def circle(p: Point, radius: float, kind: str) -> str:
    x, y = at(p)
    return f'<circle class="{kind}" cx="{x:.1f}" cy="{y:.1f}" r="{radius * SCALE:.1f}"/>'


def line(places: list[Point], kind: str, end: str = "") -> str:
    return f'<path class="{kind}" d="M' + "L".join(f"{x:.1f} {y:.1f}" for x, y in map(at, places)) + f'{end}"/>'


def picture() -> str:
    """The picture as SVG."""
    places = way()
    shown = places[round(SHOWN_S / STEP)]
    behind = places[round((SHOWN_S - BEHIND_S) / STEP)]
    wide = RADIUS + LENGTH * math.tan(CONE)
    gate = (GATE, 0.0)
    x, y = at((-9.0, 2.0))
    parts = [
        circle((-PORT, 0.0), KEEP_OUT, "zone"),
        line([(0.0, RADIUS), (LENGTH, wide), (LENGTH, -wide), (0.0, -RADIUS)], "cone", "Z"),
        circle((-PORT, 0.0), PORT + BEYOND * GATE, "thin"),
        line([(0.0, 0.0), (LENGTH + 1.2, 0.0)], "thin"),
        f'<rect class="hull" x="{x:.1f}" y="{y:.1f}" width="{8.0 * SCALE:.0f}" height="{4.0 * SCALE:.0f}"/>',
        line(places[: round(SHOWN_S / STEP) + 1 : 5], "way"),
        line([*places[round(SHOWN_S / STEP) :: 5], (0.0, 0.0)], "ahead"),
        circle(behind, 1.2, "own"),
        dot(behind, "blue"),
        dot(shown, "green"),
        dot((-PORT, 0.0), "blue"),
        dot((0.0, 0.0), "brown"),
        dot(gate, "brown"),
        dot(START, "blue"),
        text((at(START)[0] - 10.0, at(START)[1] - 14.0), "start"),
        text((at((-9.0, 0.0))[0] + 8.0, at((0.0, -1.4))[1]), "target.hull", "blue"),
        text((at((-PORT, 0.0))[0] - 46.0, at((0.0, 0.0))[1] - 12.0), "centre of mass", "small"),
        text((at((0.0, 0.0))[0] - 40.0, at((0.0, -2.9))[1]), "docking point", "brown"),
        text((at(gate)[0] - 16.0, at((0.0, -3.4))[1]), "gate, gate_m", "brown"),
        text((at((LENGTH, 0.0))[0] - 58.0, at((0.0, wide))[1] - 10.0), "corridor", "small"),
        text((at((-PORT, 0.0))[0] - 96.0, at((0.0, -7.2))[1]), "target.keep_out", "red"),
        text((at((-PORT, 0.0))[0] - 96.0, at((0.0, -7.2))[1] + 18.0), "closed but for the corridor", "small"),
        text((at(behind)[0] + 28.0, at(behind)[1] - 18.0), "pursuer.hull follows the point", "green"),
        text((at(shown)[0] + 16.0, at(shown)[1] + 2.0), "reference point p(t)", "green"),
        text((at(START)[0] - 60.0, at(START)[1] + 58.0), "1  comes down at rest in LVLH", "green"),
        text((at((0.0, 0.0))[0] + 30.0, at((0.0, 14.0))[1]), "2  goes round, outside of the zone", "green"),
        text((at(gate)[0] + 16.0, at((0.0, -5.0))[1]), "3  along the axis; waits", "green"),
        text((at(gate)[0] + 16.0, at((0.0, -5.9))[1]), "for an aligned pursuer", "green"),
    ]
    body = "\n".join(parts)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" role="img">\n'
        "<title>The way of the reference point of the guidance corridor, in the frame of the port</title>\n"
        f'<style>{STYLE}</style>\n<rect width="{WIDTH}" height="{HEIGHT}" fill="#fff"/>\n{body}\n</svg>\n'
    )


if __name__ == "__main__":
    PICTURE.write_text(picture(), encoding="utf-8")
