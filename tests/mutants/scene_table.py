"""Mutants of hulls, collisions, the keep-out zone, the corridor, and of what counts as failed."""

from __future__ import annotations

from tests.mutants.mutant import Mutant

HULLS, COLLISION = "physics/hulls.py", "components/metrics/collision.py"
ZONE, CHECKS = "simulation/start_zone.py", "simulation/scene_checks.py"
PLAUSIBILITY = "simulation/plausibility.py"
ROOM = "campaign/test_plausibility.py::test_docked_hulls_are_farther_apart_than_the_capture_radius"
REST, BETWEEN = "physics/test_hulls.py::test_the_bound_at_rest", "physics/test_hulls.py::test_the_bound_between_two_instants"
BOXES = "physics/test_hulls.py::test_boxes_are_apart_or_not"
COUNTED = "physics/test_hulls.py::test_collisions_are_counted_to_the_sample"
PLACE = "physics/test_hulls.py::test_a_collision_has_its_time_its_place_and_its_speed"
TIMES = "physics/test_hulls.py::test_times_in_the_zone_and_outside_of_the_corridor"
STARTS = "campaign/test_scene_checks.py::test_a_forbidden_start_is_found_where_there_is_one"
REFUSED = "campaign/test_scene_checks.py::test_starts_are_refused_or_not"
APART = "campaign/test_scene_checks.py::test_hulls_are_apart_when_docked_and_at_the_start"

OUTCOME = "physics/test_hulls.py::test_the_first_that_holds_is_the_outcome"
TURNED = "campaign/test_scene_checks.py::test_the_start_is_turned_as_it_flies"
MARGIN = "physics/test_hulls.py::test_the_bound_of_the_acceleration"
STEPPED = "physics/test_hulls.py::test_nothing_is_stepped_over"

