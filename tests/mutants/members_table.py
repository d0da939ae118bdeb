"""Mutants of other controllers, navigation, sampled control and temporal margins."""

from __future__ import annotations

from tests.mutants.mutant import Mutant

ORDER = "physics/test_navigation.py::test_errors_act_in_the_order_of_the_campaign"
WHITE = "physics/test_navigation.py::test_noise_is_white_and_of_its_size"
BIAS = "physics/test_navigation.py::test_a_bias_is_the_one_that_was_drawn"
GYRO = "physics/test_navigation.py::test_the_bias_of_a_gyro_wanders_by_the_root_of_time"
SLIDING, NOMINAL = "components/controllers/sliding_mode.py", "components/controllers/nominal_backstepping.py"
WINDUP, FILTERED = "components/controllers/anti_windup.py", "components/controllers/command_filtered.py"
OBSERVER = "components/controllers/disturbance_observer.py"
LAYER = "physics/test_baselines.py::test_the_sliding_variable_falls_to_its_boundary_layer"
PROOF = "physics/test_baselines.py::test_nominal_backstepping_falls_as_its_proof_says"
CLIP = "physics/test_baselines.py::test_nominal_backstepping_stays_inside_the_nominal_limits_and_winds_up"
WITHHELD = "physics/test_baselines.py::test_anti_windup_takes_the_saturation_out_of_the_error"
RESTS = "physics/test_baselines.py::test_anti_windup_rests_while_nothing_is_saturated"
RAMP = "physics/test_baselines.py::test_command_filter_lags_a_ramp_by_its_time"
COMPENSATED = "physics/test_baselines.py::test_compensated_errors_know_of_neither_filter_nor_saturation"
LAG = "physics/test_baselines.py::test_disturbance_observer_is_a_first_order_lag"
FOUND = "physics/test_baselines.py::test_a_constant_disturbance_is_found_at_the_observers_rate"
BY_HAND = "physics/test_sampling.py::test_a_sampled_flight_is_the_one_written_by_hand"
MARGINS = "simulation/temporal_margins.py"
DEFINITION = "physics/test_margins.py::test_folds_are_the_definition_on_random_traces"
OF_ITS_TRACE = "physics/test_margins.py::test_a_flight_has_the_margins_of_its_trace"

