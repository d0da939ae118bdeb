"""Draws docs/start-frames.svg, the frames of the start: `python docs/start_frames.py`. Needs the standard library only.

The plane of the orbit, not to scale, against the orbit normal: V-bar to the right, R-bar down, H-bar out of the page.
"""

from __future__ import annotations

import math
from pathlib import Path

PICTURE = Path(__file__).parents[1] / "docs" / "start-frames.svg"
WIDTH, HEIGHT = 880, 460
CENTRE = (560.0, 215.0)
"""The target's centre of mass."""
TILT = math.radians(-158.0)
"""Direction of the docking axis, from V-bar toward R-bar (down); it turns with the target."""
PORT = 52.0
CONE = math.radians(14.0)
STYLE = """
text { font: 15px system-ui, "DejaVu Sans", Arial, sans-serif; fill: #1a1a1a }
.small { font-size: 13px; fill: #444 }
.body { fill: #e3ecf7; stroke: #2f5d8a; stroke-width: 1.5 }
.cone { fill: #f6e7c8; stroke: #b5883a; stroke-dasharray: 5 4 }
.lvlh { fill: none; stroke: #2f5d8a; stroke-width: 2 }
.port { fill: none; stroke: #a0522d; stroke-width: 2 }
.pursuer { fill: none; stroke: #3b7a3b; stroke-width: 2 }
.thin { fill: none; stroke: #8a97a5; stroke-width: 1; stroke-dasharray: 3 3 }
.white { fill: #fff }
.blue { fill: #2f5d8a } .brown { fill: #a0522d } .green { fill: #3b7a3b }
"""

Point = tuple[float, float]


def polar(origin: Point, angle: float, length: float) -> Point:
    return origin[0] + length * math.cos(angle), origin[1] + length * math.sin(angle)


def arrow(kind: str, colour: str, begin: Point, end: Point) -> str:
    """A line with a head at its end."""
    angle = math.atan2(end[1] - begin[1], end[0] - begin[0])
    neck = polar(end, angle, -9.0)
    left, right = (polar(polar(end, angle, -11.0), angle + side * math.pi / 2.0, 5.0) for side in (1.0, -1.0))
    line = f'<path class="{kind}" d="M{begin[0]:.1f} {begin[1]:.1f}L{neck[0]:.1f} {neck[1]:.1f}"/>'
    head = "L".join(f"{px:.1f} {py:.1f}" for px, py in (end, left, right))
    return f'{line}<path class="{colour}" d="M{head}Z"/>'


def text(place: Point, words: str, kind: str = "") -> str:
    return f'<text x="{place[0]:.1f}" y="{place[1]:.1f}" class="{kind}">{words}</text>'


def box(place: Point, angle: float, width: float, height: float) -> str:
    turn = f"rotate({math.degrees(angle):.1f} {place[0]:.1f} {place[1]:.1f})"
    corner = f'x="{place[0] - width / 2.0:.1f}" y="{place[1] - height / 2.0:.1f}"'
    return f'<rect class="body" {corner} width="{width:.0f}" height="{height:.0f}" rx="4" transform="{turn}"/>'


def dot(place: Point, colour: str = "blue") -> str:
    return f'<circle class="{colour}" cx="{place[0]:.1f}" cy="{place[1]:.1f}" r="4"/>'


def picture() -> str:
    """The picture as SVG."""
    x, y = CENTRE
    port = polar(CENTRE, TILT, PORT)
    edges = [polar(port, TILT + side * CONE, 330.0) for side in (-1.0, 1.0)]
    chaser = polar(polar(port, TILT, 215.0), TILT + math.pi / 2.0, 12.0)
    turned = TILT + math.pi + math.radians(20.0)
    behind, below = (x - 440.0, y), (x, y + 130.0)
    parts = [
        f'<path class="cone" d="M{port[0]:.1f} {port[1]:.1f}L{edges[0][0]:.1f} {edges[0][1]:.1f}'
        f'A330 330 0 0 1 {edges[1][0]:.1f} {edges[1][1]:.1f}Z"/>',
        f'<path class="thin" d="M{behind[0]:.1f} {y:.1f}H{x - PORT - 8.0:.1f}"/>',
        box(CENTRE, TILT, 2.0 * PORT, 70.0),
        arrow("lvlh", "blue", CENTRE, (x + 260.0, y)),
        arrow("lvlh", "blue", CENTRE, (x, y + 210.0)),
        f'<circle class="lvlh white" cx="{x}" cy="{y}" r="8"/>',
        dot(CENTRE),
        text((x + 78.0, y - 12.0), "x: V-bar, along the orbit", "blue"),
        text((x + 14.0, y + 212.0), "z: R-bar, toward the Earth", "blue"),
        text((x + 62.0, y + 32.0), "y: H-bar, out of the page,", "blue"),
        text((x + 62.0, y + 50.0), "against the orbit normal", "blue"),
        text((x + 46.0, y - 66.0), "target, with its centre of mass"),
        arrow("port", "brown", port, polar(port, TILT, 120.0)),
        arrow("port", "brown", port, polar(port, TILT + math.pi / 2.0, -84.0)),
        dot(port, "brown"),
        text((port[0] - 142.0, port[1] + 88.0), "docking point", "brown"),
        text((port[0] - 46.0, port[1] - 70.0), "x: docking axis", "brown"),
        text((port[0] - 130.0, port[1] - 140.0), "approach cone (corridor)", "small"),
        box(chaser, turned, 44.0, 34.0),
        arrow("pursuer", "green", chaser, polar(chaser, turned, 64.0)),
        arrow("pursuer", "green", chaser, polar(chaser, turned + math.pi / 2.0, 64.0)),
        dot(chaser, "green"),
        text((chaser[0] - 96.0, chaser[1] + 10.0), "pursuer", "green"),
        dot(behind),
        text((behind[0] - 8.0, y + 26.0), "hold point on V-bar"),
        text((behind[0] - 8.0, y + 44.0), "frame: lvlh, position_m: [-100, 0, 0]", "small"),
        dot(below),
        text((below[0] - 300.0, below[1] + 2.0), "hold point on R-bar"),
        text((below[0] - 300.0, below[1] + 20.0), "frame: lvlh, position_m: [0, 0, 30]", "small"),
    ]
    body = "\n".join(parts)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" role="img">\n'
        "<title>Frames of the start: LVLH, the port and the pursuer in the plane of the orbit</title>\n"
        f'<style>{STYLE}</style>\n<rect width="{WIDTH}" height="{HEIGHT}" fill="#fff"/>\n{body}\n</svg>\n'
    )


if __name__ == "__main__":
    PICTURE.write_text(picture(), encoding="utf-8")
