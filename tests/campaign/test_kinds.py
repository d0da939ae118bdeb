"""Chance or not known: every draw says which, with its law, in the table and in the file."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from rvjax.campaign.distributions import (
    Attitude,
    Ball,
    Empirical,
    Exponential,
    Normal,
    Pick,
    Poisson,
    TruncatedNormal,
    VonMisesFisher,
)
from rvjax.campaign.law_words import in_words
from rvjax.columns import ALEATORY, EPISTEMIC, Column
from rvjax.run_folder.parquet import decode, encode
from rvjax.simulation.draws import Draws
from rvjax.simulation.problem import load
from tests.short import CAMPAIGN

TILTED = "pursuer.inertia_kgm2={principal: [{normal: [22, 1]}, 20, 23], tilt_deg: {half_normal: 3}, reject: true}"


def test_a_name_and_the_beginning_of_names_are_epistemic() -> None:
    """Kills: a beginning inside a word (`start.rho` of `start.rho_m`), a joint law of which one component is left out."""
    names = "epistemic=[pursuer.mass_kg, pursuer.inertia_kgm2, start.rho_m.x]"
    columns = Draws.of(load(CAMPAIGN, [TILTED, names]), np.arange(2))[0].columns
    epistemic = {name for name, column in columns.items() if column.kind == EPISTEMIC}
    inertia = {name for name in columns if name.startswith("pursuer.inertia_kgm2.") and not name.endswith(".rejected")}
    assert epistemic == {"pursuer.mass_kg", "start.rho_m.x", *inertia}
    assert len(inertia) == 5  # one moment, the tilt, three components of its axis
    assert {column.kind for name, column in columns.items() if name not in epistemic} == {ALEATORY, ""}
    assert columns["pursuer.inertia_kgm2.rejected"].kind == ""
    ball = load(CAMPAIGN, ["start.rho_m={ball: 5}", "epistemic=[start.rho_m.x]"]).dispersions.columns
    assert [ball[f"start.rho_m.{axis}"].kind for axis in "xyz"] == [EPISTEMIC, ALEATORY, ALEATORY]
    assert columns["pursuer.inertia_kgm2.principal.x"].law == "normal (mean 22, sd 1)"


def test_the_kind_is_part_of_what_a_run_is_and_changes_no_draw() -> None:
    """Columns of a folder must be the same throughout; the order of the names says nothing."""
    plain, one = load(CAMPAIGN), load(CAMPAIGN, ["epistemic=[pursuer, start.rho_m]"])
    other = load(CAMPAIGN, ["epistemic=[start.rho_m, pursuer, pursuer]"])
    assert plain.fingerprint != one.fingerprint == other.fingerprint
    before, after = (Draws.of(problem, np.arange(50))[0].values for problem in (plain, one))
    assert all(np.array_equal(values, after[name]) for name, values in before.items())


def test_kind_and_law_are_in_the_file() -> None:
    draws = Draws.of(load(CAMPAIGN, ["epistemic=[pursuer.mass_kg]"]), np.arange(3))[0]
    frame = {f"draw.{name}": values for name, values in draws.values.items()}
    columns = {f"draw.{name}": column for name, column in draws.columns.items()}
    again = decode(encode(pd.DataFrame(frame), columns))[1]
    assert again == columns
    assert again["draw.pursuer.mass_kg"] == Column(
        "draw.pursuer.mass_kg", "kg", "mass of the pursuer", kind="epistemic", law="uniform (low 80, high 120)"
    )


@pytest.mark.parametrize(
    ("law", "words"),
    [
        (TruncatedNormal(1.0, 2.0, 0.0, 3.0), "truncated normal (mean 1, sd 2, low 0, high 3)"),
        (Exponential(50.0), "exponential (mean 50)"),
        (Pick.of([1.0, 2.0]), "choice (values 1, 2)"),
        (Pick.of([1.0, 2.0], [1.0, 3.0]), "choice (values 1, 2, weights 0.25, 0.75)"),
        (Empirical.of([float(i) for i in range(1500)], True), "table (1,500 values, interpolate)"),
        (Poisson(2.5), "poisson (mean 2.5)"),
        (Ball(5.0), "ball (radius 5)"),
        (VonMisesFisher.of((0.0, 2.0, 0.0), 10.0, 5.0), "von mises fisher (mean 0, 1, 0, kappa 10, radius 5)"),
        (Attitude(), "rotation (uniform)"),
        (Normal(0.0, 1.0), "normal (mean 0, sd 1)"),
    ],
)
def test_laws_in_words(law: object, words: str) -> None:
    assert in_words(law) == words


def test_a_correlated_draw_says_so() -> None:
    pair = "correlate=[{variables: [pursuer.mass_kg, start.rho_m.x], rank: [[1, 0.5], [0.5, 1]]}]"
    columns = load(CAMPAIGN, [pair]).dispersions.columns
    assert columns["start.rho_m.x"].law == "uniform (low -20, high 20), correlated"
    assert "correlated" not in columns["start.rho_m.y"].law
