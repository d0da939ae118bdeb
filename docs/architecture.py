"""Draws docs/architecture.svg from the imports of the package: `python docs/architecture.py`.

The packages stand on the diagonal, in the order of the layers in pyproject.toml. A line leaves a package to the right and turns
down into a package that it imports. The number at the corner counts the import statements. Needs the standard library only.
"""

from __future__ import annotations

import ast
import tomllib
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
PICTURE = ROOT / "docs" / "architecture.svg"
STEP_X, STEP_Y, BOX_X, BOX_Y, MARGIN = 84, 50, 118, 34, 16
HEAD = (
    '<marker id="head" markerWidth="9" markerHeight="8" refX="7" refY="4" orient="auto">'
    '<path d="M0 0L8 4L0 8Z" fill="#8a97a5"/></marker>'
)
STYLE = """
text { font: 15px system-ui, "DejaVu Sans", Arial, sans-serif; text-anchor: middle; dominant-baseline: central; fill: #1a1a1a }
.box { fill: #e3ecf7; stroke: #2f5d8a; stroke-width: 1.5 }
.module { fill: #f3f3f3; stroke: #777 }
.line { fill: none; stroke: #8a97a5; stroke-width: 1.5 }
.count { fill: #fff; stroke: #8a97a5 }
.number { font-size: 13px }
"""


def layers() -> list[list[str]]:
    """The layers of pyproject.toml, highest first; each is a list of packages and modules that do not import each other."""
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"]["contracts"]
    (layered,) = (contract["layers"] for contract in contracts if contract["type"] == "layers")
    return [layer.split(" | ") for layer in layered]


def boxes() -> list[list[str]]:
    """What stands in each box, in the order of the layers: a package, a module, or all modules of the lowest layer."""
    *upper, lowest = layers()
    return [[name] for layer in upper for name in layer] + [lowest]


def imported(tree: ast.AST) -> Iterator[str]:
    """First name below `rvjax` of every import statement that runs; those under `if TYPE_CHECKING` do not."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING":
            continue
        if isinstance(node, ast.ImportFrom) and node.module is not None:
            names = [f"rvjax.{alias.name}" for alias in node.names] if node.module == "rvjax" else [node.module]
        elif isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        else:
            yield from imported(node)
            continue
        yield from {name.split(".")[1] for name in names if name.startswith("rvjax.")}


def imports() -> Counter[tuple[int, int]]:
    """(importing box, imported box) → number of import statements."""
    box_of = {name: number for number, names in enumerate(boxes()) for name in names}
    counts: Counter[tuple[int, int]] = Counter()
    for path in sorted((ROOT / "rvjax").rglob("*.py")):
        importer = path.relative_to(ROOT / "rvjax").with_suffix("").parts[0]
        if importer not in box_of:
            continue  # rvjax/__init__.py and rvjax/__main__.py
        for name in imported(ast.parse(path.read_text(encoding="utf-8"))):
            if name in box_of and box_of[name] != box_of[importer]:
                counts[box_of[importer], box_of[name]] += 1
    return counts


def centre(number: int) -> tuple[int, int]:
    """Centre of a box."""
    return MARGIN + BOX_X // 2 + number * STEP_X, MARGIN + BOX_Y // 2 + number * STEP_Y


def picture() -> str:
    """The picture as SVG."""
    names = boxes()
    width, height = centre(len(names) - 1)
    width, height = width + BOX_X // 2 + MARGIN, height + BOX_Y // 2 + MARGIN + 14 * (len(names[-1]) - 1)
    lines, numbers, rectangles = [], [], []
    for (importer, target), count in sorted(imports().items()):
        (left, top), (right, bottom) = centre(importer), centre(target)
        path = f"M{left + BOX_X // 2} {top}H{right}V{bottom - BOX_Y // 2 - 2}"
        lines.append(f'<path class="line" marker-end="url(#head)" d="{path}"/>')
        numbers.append(f'<rect class="count" x="{right - 16}" y="{top - 10}" width="32" height="20" rx="10"/>')
        numbers.append(f'<text class="number" x="{right}" y="{top}">{count}</text>')
    for number, group in enumerate(names):
        x, y = centre(number)
        kind = "box" if (ROOT / "rvjax" / group[0]).is_dir() else "box module"
        box_height = BOX_Y + 14 * (len(group) - 1)
        rectangles.append(
            f'<rect class="{kind}" x="{x - BOX_X // 2}" y="{y - BOX_Y // 2}" width="{BOX_X}" height="{box_height}" rx="5"/>'
        )
        first = y - BOX_Y // 2 + box_height // 2 - 9 * (len(group) - 1)
        rectangles += [f'<text x="{x}" y="{first + 18 * row}">{name}</text>' for row, name in enumerate(group)]
    body = "\n".join([*lines, *numbers, *rectangles])
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" role="img">\n'
        "<title>The packages of rvjax and their imports</title>\n"
        f"<style>{STYLE}</style>\n<defs>{HEAD}</defs>\n"
        f'<rect width="{width}" height="{height}" fill="#fff"/>\n{body}\n</svg>\n'
    )


if __name__ == "__main__":
    PICTURE.write_text(picture(), encoding="utf-8")
