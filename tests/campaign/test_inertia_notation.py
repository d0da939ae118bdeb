"""Inertia in the notations that people have, against a body of point masses."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rvjax.campaign import load as campaign
from rvjax.campaign import parse
from rvjax.components.manual_lookup import pages_called
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import load
from tests.campaign.test_draws import full
from tests.short import CAMPAIGN

MASSES = np.array([3.0, 1.0, 4.0, 1.5, 9.0, 2.0])
PLACES = np.array([[0.9, 0.2, -0.3], [-0.4, 1.1, 0.5], [0.3, -0.7, 0.8], [0.1, 0.6, -1.2], [-0.2, -0.1, 0.1], [0.5, 0.5, 0.5]])


def point_masses() -> list[list[float]]:
    """J of the body by its definition: the angular momentum Σ m r × (ω × r) of a turn at 1 rad/s about each axis."""
    columns = [(MASSES[:, None] * np.cross(PLACES, np.cross(axis, PLACES))).sum(axis=0) for axis in np.eye(3)]
    return np.array(columns).T.tolist()


J = point_masses()
PRODUCTS = {
    "xy": -float((MASSES * PLACES[:, 0] * PLACES[:, 1]).sum()),
    "xz": -float((MASSES * PLACES[:, 0] * PLACES[:, 2]).sum()),
    "yz": -float((MASSES * PLACES[:, 1] * PLACES[:, 2]).sum()),
}
SYMMETRIC = [[J[min(i, j)][max(i, j)] for j in range(3)] for i in range(3)]
MOMENTS = [J[k][k] for k in range(3)]


@pytest.mark.parametrize(
    "given",
    [
        {"moments": MOMENTS, "products": PRODUCTS},
        {"moments": MOMENTS, "products": dict(reversed(PRODUCTS.items()))},
        {"moments": MOMENTS, "products": [PRODUCTS["yz"], PRODUCTS["xz"], PRODUCTS["xy"]]},
        {"matrix": SYMMETRIC},
        {"matrix": SYMMETRIC, "reject": "true"},
    ],
    ids=["named", "named-in-another-order", "list", "matrix", "matrix-reject"],
)
@pytest.mark.parametrize("body", ["pursuer", "target"])
def test_every_notation_is_the_body(given: dict[str, Any], body: str) -> None:
    """The matrix that flies is that of the point masses. Kills: +∫xy dm, xy and yz exchanged, rows for columns."""
    text = str(given).replace("'", "")
    _, drawn = Draws.of(load(CAMPAIGN, [f"{body}.inertia_kgm2={text}"]), np.arange(2))
    found = full(drawn.plant.inertia if body == "pursuer" else drawn.plant.target_inertia)
    np.testing.assert_allclose(found, np.broadcast_to(J, (2, 3, 3)), rtol=1e-12)


def test_drawn_entries_keep_their_names() -> None:
    """A law in a matrix is the law of the same draw as in moments and products. Kills: products in the order of the mapping."""
    law = "{uniform: [-1, 1]}"
    forms = (
        f"{{matrix: [[20, 2, {law}], [2, {{uniform: [21, 22]}}, 0.5], [{law}, 0.5, 23]]}}",
        f"{{moments: [20, {{uniform: [21, 22]}}, 23], products: {{xz: {law}, xy: 2, yz: 0.5}}}}",
        f"{{moments: [20, {{uniform: [21, 22]}}, 23], products: [0.5, {law}, 2]}}",
    )
    inertias = [campaign(CAMPAIGN, [f"pursuer.inertia_kgm2={form}"]).pursuer.inertia_kgm2 for form in forms]
    assert inertias[0] == inertias[1] == inertias[2]


BROKEN = "the draw 20, 21, 22, 0, 0, 25 is not positive definite; accepted: smaller products of inertia"
ORDER = "products are [Jyz, Jxz, Jxy] with Jxy = -∫xy dm, or {xy: …, xz: …, yz: …}"


@pytest.mark.parametrize(
    ("given", "place", "words"),
    [
        ("{moments: [20, 21, 22], products: [0, 0, 25]}", ".products", BROKEN),
        ("{moments: [20, 21, 22], products: [0, 0, 25]}", ".products", ORDER),
        ("{matrix: [[20, 25, 0], [25, 21, 0], [0, 0, 22]]}", ".matrix", BROKEN),
        ("{moments: [20, 21, 22], products: [9, 9, 9]}", ".products", ORDER),
        ("{moments: [20, 21, 22], products: {xy: 1, yz: 2}}", ".products.xz", "missing; accepted: xy, xz, yz, all of them"),
        ("{moments: [20, 21, 22], products: {xy: 1, yz: 2, zx: 1}}", ".products.zx", "unknown key; accepted: xy, xz, yz"),
        ("{moments: [20, 21, 22], products: {xy: a, xz: 0, yz: 2}}", ".products.xy", "found the text 'a'"),
        (
            "{matrix: [[20, 1, 2], [1, 21, 3], [2, 4, 22]]}",
            ".matrix.2.1",
            "Jyz 3 differs from Jzy 4; accepted: a symmetric matrix",
        ),
        ("{matrix: [[20, 1, 2], [{uniform: [1, 2]}, 21, 3], [2, 3, 22]]}", ".matrix.1.0", "Jxy 1 differs from Jyx a mapping"),
        ("{matrix: [[20, 1, 2], [1, b, 3], [2, 3, 22]]}", ".matrix.1.1", "found the text 'b'"),
        ("{matrix: [[20, 1, b], [1, 20, 3], [b, 3, 22]]}", ".matrix.0.2", "found the text 'b'"),
        ("{matrix: [[-20, 1, 2], [1, 20, 3], [2, 3, 22]]}", ".matrix.0.0", "-20 kg·m²; accepted: above 0 kg·m²"),
        ("{matrix: [20, 21, 22, 0, 0, 1]}", ".matrix", "accepted: [[Jxx, Jxy, Jxz], [Jxy, Jyy, Jyz], [Jxz, Jyz, Jzz]]"),
        ("{matrix: [[20, 0, 0], [0, 21, 0], [0, 0, 22]], products: 0}", ".products", "both matrix and products"),
        ("{matrix: [[20, 0, 0], [0, 21, 0], [0, 0, 22]], tilt_deg: 0}", ".tilt_deg", "unknown key"),
        ("{matrix: [[20, 0, 0], [0, 21, 0], [0, 0, 22]], moments: 1}", "", "or matrix"),
        ("[20, 21, 22, 0, 0, 1]", "", "found a list of 6; accepted: principal (with tilt_deg or rotation), moments"),
    ],
)
@pytest.mark.parametrize("body", ["pursuer", "target"])
def test_a_mistake_names_entry_order_and_sign(given: str, place: str, words: str, body: str) -> None:
    """Kills: half of a matrix that is ignored, a product that is silently 0, a message that hides the order of the list."""
    found = "\n".join(map(str, parse(CAMPAIGN, [f"{body}.inertia_kgm2={given}"])[1]))
    assert f": {body}.inertia_kgm2{place}: " in found
    assert words in found


def test_the_manual_names_order_and_sign() -> None:
    """Kills: a manual that leaves the order of the products or their sign open."""
    text = "".join(page.text for page in pages_called("inertia"))
    assert "Jxy = −∫xy dm" in text
    assert "products: [Jyz, Jxz, Jxy]" in text
