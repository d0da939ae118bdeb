"""What a campaign says of flights whose hulls collide."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.physics.test_hulls import CAMPAIGN, FINER, SHAPES, flown, smallest
from tests.short import SHIPPED

METRICS = """\
metrics:
  - {use: keep-out, name: antenna, centre_m: [0, 0.2, 1], radius_m: 1.5}
  - {use: passive-safety, radius_m: 2.5, coast_s: 60, every_s: 2}
  - {use: contact}
  - {use: fuel-bound}
"""


def test_chosen_metrics_of_a_collided_flight(tmp_path: Path) -> None:
    """Those of safety are over the whole flight, as if nothing had happened; all others are NaN. Kills: a keep-out that is NaN, a
    contact of a pursuer that came through the target."""
    path = tmp_path / "campaign.yaml"
    target, pursuer = SHAPES["balls"]
    path.write_text(CAMPAIGN.replace("TARGET", target).replace("PURSUER", pursuer) + METRICS)
    flight = flown(path, 0.1)
    collided = flight.results["outcome"] == "collided"
    assert 12 < collided.sum() < 52
    values = {name.removeprefix("metric."): array for name, array in flight.results.items()}
    away = np.linalg.norm(flight.places - [0.0, 0.2, 1.0], axis=2).min(axis=0) - 1.5
    np.testing.assert_allclose(values["antenna_clearance_m"], away, rtol=0.0, atol=1e-9)
    assert away[collided].min() < 0.0
    kept = flight.places[::20]
    outside = np.linalg.norm(kept, axis=2) > 2.5
    nearest = np.where(outside, np.linalg.norm(kept, axis=2), np.inf).min(axis=0) - 2.5
    assert np.all(values["free_drift_clearance_m"] <= nearest + 1e-9)
    assert np.all(np.isfinite(values["free_drift_unsafe_s"]))
    for name in ("contact_time_s", "contact_lateral_m", "fuel_bound_m_s", "fuel_over_bound"):
        assert np.isnan(values[name][collided]).all(), name
    assert np.isfinite(values["fuel_over_bound"][~collided]).all()
    assert not np.isnan(values["contact_time_s"][~collided]).any()


def test_the_shipped_collisions_are_counted_to_the_sample() -> None:
    """The first 64 flights of `campaigns/collision.yaml` until after their last collision, at a twentieth of the step, by the
    nearest points at every 0.01 s, in which a pursuer moves by 2 mm. Kills: with a shipped campaign, a start or a docking axis in
    another frame, a hull that is left out, a bound far from the distance."""
    file, said = SHIPPED / "collision.yaml", ("samples=64", "horizon.duration_s=100")
    flight = flown(file, 0.05, *said)
    true = np.array([found for found, _ in smallest(flown(file, 0.05 / FINER, *said, every=4))])
    clearance = flight.results["metric.hull_clearance_m"]
    collided = flight.results["outcome"] == "collided"
    assert np.abs(true).min() > 0.002, "with this seed no flight is this near to a contact"
    assert np.array_equal(collided, true < 0.0)
    assert 30 < collided.sum() < 60
    assert np.all(flight.results["outcome_time_s"][collided] < 95.0)
    np.testing.assert_allclose(clearance[~collided], true[~collided], rtol=0.0, atol=0.002)
