"""Compiled flights, shared by the physics tests: what takes time here is compiling."""

from __future__ import annotations

import pytest

from tests import flights
from tests.flights import Recorder

ROWS = 3000
"""Recorded instants of a flight, but for the last: 300 s with a row every 0.1 s."""


@pytest.fixture(scope="session")
def pd_plus() -> Recorder:
    """PD+ behind the smooth saturation: everything is smooth but the onset of a fault."""
    return flights.recorder(flights.loop("pd-plus"), ROWS)


@pytest.fixture(scope="session")
def filtered() -> Recorder:
    """The adaptive law with the second-order filter: smooth as long as nothing is clipped or projected."""
    return flights.recorder(flights.loop("saturated-adaptive", derivative="filtered"), ROWS)


@pytest.fixture(scope="session")
def levant() -> Recorder:
    """The adaptive law as it is by default, with the Levant differentiator."""
    return flights.recorder(flights.loop("saturated-adaptive"), ROWS)
