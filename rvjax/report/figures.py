"""Figures as SVG and PNG. The same figure gives the same bytes."""

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


@dataclass(frozen=True)
class Picture:
    """A rendered figure. svg: a document; inline: the <svg> element for use inside HTML; png: at 160 dpi."""

    svg: str
    inline: str
    png: bytes


def render(folder: RunFolder, make: Callable[[], Sequence[Section]]) -> tuple[Sequence[Section], dict[str, Picture]]:
    """Makes sections in the style of the report and writes their figures into a folder → (sections, pictures by name)."""
    with matplotlib.rc_context(STYLE):
        sections = make()
        with phase("figures"):
            pictures = {drawing.name: draw(drawing) for section in sections for drawing in section.drawings}
    for name, picture in pictures.items():
        folder.write_text(f"figures/{name}.svg", picture.svg)
        folder.write_bytes(f"figures/{name}.png", picture.png)
    return sections, pictures


def draw(drawing: Drawing) -> Picture:
    """Renders a figure in both formats; its name makes the ids of the SVG unique on the page."""
    vector, pixels = io.StringIO(), io.BytesIO()
    no_metadata = dict.fromkeys(("Creator", "Date", "Format", "Type"))
    with matplotlib.rc_context({"svg.hashsalt": drawing.name}), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")  # such a glyph is drawn as a box
        FigureCanvasAgg(drawing.figure).print_png(pixels, metadata={"Software": None})
        drawing.figure.set_layout_engine("none")  # keep the layout of the first format
        FigureCanvasSVG(drawing.figure).print_svg(vector, metadata=no_metadata)
    svg = vector.getvalue()
    return Picture(svg, _inline(svg, drawing.name), pixels.getvalue())


def _inline(svg: str, name: str) -> str:
    """The <svg> element without prolog, comments and namespaces (HTML knows them); ids have `name` as their prefix."""
    element = svg[svg.index("<svg") :]
    element = re.sub(r"<!--.*?-->", "", element, flags=re.DOTALL)
    element = re.sub(r'\sxmlns(:\w+)?="[^"]*"', "", element, count=2).replace("xlink:href", "href")
    return _REFERENCE.sub(rf"\g<1>{name}-", element)
