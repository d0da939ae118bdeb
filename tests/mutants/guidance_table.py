"""Mutants of guidance: the reference point, its frames, its limits, and what a controller gets of it."""

from __future__ import annotations

from tests.mutants.mutant import Mutant

INTERFACE, CORRIDOR = "components/guidance/interface.py", "components/guidance/corridor.py"
WAYPOINTS, ORBIT = "components/guidance/waypoints.py", "physics/orbit_frame.py"
LOOP, CHECKS = "simulation/closed_loop.py", "simulation/guidance_checks.py"
PROOF = "physics/test_guided_flight.py::test_the_error_about_a_moving_point_falls_as_the_proof_of_pd_plus_says"
DOCUMENTED = "physics/test_guided_flight.py::test_a_trace_has_the_reference_point_of_the_documentation"
INSTANT = "physics/test_guided_flight.py::test_within_a_step_the_controller_sees_the_point_of_the_instant"
TOLD = "physics/test_guided_flight.py::test_a_user_s_controller_is_told_how_the_point_moves"
PURSUER = "physics/test_guided_flight.py::test_a_waypoint_waits_for_the_pursuer"
CLOSE = "physics/test_guided_flight.py::test_the_corridor_waits_for_the_pursuer"
WAY = "physics/test_guided_flight.py::test_there_is_a_way_round_from_everywhere"
SLOPES = "physics/test_guided_flight.py::test_the_point_s_numbers_can_be_differentiated"
JUMPS = "physics/test_guidance.py::test_the_point_moves_without_jumps"
OUTSIDE = "physics/test_guidance.py::test_the_point_stays_outside_until_it_is_in_the_axis"
LIMITS = "physics/test_guidance.py::test_the_point_keeps_its_limits"
REST = "physics/test_guidance.py::test_far_away_the_point_is_at_rest_in_lvlh"
ROUND = "physics/test_guidance.py::test_a_start_behind_the_target_goes_round"
WAITS = "physics/test_guidance.py::test_the_point_waits_for_a_pursuer_that_is_not_aligned"
STEEP = "physics/test_guidance.py::test_a_steep_profile_is_flattened"
ORDER = "physics/test_guidance.py::test_waypoints_are_passed_in_their_order"
STILL = "physics/test_guidance.py::test_a_waypoint_of_lvlh_is_held_still"
FRAME = "physics/test_orbit_frame.py::test_the_orbit_frame_is_that_of_its_definition"
PORT = "physics/test_orbit_frame.py::test_the_port_s_frame_is_the_shortest_turn"
BAD = "campaign/test_campaign.py::test_bad_file"
WARNED = "campaign/test_plausibility.py::test_a_warning_names_the_numbers_and_what_would_be_right"