MUTANTS = (
    Mutant("no Coriolis term", COLLISION, " + 2.0 * turn * length(velocity)", "", MARGIN),
    Mutant("no lever of the force", COLLISION, " + length(plant.centre) * length(most.force)", "", MARGIN),
    Mutant("no total wrench", COLLISION, "length(most.force) + length(wrench.force)", "length(most.force)", MARGIN),
    Mutant("the larger of both ends", HULLS, "kept = jnp.minimum(", "kept = jnp.maximum(", BETWEEN),
    Mutant(
        "a hull's centre with the other sign", HULLS, "pursuer.centre) - target.centre", "pursuer.centre) + target.centre", REST
    ),
    Mutant(
        "the pursuer's centre in T", HULLS, "mass_centre + rotate_back(r, pursuer.centre)", "mass_centre + pursuer.centre", REST
    ),
    Mutant("no cross products of edges", HULLS, "for a in AXES for b in turned)", "for a in AXES for b in AXES)", BOXES),
    Mutant("a single projection", HULLS, "ROUNDS = 4\n", "ROUNDS = 1\n", BOXES),
    Mutant(
        "a root of 0",
        HULLS,
        "jnp.sqrt(dot(a, a) + TINY)",
        "jnp.sqrt(dot(a, a))",
        "physics/test_hulls.py::test_the_clearance_has_a_derivative",
    ),
    Mutant("the sign of A h²/8", COLLISION, "before, now) - margin", "before, now) + margin", MARGIN),
    Mutant("no A h²/8", COLLISION, "before, now) - margin", "before, now) - 0.0 * margin", MARGIN),
    Mutant("a hull from the centre of mass", COLLISION, "pursuer.centre - step.plant.centre", "pursuer.centre", COUNTED),
    Mutant(
        "a contact at the steps only", COLLISION, "jnp.where(first, new, old), now", "jnp.where(first, new, new), now", STEPPED
    ),
    Mutant("the last contact for the first", COLLISION, "(distance <= 0.0) & (acc.time == jnp.inf)", "(distance <= 0.0)", PLACE),
    Mutant("the inertial velocity", COLLISION, "step.motion.nu) - cross(step.target.w, rho)", "step.motion.nu)", PLACE),
    Mutant(
        "collided is no failure",
        "columns.py",
        'FAILED = ("collided", "not_finite")',
        'FAILED = ("not_finite",)',
        "stats/test_verdicts.py::test_lost_and_collided_samples_fail_everything",
    ),
    Mutant(
        "a collided flight is captured",
        "simulation/tables.py",
        '"collided": (collided, collision),',
        '"collided": (collided & ~captured, collision),',
        OUTCOME,
    ),
    Mutant("metrics after a collision", "simulation/tables.py", "np.where(collided, name in stays, finite)", "finite", PLACE),
    Mutant(
        "an apex in front of the port",
        "components/metrics/approach.py",
        "q = rho + context.axis",
        "q = rho - context.axis",
        TIMES,
    ),
    Mutant(
        "a corridor without an end",
        "components/metrics/approach.py",
        "distance <= context.funnel.length_m",
        "distance >= 0.0",
        TIMES,
    ),
    Mutant(
        "the zone inside the cone", "components/metrics/keep_out_zone.py", "< 1.0) & outside_cone(rho, context)", "< 1.0)", TIMES
    ),
    Mutant("half axes as axes", "components/metrics/keep_out_zone.py", "x / a, rho", "2.0 * x / a, rho", TIMES),
    Mutant(
        "a part that is dropped",
        ZONE,
        "np.concatenate([middles - step, middles + step])",
        "np.concatenate([middles - step, middles - step])",
        STARTS,
    ),
    Mutant("the middle of a part for its corners", ZONE, "rho + (halves * corner) @", "rho + 0.0 * (halves * corner) @", STARTS),
    Mutant(
        "R for Rᵀ at the start",
        CHECKS,
        "(axes.a, axes.b, axes.c)]).T",
        "(axes.a, axes.b, axes.c)])",
        TURNED,
    ),
    Mutant("hulls that may touch inside the tube", PLAUSIBILITY, "& (distance < tube)", "& (distance < 0.0)", ROOM),
    Mutant("twice the capture radius", PLAUSIBILITY, "& (distance < tube)", "& (distance < 2.0 * tube)", ROOM),
    Mutant("the start for the docked pose", CHECKS, "drawn.motion.rho * 0.0,", "drawn.motion.rho * 1.0,", ROOM),
    Mutant("an uncertain cone", CHECKS, "else NO_CONE", "else float(cos(corridor.half_angle_rad))", REFUSED),
    Mutant(
        "the hull from the reference point when docked",
        CHECKS,
        "centre=pursuer.centre - drawn.plant.centre",
        "centre=pursuer.centre",
        APART,
    ),
    Mutant(
        "a lonely hull",
        "simulation/effect.py",
        "if len(missing) == 1:",
        "if len(missing) == 3:",
        "campaign/test_campaign.py::test_bad_file",
    ),
    Mutant(
        "collided after not settled",
        "analysis/run_totals.py",
        '"collided": 1, "not_settled": 2',
        '"collided": 2, "not_settled": 1',
        "stats/test_totals.py::test_worst_rows_are_those_of_a_full_sort",
    ),
    Mutant(
        "the speeds of all samples",
        "report/sections/safety.py",
        "for back in (collided - 1, collided // 2, 0))",
        "for back in (speeds.n - 1, speeds.n // 2, 0))",
        "report/test_safety.py::test_the_numbers_of_the_section",
    ),
    Mutant(
        "a section on safety in every report",
        "report/sections/safety.py",
        "    if not measured:\n        return None\n",
        "",
        "report/test_safety.py::test_the_section_is_there_where_there_is_something_to_say",
    ),
    Mutant(
        "LVLH about the docking point",
        CHECKS,
        "(away, away - port_0) if centred",
        "(away + port_0, away) if centred",
        TURNED,
    ),
    Mutant("ρ without the drawn docking point", CHECKS, "by_port * (-1.0 if centred", "by_port * (0.0 if centred", TURNED),
)
