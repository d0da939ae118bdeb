"""Mutants of sensors: noise that grows with the range, measurements that are not always new, knowledge of the target."""

from __future__ import annotations

from tests.mutants.mutant import Mutant

NOISE, LAST = "components/navigation/noise.py", "components/navigation/last_measurement.py"
UPDATE, DROPOUTS = "components/navigation/update_rate.py", "components/navigation/dropouts.py"
OUTAGE, TARGET = "components/navigation/outage.py", "components/navigation/target_knowledge.py"
LOOP = "simulation/closed_loop.py"
GROWS = "physics/test_sensors.py::test_noise_grows_with_the_range"
INSTANTS = "physics/test_sensors.py::test_an_update_comes_at_its_instants_and_is_held"
PROPAGATED = "physics/test_sensors.py::test_what_is_propagated_is_the_propagation_by_scipy"
KINEMATICS = "physics/test_sensors.py::test_a_propagated_measurement_obeys_the_kinematics"
LOST = "physics/test_sensors.py::test_measurements_are_lost_as_often_as_they_should"
LASTS = "physics/test_sensors.py::test_an_outage_lasts_as_long_as_it_was_drawn"
ENDS = "physics/test_sensors.py::test_an_outage_begins_and_ends_at_the_nearest_steps"
BELIEVED = "physics/test_target_knowledge.py::test_a_perfect_controller_flies_to_the_point_that_it_believes"
FORWARD = "physics/test_target_knowledge.py::test_errors_about_the_target_enter_the_feed_forward"
REFUSED = "campaign/test_campaign.py::test_bad_file"

MUTANTS = (
    Mutant("s + g|ρ|", NOISE, "v + s * s, variance", "(jnp.sqrt(v) + s) * (jnp.sqrt(v) + s), variance", GROWS),
    Mutant("growth with |ρ|²", NOISE, "g * g * range2", "g * g * range2 * range2", GROWS),
    Mutant("growth instead of s", NOISE, "v + s * s, variance", "v, variance", GROWS),
    Mutant("Ω without Rω_t", LAST, " + rotate(rotation(motion.sigma), numbers.known.target.w)", "", KINEMATICS),
    Mutant("Rᵀω_t for Rω_t", LAST, "rotation(motion.sigma), numbers", "rotation(-motion.sigma), numbers", KINEMATICS),
    Mutant("a ν that does not turn", LAST, "nu=rotate(frame, motion.nu)", "nu=motion.nu", KINEMATICS),
    Mutant("P that turns the other way", LAST, "frame = rotation(turning", "frame = rotation(-turning", KINEMATICS),
    Mutant(
        "an attitude that turns about axes of T",
        LAST,
        "compose(motion.omega * (0.25 * dt), motion.sigma)",
        "compose(motion.sigma, motion.omega * (0.25 * dt))",
        KINEMATICS,
    ),
    Mutant("a first step that is too long", LAST, "tick.t - last.begin_s", "tick.h", PROPAGATED),
    Mutant(
        "a step that begins at the measurement", LAST, "turning, t - last.begin_s)", "turning, t - last.measured_s)", PROPAGATED
    ),
    Mutant(
        "gyros that stand with the camera",
        LAST,
        "self._at(jnp.where(new, tick.t, last.measured_s), self._merged(latest, motion)",
        "self._at(jnp.where(new, tick.t, last.measured_s), latest",
        PROPAGATED,
    ),
    Mutant("an age of every step", LAST, "jnp.where(new, tick.t, last.measured_s)", "tick.t", INSTANTS),
    Mutant(
        "a list that is not read",
        LAST,
        "for name in self.parts}",
        "for name in QUANTITIES.values()}",
        "physics/test_sensors.py::test_an_update_concerns_what_is_named",
    ),
    Mutant("an update a step early", UPDATE, "(since + 0.5)", "(since + 1.5)", INSTANTS),
    Mutant("a phase on the other side", UPDATE, "tick.k - numbers.phase_s", "tick.k + numbers.phase_s", INSTANTS),
    Mutant("a period that is not whole", "simulation/problem.py", "if unfit:", "if len(unfit) > 1:", REFUSED),
    Mutant("an outage a step shorter", DROPOUTS, "(left < 0.5) & (outage", "(left < 1.5) & (outage", LASTS),
    Mutant("outages twice as often", DROPOUTS, "-expm1(-tick.h", "-expm1(-2.0 * tick.h", LOST),
    Mutant("an outage that is renewed", DROPOUTS, "(left < 0.5) & (outage", "(outage", LASTS),
    Mutant("losses of a sample at once", DROPOUTS, "numbers.noise, tick.k)", "numbers.noise, tick.k * 0)", LOST),
    Mutant("a duration for an end", OUTAGE, "now < numbers.start_s + numbers.duration_s", "now < numbers.duration_s", ENDS),
    Mutant("an outage a step late", OUTAGE, "(tick.k + 0.5) * tick.h", "(tick.k - 0.5) * tick.h", ENDS),
    Mutant("ρ + R e", TARGET, "motion.rho - rotate(turn, error)", "motion.rho + rotate(turn, error)", BELIEVED),
    Mutant("e in P", TARGET, "motion.rho - rotate(turn, error)", "motion.rho - error", FORWARD),
    Mutant("ν of the true point", TARGET, "motion.nu - rotate(turn, swing)", "motion.nu", BELIEVED),
    Mutant("a controller that knows the port", TARGET, 'port + numbers.port_m if "port_m"', 'port if "port_m"', FORWARD),
    Mutant("a target that is turned the other way", TARGET, "attitude_rad * 0.25", "attitude_rad * -0.25", FORWARD),
    Mutant("sign of the rate's error", TARGET, "w + numbers.rate_rad_s if", "w - numbers.rate_rad_s if", FORWARD),
    Mutant(
        "an ω̇_t that is not turned",
        TARGET,
        "r, v, w, alpha_t = (rotate(turn, x) for x in (r, v, w, alpha_t))",
        "r, v, w = (rotate(turn, x) for x in (r, v, w))",
        FORWARD,
    ),
    Mutant(
        "noise about the target that stands",
        "components/navigation/target_noise.py",
        "numbers.noise, tick.k, 3",
        "numbers.noise, tick.k * 0, 3",
        "physics/test_target_knowledge.py::test_noise_about_the_target_is_white_and_of_its_size",
    ),
    Mutant(
        "a controller that is told the truth",
        LOOP,
        "told.target, told.alpha_t, drawn, told.port",
        "y.target, alpha_t, drawn",
        FORWARD,
    ),
    Mutant(
        "an ω̇_t of the wrong rate",
        LOOP,
        "told.target, told.alpha_t, drawn, told.port)",
        "told.target, alpha(told.target, plant), drawn, told.port)",
        FORWARD,
    ),
    Mutant(
        "a start on the truth",
        LOOP,
        "known.target, known.alpha_t, drawn, known.port",
        "drawn.target, known.alpha_t, drawn, drawn.plant.port",
        "physics/test_target_knowledge.py::test_the_controller_starts_on_what_it_knows",
    ),
    Mutant(
        "the age of another sensor",
        "simulation/signals.py",
        "step.ages[index]",
        "step.ages[0]",
        "physics/test_sensors.py::test_lost_updates_of_a_flight_are_those_enacted_again",
    ),
    Mutant(
        "the longest key for the nearest",
        "campaign/fields.py",
        "key=lambda known: (len(stems[known]), -abs(len(known) - len(key)))",
        "key=len",
        REFUSED,
    ),
)
