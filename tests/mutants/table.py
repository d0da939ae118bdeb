"""Mistakes that the tests must notice, one in each row: signs, frames, missing terms, swapped sides;
wrong words, files and exit codes.

`old` stands exactly once in `file` and is replaced by `new`; `killer` is a test that fails then.
"""

from __future__ import annotations

from tests.mutants import (
    command_table,
    data_table,
    draws_table,
    elementary_table,
    engine_table,
    export_table,
    flight_table,
    guidance_table,
    members_table,
    metrics_table,
    product_table,
    propellant_table,
    rare_table,
    replay_table,
    scene_table,
    sensors_table,
    start_table,
    trace_table,
    user_table,
    which_table,
)
from tests.mutants.mutant import Mutant

MUTANTS: tuple[Mutant, ...] = (
    *flight_table.MUTANTS,
    *elementary_table.MUTANTS,
    *draws_table.MUTANTS,
    *engine_table.MUTANTS,
    *members_table.MUTANTS,
    *sensors_table.MUTANTS,
    *data_table.MUTANTS,
    *product_table.MUTANTS,
    *scene_table.MUTANTS,
    *command_table.MUTANTS,
    *propellant_table.MUTANTS,
    *trace_table.MUTANTS,
    *user_table.MUTANTS,
    *metrics_table.MUTANTS,
    *start_table.MUTANTS,
    *guidance_table.MUTANTS,
    *rare_table.MUTANTS,
    *replay_table.MUTANTS,
    *which_table.MUTANTS,
    *export_table.MUTANTS,
)
