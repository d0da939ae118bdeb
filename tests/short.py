"""A campaign short enough for tests: 40 samples of tests/short.yaml, 20 s each, every one captured at once."""

from __future__ import annotations

from pathlib import Path

CAMPAIGN = Path(__file__).with_suffix(".yaml")

SHIPPED = Path(__file__).parents[1] / "campaigns"
"""The folder of the shipped campaigns."""

SHORT = (
    "samples=40",
    "horizon.duration_s=20",
    "capture={position_m: 100, attitude_mrp: 1, window_s: 5}",
    "faults.effectiveness.onset_s={uniform: [2, 10]}",
    "faults.bias.onset_s={uniform: [2, 10]}",
)
"""`--set` values."""

QUICK = "controller={use: pd-plus}"
"""The controller that compiles soonest, for tests of whatever is not the controller."""