MUTANTS = (
    # baselines
    Mutant("sign of the switching term", SLIDING, "*nominal(gains)) + reach", "*nominal(gains)) - reach", LAYER),
    Mutant("a boundary layer that multiplies", SLIDING, "now.z2 / Channels", "now.z2 * Channels", LAYER),
    Mutant("an unbounded switching term", SLIDING, "each(lambda x: jnp.clip(x, -1.0, 1.0), depth)", "depth", LAYER),
    Mutant("no feed-forward", SLIDING, "-(model(now, *nominal(gains)) + reach", "-(reach", LAYER),
    Mutant(
        "sign of Cα₁",
        "physics/backstepping.py",
        "return -Channels.pair(gains.c_force",
        "return Channels.pair(gains.c_force",
        PROOF,
    ),
    Mutant("no K₂z₂", "physics/backstepping.py", "(feedback(now.z2, gains) + first_error", "(first_error", PROOF),
    Mutant(
        "clip at swapped limits",
        NOMINAL,
        "-measurement.lower, measurement.upper)",
        "-measurement.upper, measurement.lower)",
        CLIP,
    ),
    Mutant("no clip", NOMINAL, "each(jnp.clip, wanted, -measurement.lower, measurement.upper)", "wanted", CLIP),
    Mutant("adaptation that stands still", NOMINAL, "adaptation(now, now.z2,", "adaptation(now, now.z2 * 0.0,", PROOF),
    Mutant("ζ on the other side", WINDUP, "now.z2 - state.zeta", "now.z2 + state.zeta", WITHHELD),
    Mutant("no leak in the law", WINDUP, "state.inertia, gains) - leak", "state.inertia, gains)", WITHHELD),
    Mutant("sign of what is withheld", WINDUP, "zeta=h - command - leak", "zeta=command - h - leak", WITHHELD),
    Mutant("ζ fed by the command", WINDUP, "zeta=h - command - leak", "zeta=h - leak", RESTS),
    Mutant("half the damping", FILTERED, "-2.0 * gains.filter_damping", "-gains.filter_damping", RAMP),
    Mutant("ω_n for ω_n²", FILTERED, "(omega * omega)", "omega", RAMP),
    Mutant("a filter from zero", FILTERED, "alpha, zero, zero, zero)", "zero, zero, zero, zero)", RAMP),
    Mutant(
        "sign of the filter's error",
        FILTERED,
        "lagging + (state.filtered - alpha)",
        "lagging - (state.filtered - alpha)",
        COMPENSATED,
    ),
    Mutant("no ξ₂ in ξ₁", FILTERED, "(state.filtered - alpha) + state.xi2", "(state.filtered - alpha)", COMPENSATED),
    Mutant("no Ω×ξ_ρ", FILTERED, "missed.force - cross(known.omega_p, state.xi1.force)", "missed.force", COMPENSATED),
    Mutant("G for Gᵀ", FILTERED, "mrp_rate(-sigma, z1.torque)", "mrp_rate(sigma, z1.torque)", COMPENSATED),
    Mutant("ξ₂ without K₂", FILTERED, "(h - command - feedback(state.xi2, gains))", "(h - command)", COMPENSATED),
    Mutant("adaptation by z₂", FILTERED, "now.z2 - state.xi2, state.mass", "now.z2, state.mass", COMPENSATED),
    Mutant(
        "an α̇_f that is not used",
        FILTERED,
        "known, state.filtered, state.filtered_rate)",
        "known, state.filtered, alpha * 0.0)",
        COMPENSATED,
    ),
    Mutant("v for h(v)", OBSERVER, "+ h + estimate", "+ command + estimate", LAG),
    Mutant("an observer without its lag", OBSERVER, "+ h + estimate", "+ h", LAG),
    Mutant("a start with L M₀x₂", OBSERVER, "Control(-momentum(", "Control(momentum(", LAG),
    Mutant("L that is missing once", OBSERVER, "-(speed * (model", "-((model", LAG),
    Mutant("D̂ that is added", OBSERVER, "*theta, gains) - estimate", "*theta, gains) + estimate", FOUND),
    # navigation
    Mutant(
        "sign in compose",
        "physics/vectors.py",
        "- cross(a, b) * 2.0) / (1.0",
        "+ cross(a, b) * 2.0) / (1.0",
        "physics/test_dynamics.py::test_rotations_are_composed",
    ),
    Mutant(
        "an attitude's error in T",
        "components/navigation/interface.py",
        'compose(errors["attitude_rad"] * 0.25, sigma)',
        'compose(sigma, errors["attitude_rad"] * 0.25)',
        BIAS,
    ),
    Mutant(
        "an angle as an MRP",
        "components/navigation/interface.py",
        'errors["attitude_rad"] * 0.25',
        'errors["attitude_rad"]',
        WHITE,
    ),
    Mutant(
        "noise that stands", "components/navigation/noise.py", "numbers.noise, tick.k, 3", "numbers.noise, tick.k * 0, 3", WHITE
    ),
    Mutant(
        "noise that moves up",
        "components/navigation/noise.py",
        "for place, name in enumerate(MEASURED)}",
        "for place, name in enumerate(memory)}",
        "physics/test_navigation.py::test_what_is_not_named_is_exact_and_changes_nothing_else",
    ),
    Mutant("q h for q √h", "components/navigation/gyro_drift.py", "jnp.sqrt(tick.h)", "tick.h", GYRO),
    Mutant(
        "a gyro that wanders before the flight",
        "components/navigation/gyro_drift.py",
        "jnp.where(tick.k == 0, 0.0, jnp.sqrt(tick.h))",
        "jnp.sqrt(tick.h)",
        GYRO,
    ),
    Mutant(
        "a step less of delay",
        "physics/delay_line.py",
        "return line[-1]",
        "return line[-2]",
        "physics/test_navigation.py::test_a_delay_is_exact",
    ),
    Mutant(
        "an error that is given the true motion",
        "simulation/closed_loop.py",
        "error.keep(tick, motion, memory, given)",
        "error.keep(tick, jax.tree.map(lambda x: x * 0.0, motion), memory, given)",
        ORDER,
    ),
    Mutant(
        "a start on the true motion",
        "simulation/closed_loop.py",
        "measurement(tick.t, first, known.target",
        "measurement(tick.t, motion, known.target",
        "physics/test_navigation.py::test_the_controller_starts_on_what_it_sees",
    ),
    # sampled control
    Mutant(
        "a command at every step",
        "simulation/closed_loop.py",
        "False if tick is None else tick.k % loop.sampling == 0",
        "tick is not None",
        BY_HAND,
    ),
    Mutant(
        "an own state that sees the present",
        "simulation/closed_loop.py",
        "controller.respond(last.view, state",
        "controller.respond(view, state",
        BY_HAND,
    ),
    Mutant(
        "a command of the present within a step",
        "simulation/closed_loop.py",
        "due = False if tick",
        "due = True if tick",
        "physics/test_sampling.py::test_a_command_stands_between_two_instants",
    ),
    Mutant(
        "a look that comes late",
        "simulation/closed_loop.py",
        "respond(last.view, state",
        "respond(last.view._replace(motion=control.view.motion), state",
        BY_HAND,
    ),
    # temporal margins
    Mutant(
        "a predicate turned round", MARGINS, "if above else value(context) - get(step)", "if above else get(step)", DEFINITION
    ),
    Mutant("a scale that multiplies", MARGINS, "room / scale(context)", "room * scale(context)", DEFINITION),
    Mutant(
        "a lost negation of a state",
        MARGINS,
        "lambda step, context: -part(step, context)",
        "lambda step, context: part(step, context)",
        "physics/test_margins.py::test_not_always_is_eventually_not",
    ),
    Mutant(
        "a lost negation of a flight",
        MARGINS,
        "lambda acc, context: -part(acc, context)",
        "lambda acc, context: part(acc, context)",
        "physics/test_margins.py::test_a_margin_is_above_zero_where_the_formula_is_true",
    ),
    Mutant("a window that begins a step late", MARGINS, "(first - 0.5)", "(first + 0.5)", DEFINITION),
    Mutant("a window that ends a step early", MARGINS, "(behind + 0.5)", "(behind - 0.5)", DEFINITION),
    Mutant(
        "the latest for the smallest",
        MARGINS,
        "jnp.minimum(acc[0], state(step, context)), acc[0])",
        "state(step, context), acc[0])",
        DEFINITION,
    ),
    Mutant(
        "always for eventually",
        MARGINS,
        "make = always if isinstance(formula, Always) else eventually",
        "make = always",
        DEFINITION,
    ),
    Mutant("settled by the position alone", MARGINS, " & (norm(step.motion.sigma) <= context.tube_mrp)", "", DEFINITION),
    Mutant("held until the end, not until settled", MARGINS, "jnp.where(settled, acc[1], lowest)", "lowest", DEFINITION),
    Mutant(
        "held up to the step before the last outside",
        MARGINS,
        "jnp.where(settled, acc[1], lowest)",
        "jnp.where(settled, acc[1], acc[0])",
        DEFINITION,
    ),
    Mutant(
        "hold also where reach is",
        MARGINS,
        "jnp.minimum(reach(step, context), held)",
        "jnp.minimum(reach(step, context), jnp.minimum(held, hold(step, context)))",
        DEFINITION,
    ),
    Mutant(
        "hold from the window on only",
        MARGINS,
        "return jnp.minimum(held, hold(step, context)), best",
        "return jnp.where(inside(step, context), jnp.minimum(held, hold(step, context)), held), best",
        DEFINITION,
    ),
    Mutant("the first number for any", MARGINS, "place = len(self.numbers)", "place = 0", DEFINITION),
    Mutant(
        "a threshold in the program",
        MARGINS,
        "return lambda context: context.margins[place]",
        "return lambda context: value",
        OF_ITS_TRACE,
    ),
    Mutant(
        "the limit of the other side",
        "simulation/signals.py",
        "jnp.where(h >= 0.0, upper, lower)",
        "jnp.where(h >= 0.0, lower, upper)",
        OF_ITS_TRACE,
    ),
    Mutant(
        "a fold without the last step",
        "simulation/flight.py",
        "accumulators = accumulate(metrics, carry.accumulators, observe(evaluate, drawn, carry, k), weight, drawn, k)",
        "accumulators = carry.accumulators",
        OF_ITS_TRACE,
    ),
    Mutant(
        "speed away from the target",
        "simulation/signals.py",
        "return -dot(step.motion.rho",
        "return dot(step.motion.rho",
        "physics/test_margins.py::test_the_closing_speed_is_the_rate_of_the_distance",
    ),
    Mutant(
        "a tie that rises instead of falling",
        "components/samplers/copula.py",
        "np.clip(1.0 - numbers, LEAST, MOST) if falls",
        "numbers if falls",
        "campaign/test_correlation.py::test_tied_draws_rise_and_fall_together",
    ),
    Mutant(
        "the scalar part of a quaternion at the other end",
        "campaign/attitudes.py",
        "(q[:3], q[3]) if order == ORDERS[0]",
        "(q[:3], q[3]) if order != ORDERS[0]",
        "campaign/test_attitudes.py::test_a_quaternion_is_its_mrp",
    ),
    Mutant(
        "a sign in the Euler angles",
        "campaign/attitudes.py",
        "cz * cy * sx - sz * sy * cx",
        "cz * cy * sx + sz * sy * cx",
        "campaign/test_attitudes.py::test_euler_angles_are_3_2_1",
    ),
    Mutant(
        "the order of the products of inertia",
        "campaign/inertia.py",
        '"yz": (1, 2), "xz": (0, 2), "xy": (0, 1)',
        '"xy": (0, 1), "xz": (0, 2), "yz": (1, 2)',
        "campaign/test_inertia_notation.py::test_every_notation_is_the_body",
    ),
)