MUTANTS = (
    # what a controller gets
    Mutant("no 2ω_t×ṗ", "physics/dynamics.py", "cross(measurement.target.w, velocity) * 2.0 + accel", "accel", PROOF),
    Mutant(
        "ω_t×ṗ once", "physics/dynamics.py", "(measurement.target.w, velocity) * 2.0", "(measurement.target.w, velocity)", PROOF
    ),
    Mutant("no p̈", "physics/dynamics.py", "velocity) * 2.0 + accel", "velocity) * 2.0", PROOF),
    Mutant(
        "the other sign of ω_t×p",
        INTERFACE,
        "carried = cross(target.w, path.point) + path.velocity",
        "carried = cross(path.point, target.w) + path.velocity",
        PROOF,
    ),
    Mutant(
        "a velocity without ṗ",
        INTERFACE,
        "carried = cross(target.w, path.point) + path.velocity",
        "carried = cross(target.w, path.point)",
        PROOF,
    ),
    Mutant("a port that stays", INTERFACE, "port=measurement.port + path.point", "port=measurement.port", PROOF),
    Mutant("a point that is held during a step", LOOP, "memory.path.at(view.t))", "memory.path)", INSTANT),
    Mutant("½p̈τ² as p̈τ²", "physics/state.py", "(self.velocity + velocity) * (0.5 * since)", "velocity * since", JUMPS),
    Mutant(
        "a controller that is told of a point at rest",
        "components/forms/measured.py",
        "(measurement.moving, PointMotion)",
        "(measurement.moving, str)",
        TOLD,
    ),
    # the reference point
    Mutant("u' once", INTERFACE, "relative * 2.0 + carried", "relative + carried", DOCUMENTED),
    Mutant("no c×(c×q)", INTERFACE, "relative * 2.0 + carried)", "relative * 2.0)", STILL),
    Mutant("no ċ×q", INTERFACE, " + cross(swing, q)", "", REST),
    Mutant(
        "a velocity of the reference point in T",
        INTERFACE,
        "relative = path.velocity - carried",
        "relative = path.velocity",
        STILL,
    ),
    Mutant(
        "no limit of the acceleration",
        INTERFACE,
        "numbers.time_constant_s), numbers.acceleration)",
        "numbers.time_constant_s), numbers.acceleration * 2.0)",
        LIMITS,
    ),
    Mutant(
        "a point that starts at rest in T",
        INTERFACE,
        "    path = Path(situation.t, point, velocity,",
        "    path = Path(situation.t, point, velocity * 0.0,",
        DOCUMENTED,
    ),
    Mutant(
        "a root of 0 in a limit",
        INTERFACE,
        "jnp.sqrt(jnp.maximum(dot(a, a), most * most))",
        "jnp.maximum(jnp.sqrt(dot(a, a)), most)",
        SLOPES,
    ),
    Mutant(
        "a slope as it is given", INTERFACE, "jnp.minimum(numbers.slope, 0.25 / numbers.time_constant_s)", "numbers.slope", STEEP
    ),
    Mutant("a speed as it is given", INTERFACE, "jnp.minimum(speed, numbers.acceleration / slope)", "speed", STEEP),
    # corridor
    Mutant(
        "the line behind the target as the axis", CORRIDOR, "BESIDE * along + LEAST", "BESIDE * jnp.abs(along) + LEAST", ROUND
    ),
    Mutant("nothing opposite to the gate", CORRIDOR, "jnp.where(opposite, o, a)", "a", WAY),
    Mutant("no look at the attitude", CORRIDOR, "-close * aligned * profile", "-close * profile", WAITS),
    Mutant("no look at the pursuer's place", CORRIDOR, "-close * aligned * profile", "-aligned * profile", CLOSE),
    Mutant("a turning that is taken on at once", CORRIDOR, " + orbit.rate * rate)", ")", OUTSIDE),
    Mutant("going round before it turns", CORRIDOR, "round_it * (1.0 - rest)", "round_it", REST),
    Mutant(
        "rest in T",
        CORRIDOR,
        "Turning(orbit.rate * rest, orbit.accel * rest",
        "Turning(orbit.rate * 0.0, orbit.accel * 0.0",
        REST,
    ),
    Mutant(
        "no end speed",
        CORRIDOR,
        "jnp.maximum(slope * along, jnp.minimum(end",
        "jnp.minimum(slope * along, jnp.minimum(end",
        OUTSIDE,
    ),
    # waypoints
    Mutant("a clock that is not set back", WAYPOINTS, "situation.t), jnp.inf)", "situation.t), situation.t)", ORDER),
    Mutant("no time to hold", WAYPOINTS, "situation.t >= since + hold", "situation.t >= since", ORDER),
    Mutant("no look at the pursuer", WAYPOINTS, " & (length(goal - pursuer) <= within)", "", PURSUER),
    Mutant("a point that leaves the pursuer behind", WAYPOINTS, " * granted(pursuer - path.point, numbers.lag_m)", "", PURSUER),
    Mutant(
        "the other frame's turning",
        WAYPOINTS,
        "goal, orbit_turning(situation.target, situation.alpha_t), numbers",
        "goal, orbit_turning(situation.target, situation.alpha_t).scaled(0.0), numbers",
        STILL,
    ),
    Mutant(
        "LVLH from the port",
        WAYPOINTS,
        "rotate_back(orbit_axes(situation.target), at) - situation.port",
        "rotate_back(orbit_axes(situation.target), at)",
        STILL,
    ),
    Mutant("from T for from LVLH", WAYPOINTS, "rotate_back(orbit_axes(situation.target), at) -", "at -", STILL),
    Mutant("from T for from the port", WAYPOINTS, "rotate_back(port_axes(situation.axis), at), turning", "at, turning", ORDER),
    # frames
    Mutant("ω_t×ω_o for −ω_t×ω_o", ORBIT, "cross(rate, target.w)", "cross(target.w, rate)", FRAME),
    Mutant("a rate that does not know r", ORBIT, " - rate * (2.0 * dot(target.r, target.v) * inverse)", "", FRAME),
    Mutant("no ω̇_t", ORBIT, "swing - alpha_t)", "swing)", FRAME),
    Mutant("LVLH that stands still", ORBIT, "Turning(rate - target.w,", "Turning(-target.w,", FRAME),
    Mutant("H-bar along h", ORBIT, "h * (-1.0 / norm(h))", "h * (1.0 / norm(h))", FRAME),
    Mutant("the port's y axis with another sign", ORBIT, "Vector(-n.y, 1.0", "Vector(n.y, 1.0", PORT),
    Mutant("cancellation near −x", ORBIT, "back = n.x < 0.0", "back = n.x < -2.0", PORT),
    # checks
    Mutant("a time constant of any length", CHECKS, "< STEPS * spec.horizon.step_s", "< 0.0 * spec.horizon.step_s", BAD),
    Mutant("any port of a guidance", CHECKS, "not spec.target.has_docking_axis", "spec.target.rate_rad_s is None", BAD),
    Mutant("any orbit of a guidance", CHECKS, 'need == "orbit" and', 'need == "" and', BAD),
    Mutant("any gate", CHECKS, "np.count_nonzero(distance < reach)", "np.count_nonzero(distance < 0.0)", BAD),
    Mutant("any acceleration of the point", "simulation/plausibility.py", "if accel > able:", "if accel > 9.0 * able:", WARNED),
    Mutant(
        "any speed of the point", "simulation/plausibility.py", "speed * steep > accel", "speed * steep > 9.0 * accel", WARNED
    ),
    Mutant("an end anywhere", "simulation/plausibility.py", "away > spec.capture.position_m:", "away > 99.0:", WARNED),
)
