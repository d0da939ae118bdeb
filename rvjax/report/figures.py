"""Figures as SVG, and as PNG where that is asked for. The same figure gives the same bytes."""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import matplotlib
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG

from rvjax.report.blocks import Drawing, Section
from rvjax.report.plotting import STYLE
from rvjax.run_folder import RunFolder
from rvjax.timings import phase

_REFERENCE = re.compile(r'(\bid="|\bhref="#|url\(#)')


PIXELS_PER_INCH = 160
"""Of a PNG file."""


@dataclass(frozen=True)
class Picture:
    """A rendered figure. svg: a document; inline: the <svg> element for use inside HTML; png: empty unless asked for."""

    svg: str
    inline: str
    png: bytes


def render(
    folder: RunFolder, make: Callable[[], Sequence[Section]], png: bool = False
) -> tuple[Sequence[Section], dict[str, Picture]]:
    """Makes sections in the style of the report and writes their figures into a folder → (sections, pictures by name). png: also
    as PNG files."""
    with matplotlib.rc_context(STYLE):
        sections = make()
        with phase("figures"):
            pictures = {drawing.name: draw(drawing, png) for section in sections for drawing in section.drawings}
    for name, picture in pictures.items():
        folder.write_text(f"figures/{name}.svg", picture.svg)
        if png:
            folder.write_bytes(f"figures/{name}.png", picture.png)
    return sections, pictures


def draw(drawing: Drawing, png: bool = False) -> Picture:
    """Renders a figure; its name makes the ids of the SVG unique on the page. png: also as PNG."""
    vector, pixels, figure = io.StringIO(), io.BytesIO(), drawing.figure
    no_metadata = dict.fromkeys(("Creator", "Date", "Format", "Type"))
    with matplotlib.rc_context({"svg.hashsalt": drawing.name}), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")  # such a glyph is drawn as a box
        if (layout := figure.get_layout_engine()) is not None:
            FigureCanvasAgg(figure)  # it measures the labels
            layout.execute(figure)
            figure.set_layout_engine("none")
        FigureCanvasSVG(figure).print_svg(vector, metadata=no_metadata)
        if png:
            figure.set_dpi(PIXELS_PER_INCH)
            FigureCanvasAgg(figure).print_png(pixels, metadata={"Software": None})
    svg = vector.getvalue()
    return Picture(svg, _inline(svg, drawing.name), pixels.getvalue())


def _inline(svg: str, name: str) -> str:
    """The <svg> element without prolog, comments and namespaces (HTML knows them); ids have `name` as their prefix."""
    element = svg[svg.index("<svg") :]
    element = re.sub(r"<!--.*?-->", "", element, flags=re.DOTALL)
    element = re.sub(r'\sxmlns(:\w+)?="[^"]*"', "", element, count=2).replace("xlink:href", "href")
    return _REFERENCE.sub(rf"\g<1>{name}-", element)
