"""Distributions of width zero: fixed numbers, all alike."""

from __future__ import annotations

from pathlib import Path

import pytest

from rvjax.campaign import load, parse
from rvjax.campaign.distribution_notation import SCALAR_WORDS, VECTOR_WORDS
from tests.short import CAMPAIGN

POINTS = {
    "uniform": ("[2, 2]", 2.0),
    "normal": ("[2, 0]", 2.0),
    "truncated_normal": ("[2, 0, 1, 3]", 2.0),
    "log_uniform": ("[2, 2]", 2.0),
    "half_normal": ("0", 0.0),
    "log_normal": ("[2, 0]", 2.0),
    "triangular": ("[2, 2, 2]", 2.0),
    "beta": ("[1, 2, 2, 2]", 2.0),
    "exponential": ("0", 0.0),
    "weibull": ("[0, 2]", 0.0),
    "poisson": ("0", 0.0),
    "choice": ("{values: [2, 2], weights: [1, 3]}", 2.0),
    "table": ("{csv: same.csv, column: x}", 2.0),
}
RADII = {"box": "0", "ball": "0", "direction": "0", "von_mises_fisher": "{mean: [1, 0, 0], kappa: 2, radius: 0}"}


@pytest.fixture
def campaign(tmp_path: Path) -> Path:
    (tmp_path / "same.csv").write_text("x\n2\n2\n")
    (tmp_path / "campaign.yaml").write_text(CAMPAIGN.read_text())
    return tmp_path / "campaign.yaml"


@pytest.mark.parametrize("word", SCALAR_WORDS)
def test_a_law_of_width_zero_is_its_number(word: str, campaign: Path) -> None:
    """The fingerprint is that of the plain number. Kills: a law that alone refuses its width 0, another number, a draw without
    effect."""
    given, value = POINTS[word]
    spec, plain = (load(campaign, [f"start.nu_m_s=[{text}, 1, 1]"]) for text in (f"{{{word}: {given}}}", value))
    assert spec.start.nu_m_s.is_fixed
    assert spec.fingerprint() == plain.fingerprint()


@pytest.mark.parametrize("word", [word for word in VECTOR_WORDS if word != "rotation"])
def test_a_radius_of_zero_is_the_origin(word: str, campaign: Path) -> None:
    """Kills: a ball that refuses what a box accepts."""
    spec, plain = (load(campaign, [f"start.rho_m={text}"]) for text in (f"{{{word}: {RADII[word]}}}", 0))
    assert spec.start.rho_m.is_fixed
    assert spec.fingerprint() == plain.fingerprint()


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("{uniform: [2, 1]}", "the low end must not be above the high end"),
        ("{normal: [2, -1]}", "the standard deviation must be at least 0"),
        ("{truncated_normal: [5, 0, 1, 3]}", "truncated_normal"),
        ("{log_uniform: [0, 0]}", "the low end must be above 0"),
        ("{log_normal: [0, 0]}", "the median must be above 0"),
        ("{half_normal: -1}", "the standard deviation must be at least 0"),
        ("{exponential: -1}", "the mean must be at least 0"),
        ("{weibull: [0, 0]}", "weibull"),
        ("{beta: [0, 1, 2, 2]}", "the first shape must be"),
        ("{choice: {values: [2, 2], weights: [0, 1]}}", "every weight must be above 0"),
        ("{choice: {values: [2, 2], weights: [1]}}", "2 values but 1 weights"),
    ],
)
def test_width_zero_hides_no_other_mistake(given: str, words: str, campaign: Path) -> None:
    """Kills: a number in place of parameters that no law has."""
    assert words in "\n".join(map(str, parse(campaign, [f"start.nu_m_s=[{given}, 1, 1]"])[1]))


def test_a_number_of_width_zero_keeps_its_range(campaign: Path) -> None:
    """Kills: a mass of 0 kg through a law."""
    for given in ("{uniform: [0, 0]}", "{half_normal: 0}", "{choice: [-1]}"):
        assert "accepted: above 0 kg" in "\n".join(map(str, parse(campaign, [f"pursuer.mass_kg={given}"])[1]))
