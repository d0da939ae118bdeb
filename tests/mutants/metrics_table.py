"""Mutants of the metrics that a campaign chooses: contact, free drift, the lower bound on Δv."""

from __future__ import annotations

from tests.mutants.mutant import Mutant

CONTACT, DRIFT, FREE = "components/metrics/contact.py", "components/metrics/passive_safety.py", "physics/free_motion.py"
PRIMER, FUEL = "physics/primer.py", "components/metrics/fuel_bound.py"
TRACE = "physics/test_contact.py::test_contact_against_the_trace"
FIRST = "physics/test_contact.py::test_the_first_contact_from_outside_counts"
NONE = "physics/test_contact.py::test_without_contact_nothing_complies"
TURNS = "physics/test_contact.py::test_pitch_and_roll_of_turns_about_one_axis"
ABSOLUTE = "physics/test_passive_safety.py::test_a_drift_is_that_of_two_absolute_orbits"
HOLDS = "physics/test_passive_safety.py::test_hold_points_as_in_the_linear_equations"
COUNTS = "physics/test_passive_safety.py::test_only_instants_outside_the_ball_and_after_the_fault_count"
HORIZON = "physics/test_passive_safety.py::test_the_drift_ends_at_its_horizon"
LOOKED = "physics/test_passive_safety.py::test_a_flight_is_looked_at_at_its_instants"
STEPS = "physics/test_passive_safety.py::test_another_step_is_another_program"
BEST = "physics/test_fuel_bound.py::test_it_lies_just_below_the_best_impulses"
BETWEEN = "physics/test_fuel_bound.py::test_an_impulse_between_two_points_of_the_grid_is_not_dearer_than_it_is"
END = "physics/test_fuel_bound.py::test_the_end_is_the_docking_point_with_its_velocity"
NOTHING = "physics/test_fuel_bound.py::test_nothing_to_do_costs_nothing"

MUTANTS = (
    Mutant(
        "a keep-out that a collision makes NaN", "components/metrics/keep_out.py", ", safety=True)", ")",
        "physics/test_collided_flights.py::test_chosen_metrics_of_a_collided_flight",
    ),
    Mutant(
        "a contact after a collision", CONTACT, "start, update, finish)", "start, update, finish, safety=True)",
        "physics/test_collided_flights.py::test_chosen_metrics_of_a_collided_flight",
    ),
    # contact
    Mutant("a port that does not turn", CONTACT, " - cross(step.target.w, rho)", "", TRACE),
    Mutant("an interface that does not turn", CONTACT, "motion.nu + cross(motion.omega, place)", "motion.nu", TRACE),
    Mutant("an interface in the target", CONTACT, "rho + rotate_back(r, place) - place", "rho + place - place", TRACE),
    Mutant("rates in the pursuer's frame", CONTACT, "rate = rotate_back(r, motion.omega)", "rate = motion.omega", TRACE),
    Mutant("the step after the contact", CONTACT, "old + share * (new - old)", "new + share * 0.0", TRACE),
    Mutant("the time of the step", CONTACT, "step.t - (1.0 - share) * context.step_s", "step.t", FIRST),
    Mutant("away counts as closing", CONTACT, "-dot(a, speed)", "dot(a, speed)", TRACE),
    Mutant("half an angle", CONTACT, "jnp.rad2deg(2.0 * atan2(along, cos))", "jnp.rad2deg(atan2(along, cos))", TURNS),
    Mutant("a swing with the roll in it", CONTACT, "jnp.sqrt(cos * cos + along * along)", "cos", TRACE),
    Mutant("who begins inside has contact", CONTACT, "(acc.axial > distance) & (axial", "(axial", FIRST),
    Mutant(
        "contact far from the axis", CONTACT, "(between.lateral <= context.numbers.radius_m)", "(between.lateral >= 0.0)", FIRST,
    ),
    Mutant("the last contact", CONTACT, "& (acc.time == jnp.inf)", "& (acc.time >= 0.0)", FIRST),
    Mutant("no contact is infinite", CONTACT, "zero + jnp.nan", "zero + jnp.inf", NONE),
    Mutant(
        "no docking axis, no word", CONTACT, "if has(campaign.target.port_m, 0.0)", "if False",
        "physics/test_contact.py::test_a_file_with_no_docking_axis_says_that_nothing_is_measured",
    ),
    # free drift
    Mutant("a velocity in the turning frame", FREE, " + cross(target.w, port)\n    return", "\n    return", ABSOLUTE),
    Mutant("the docking point for the centre", FREE, "rotate_back(r, motion.rho) + port", "rotate_back(r, motion.rho)", HOLDS),
    Mutant("no gravity between the two", FREE, "differential_gravity(y.r, y.delta))", "y.delta * 0.0)", ABSOLUTE),
    Mutant("a target that falls along a line", FREE, "gravity(y.r), y.speed", "y.r * 0.0, y.speed", ABSOLUTE),
    Mutant("the steps of the drift only", DRIFT, "jnp.where(turns, lowest, last)", "last", ABSOLUTE),
    Mutant("a step too few", DRIFT, "fori_loop(0, steps, stepped", "fori_loop(1, steps, stepped", HORIZON),
    Mutant(
        "instants inside the ball", DRIFT,
        "counts = norm(begin.delta) > context.numbers.radius_m",
        "counts = step.t >= 0.0", COUNTS,
    ),
    Mutant("before the fault", DRIFT, "counts & (step.t >= context.last_onset_s) & (", "counts & (", COUNTS),
    Mutant("without a fault", DRIFT, " & (context.last_onset_s > -jnp.inf)", "", COUNTS),
    Mutant(
        "time after the end", DRIFT,
        "jnp.clip(context.duration_s - step.t, 0.0, parameters.every_s)",
        "parameters.every_s", COUNTS,
    ),
    Mutant("every step", "simulation/flight.py", "if metric.every == 1:", "if True:", LOOKED),
    Mutant("instants off by a step", "simulation/flight.py", "k % metric.every == 0", "k % metric.every == 1", LOOKED),
    Mutant("one program for all steps", "campaign/model.py", '"periods": periods,', '"periods": (),', STEPS),
    # the lower bound on Δv
    Mutant("sign of ṗᵀΔ", PRIMER, "p * v - (rate / time) * d", "p * v + (rate / time) * d", BEST),
    Mutant(
        "the end in the axes of the begin", PRIMER,
        "_moment(last, end, time)",
        "_moment(last._replace(place=first.place), end, time)", BEST,
    ),
    Mutant("gravity's gradient of a sphere", PRIMER, "across * now.place[0] - pull * now.x", "-pull * now.x", BEST),
    Mutant("an orbit that stands", PRIMER, "            -pull * now.place,\n", "            0.0 * now.place,\n", BEST),
    Mutant("Newton steps uphill", PRIMER, "- downhill", "+ downhill", BEST),
    Mutant("the first c", PRIMER, "(c + _newton(b, sums)) / largest", "c / largest", BEST),
    Mutant("no allowance", PRIMER, " * _allowance(begin, time)", "", BETWEEN),
    Mutant("NaN of nothing", PRIMER, "jnp.where(bound > best, bound, best) * _", "bound * _", NOTHING),
    Mutant("an end at rest", FUEL, "port, cross(target.w, port))", "port, port * 0.0)", END),
    Mutant("the last step for the first", FUEL, "jnp.where(step.t == 0.0, new, old)", "jnp.where(step.t >= 0.0, new, old)", END),
    Mutant("the bound over Δv", FUEL, "used / bound", "bound / used", END),
)  # fmt: skip
