"""Mutants of propellant, of the body that is left, and of the effort of the actuators."""

from __future__ import annotations

from tests.mutants.mutant import Mutant

PROPELLANT, LOOP = "physics/propellant.py", "simulation/closed_loop.py"
EFFORT, CHECK = "components/metrics/effort.py", "campaign/propellant.py"
LEFT = "physics/test_propellant.py::test_what_is_left_is_that_of_its_point_masses"
ROCKET = "physics/test_propellant.py::test_tsiolkovsky"
TUMBLING = "physics/test_propellant.py::test_a_tumbling_flight_is_that_of_scipy"
EMPTY = "physics/test_propellant.py::test_with_an_empty_tank_forces_end"
BURNT = "physics/test_propellant.py::test_what_is_burnt_is_what_the_thrusters_gave"
CHANNELS = "physics/test_propellant.py::test_what_is_burnt_is_what_the_channels_gave"
LASTS = "physics/test_propellant.py::test_the_last_thrust_lasts_to_the_end_of_its_step"
INSTANT = "physics/test_propellant.py::test_all_see_the_plant_of_the_instant"
NOTHING = "physics/test_propellant.py::test_thrusters_with_an_empty_tank_give_nothing"
ACCEPTED = "campaign/test_propellant.py::test_accepted_is_what_no_draw_can_break"
ANY_WAY = "campaign/test_propellant.py::test_accepted_whatever_way_it_points"
ACTS = "campaign/test_propellant.py::test_every_draw_reaches_the_flight_and_acts"
SPACE = "tuning/test_space.py::test_programs_are_told_apart_by_functions_not_by_numbers"

MUTANTS = (
    Mutant("a specific impulse that is forgotten", PROPELLANT, "(propellant.specific_impulse * G0)", "(200.0 * G0)", ROCKET),
    Mutant(
        "a specific impulse as a speed", PROPELLANT, "(propellant.specific_impulse * G0)", "propellant.specific_impulse", ROCKET
    ),
    Mutant("the mass at t = 0 in the acceleration", PROPELLANT, "_replace(mass=mass, ", "_replace(", ROCKET),
    Mutant("a centre that moves toward the tank", PROPELLANT, "plant.centre - d *", "plant.centre + d *", LEFT),
    Mutant("a transfer without the way of the centre", PROPELLANT, "used * plant.mass / mass", "used", LEFT),
    Mutant("the sign of the products of the tank", PROPELLANT, "-(y * z), -(x * z)", "y * z, x * z", LEFT),
    Mutant("the inverse inertia at t = 0", PROPELLANT, "inertia_inverse=inverse(inertia), ", "", TUMBLING),
    Mutant("opposing thrusters that cancel", EFFORT, "thrust_sum(step.applied, step.thrusts)", "norm(step.applied.force)", BURNT),
    Mutant(
        "a force that is burnt, not the thrusts",
        PROPELLANT,
        "if isinstance(thrusts, Thrusts) else total",
        "if False else total",
        BURNT,
    ),
    Mutant("Δv by the impulse alone", EFFORT, "impulse / step.plant.mass", "impulse", BURNT),
    Mutant("forces with their sign", PROPELLANT, "total(each(jnp.abs, applied.force))", "total(applied.force)", CHANNELS),
    Mutant(
        "an arm that multiplies", PROPELLANT, "applied.torque)) / propellant.arm", "applied.torque)) * propellant.arm", CHANNELS
    ),
    Mutant("torques that burn nothing", PROPELLANT, "if not isinstance(propellant.arm, tuple)", "if False", CHANNELS),
    Mutant(
        "a tank that never empties",
        PROPELLANT,
        "consumed < propellant.mass, 1.0, 0.0",
        "consumed < propellant.mass, 1.0, 1.0",
        EMPTY,
    ),
    Mutant("a mass below the empty body's", PROPELLANT, "jnp.minimum(consumed, propellant.mass)", "consumed", EMPTY),
    Mutant(
        "wheels that stop with the propellant",
        PROPELLANT,
        "applied.torque if isinstance(propellant.arm, tuple)",
        "applied.torque * fed if isinstance(propellant.arm, tuple)",
        EMPTY,
    ),
    Mutant(
        "a wrench without its thrusts",
        PROPELLANT,
        "return applied * fed, thrusts * fed",
        "return applied, thrusts * fed",
        NOTHING,
    ),
    Mutant(
        "thrusts that are looked up within a step",
        LOOP,
        "fed if tick is None else feeds(drawn.propellant, consumed)",
        "feeds(drawn.propellant, consumed)",
        LASTS,
    ),
    Mutant(
        "disturbances on the plant at t = 0",
        LOOP,
        "disturbance.push(t, y, known, plant, now, numbers)",
        "disturbance.push(t, y, known, drawn.plant, now, numbers)",
        INSTANT,
    ),
    Mutant(
        "effects on the plant at t = 0",
        LOOP,
        "y.effects, t, known, plant, wrench)",
        "y.effects, t, known, drawn.plant, wrench)",
        INSTANT,
    ),
    Mutant(
        "a moment about the centre at t = 0",
        LOOP,
        "cross(plant.centre, applied.force)",
        "cross(drawn.plant.centre, applied.force)",
        TUMBLING,
    ),
    Mutant("the full tank alone is checked", CHECK, "m * most / (m - most)", "0.0 * m", ACCEPTED),
    Mutant("the heaviest pursuer alone is checked", CHECK, "sorted({lightest, heaviest})", "[heaviest]", ACCEPTED),
    Mutant("a tank from the centre of mass", CHECK, "box[6:9], box[9:12] - box[6:9]", "box[6:9], box[9:12]", ACCEPTED),
    Mutant("a free tank without its distance", CHECK, "kappa * (r + c) * (r + c)", "kappa * c * c", ANY_WAY),
    Mutant(
        "propellant as heavy as the pursuer",
        CHECK,
        "if not most < lightest:",
        "if not most < 2.0 * lightest:",
        "spec/test_bad_files.py::test_bad_file",
    ),
    Mutant(
        "full tanks alone are redrawn",
        "simulation/inertia.py",
        "physical(entries) & physical(about_centre(entries, m * p / (m - p), (x, y, z)))",
        "physical(entries)",
        "campaign/test_propellant.py::test_rejected_bodies_exist_with_an_empty_tank_too",
    ),
    Mutant("an arm that the flight does not get", "simulation/draws.py", 'values.get("torque_arm_m", ())', "()", ACTS),
    Mutant(
        "one program with and without an arm",
        "campaign/model.py",
        '"propellant": self.pursuer.propellant',
        '"propellant": self.pursuer.propellant is None',
        SPACE,
    ),
    Mutant(
        "columns of propellant in every campaign",
        "components/registry.py",
        "if all(map(given, metric.needs))",
        "if True",
        "campaign/test_propellant.py::test_without_propellant_nothing_is_there",
    ),
)
