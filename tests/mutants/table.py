"""Mistakes that the tests must notice, one in each row: signs, frames, missing terms, swapped sides.

`old` stands exactly once in `file` and is replaced by `new`; `killer` is a test that fails then.
"""

from __future__ import annotations

from typing import NamedTuple


class Mutant(NamedTuple):
    """name; file under rvjax/; old and new text; killer: file under tests/physics/ and test."""

    name: str
    file: str
    old: str
    new: str
    killer: str


DYNAMICS, ADAPTIVE = "physics/dynamics.py", "components/controllers/saturated_adaptive.py"
RATES = "test_dynamics.py::test_rates_are_those_of_the_absolute_motion"
MOMENTUM = "test_dynamics.py::test_momentum_follows_from_the_torque_alone"
TARGET = "test_dynamics.py::test_the_target_is_free"
ROTATION = "test_dynamics.py::test_rotation_agrees_with_scipy"
DIFFERENCE = "test_dynamics.py::test_differential_gravity_has_every_digit"
FOLDS = "test_metrics.py::test_folds_agree_with_the_trace"
IDENTITY = "test_adaptation.py::test_lyapunov_like_identity"
GRADIENT = "test_adaptation.py::test_adaptation_follows_the_gradient"
LINEAR = "test_adaptation.py::test_the_plant_is_linear_in_its_parameters"
DERIVATIVE = "test_adaptation.py::test_differentiators_find_the_derivative"
SINE = "test_elementary.py::test_sine_and_cosine_have_every_digit"
NUSSBAUM = "test_adaptation.py::test_nussbaum_gains_by_definition"
ONSET = "test_flight.py::test_faults_begin_at_their_onset"
NORMAL = "test_noise.py::test_the_numbers_are_normal"
APART = "test_noise.py::test_numbers_depend_on_nothing_of_each_other"
COLOURED = "test_noise.py::test_coloured_noise_has_its_variance_and_correlation"
OU, DRAG, J2 = (f"components/disturbances/{name}.py" for name in ("ornstein_uhlenbeck", "differential_drag", "j2_difference"))
PULSE, TABLE = "components/disturbances/plume_pulse.py", "components/disturbances/table.py"
TWO_IN_AIR = "test_disturbances.py::test_drag_is_that_of_two_bodies_in_inertial_space"
TWO_PULLED = "test_disturbances.py::test_j2_is_that_of_two_bodies_in_inertial_space"
PULSES = "test_disturbances.py::test_a_pulse_has_its_impulse_its_height_and_its_times"
ROWS = "test_disturbances.py::test_a_table_is_interpolated"
ORDER = "test_navigation.py::test_errors_act_in_the_order_of_the_campaign"
WHITE = "test_navigation.py::test_noise_is_white_and_of_its_size"
BIAS = "test_navigation.py::test_a_bias_is_the_one_that_was_drawn"
GYRO = "test_navigation.py::test_the_bias_of_a_gyro_wanders_by_the_root_of_time"
SLIDING, NOMINAL = "components/controllers/sliding_mode.py", "components/controllers/nominal_backstepping.py"
WINDUP, FILTERED = "components/controllers/anti_windup.py", "components/controllers/command_filtered.py"
OBSERVER = "components/controllers/disturbance_observer.py"
LAYER = "test_baselines.py::test_the_sliding_variable_falls_to_its_boundary_layer"
PROOF = "test_baselines.py::test_nominal_backstepping_falls_as_its_proof_says"
CLIP = "test_baselines.py::test_nominal_backstepping_stays_inside_the_nominal_limits_and_winds_up"
WITHHELD = "test_baselines.py::test_anti_windup_takes_the_saturation_out_of_the_error"
RESTS = "test_baselines.py::test_anti_windup_rests_while_nothing_is_saturated"
RAMP = "test_baselines.py::test_command_filter_lags_a_ramp_by_its_time"
COMPENSATED = "test_baselines.py::test_compensated_errors_know_of_neither_filter_nor_saturation"
LAG = "test_baselines.py::test_disturbance_observer_is_a_first_order_lag"
FOUND = "test_baselines.py::test_a_constant_disturbance_is_found_at_the_observers_rate"
BY_HAND = "test_sampling.py::test_a_sampled_flight_is_the_one_written_by_hand"
MARGINS = "simulation/temporal_margins.py"
DEFINITION = "test_margins.py::test_folds_are_the_definition_on_random_traces"
OF_ITS_TRACE = "test_margins.py::test_a_flight_has_the_margins_of_its_trace"

MUTANTS = (
    # plant
    Mutant("sign of Ω×JΩ", DYNAMICS, "wrench.torque - gyro", "wrench.torque + gyro", MOMENTUM),
    Mutant("J for J⁻¹", DYNAMICS, "apply(plant.inertia_inverse, wrench", "apply(plant.inertia, wrench", MOMENTUM),
    Mutant("R for Rᵀ", "physics/vectors.py", "c = -4.0 * (1.0 - s2) * scale", "c = 4.0 * (1.0 - s2) * scale", ROTATION),
    Mutant(
        "no ω_t×(ω_t×δ)", DYNAMICS, "cross(alpha_t, port) + cross(target.w, cross(target.w, port))", "cross(alpha_t, port)", RATES
    ),
    Mutant("no ω̇_t×δ", DYNAMICS, "swing = cross(alpha_t, port) + ", "swing = ", RATES),
    Mutant("n in the target's frame", DYNAMICS, "delta) - rotate(r, swing)", "delta) - swing", RATES),
    Mutant("sign of Rω̇_t", DYNAMICS, "w) - rotate(r, alpha_t)", "w) + rotate(r, alpha_t)", RATES),
    Mutant("no Ω×ν", DYNAMICS, "known.accel - cross(known.omega_p, motion.nu)", "known.accel", RATES),
    Mutant("no Ω×ρ", DYNAMICS, "motion.nu - cross(known.omega_p, motion.rho)", "motion.nu", RATES),
    Mutant(
        "inertial for component rate of v_t",
        DYNAMICS,
        "v=gravity(target.r) - cross(target.w, target.v)",
        "v=gravity(target.r)",
        TARGET,
    ),
    Mutant("sign of ω_t×J_tω_t", DYNAMICS, "return -apply(inertia_inverse", "return apply(inertia_inverse", TARGET),
    Mutant(
        "gravity as a difference",
        DYNAMICS,
        "accel=differential_gravity(centre, delta) -",
        "accel=gravity(centre + delta) - gravity(centre) -",
        "test_dynamics.py::test_the_known_acceleration_survives_float32",
    ),
    Mutant("sign of Battin's F", DYNAMICS, "(delta - r * f)", "(delta + r * f)", DIFFERENCE),
    Mutant(
        "sign of the gravity gradient",
        DYNAMICS,
        "cross(unit, apply(inertia, unit))",
        "cross(apply(inertia, unit), unit)",
        "test_dynamics.py::test_gravity_gradient_is_the_moment_of_gravity",
    ),
    Mutant("factor of G(σ)", "physics/vectors.py", "+ cross(sigma, omega) * 2.0 +", "+ cross(sigma, omega) +", ROTATION),
    Mutant("shadow without its sign", "physics/vectors.py", "s2 > 1.0, -1.0 / s2, 1.0", "s2 > 1.0, 1.0 / s2, 1.0", ROTATION),
    Mutant(
        "shadow inside the step",
        "physics/vectors.py",
        "    s2 = dot(sigma, sigma)\n    return (omega",
        "    sigma = shadow(sigma)\n    s2 = dot(sigma, sigma)\n    return (omega",
        "test_oracle.py::test_attitude_is_continuous_across_the_shadow_switch",
    ),
    Mutant(
        "no shadow switch",
        "simulation/flight.py",
        "    y = closed_loop.between_steps(y)\n",
        "",
        "test_oracle.py::test_attitude_is_continuous_across_the_shadow_switch",
    ),
    # integration and metrics
    Mutant(
        "weights of RK4",
        "simulation/rk4.py",
        "(p + 2.0 * (q + r) + s)",
        "(2.0 * p + q + r + 2.0 * s)",
        "test_flight.py::test_rk4_is_exact_for_cubics_and_no_further",
    ),
    Mutant(
        "last stage of RK4 at the middle",
        "simulation/rk4.py",
        "rate(t + h, along(y, h, k3))",
        "rate(t + 0.5 * h, along(y, h, k3))",
        "test_flight.py::test_rk4_is_exact_for_cubics_and_no_further",
    ),
    Mutant("first weight of the trapezoid", "simulation/flight.py", "jnp.where(k == 0, 0.5, 1.0)", "1.0", FOLDS),
    Mutant(
        "last weight of the trapezoid",
        "simulation/flight.py",
        "weight = 0.5 * drawn.context.step_s",
        "weight = drawn.context.step_s",
        FOLDS,
    ),
    Mutant(
        "Rρ for Rᵀρ in the corridor",
        "components/metrics/approach.py",
        "rho = rotate_back(rotation(step.motion.sigma), step",
        "rho = rotate_back(rotation(-step.motion.sigma), step",
        FOLDS,
    ),
    Mutant(
        "limit of the other side in the duty",
        "components/metrics/saturation.py",
        "jnp.where(h >= 0, up, low), step",
        "jnp.where(h < 0, up, low), step",
        FOLDS,
    ),
    Mutant(
        "settled one step early",
        "components/metrics/convergence.py",
        "jnp.maximum(last + context.step_s, 0.0)",
        "jnp.maximum(last, 0.0)",
        FOLDS,
    ),
    Mutant(
        "loss not remembered",
        "simulation/flight.py",
        "lost = jnp.minimum(carry.lost_s, ",
        "lost = jnp.maximum(0.0, ",
        "test_flight.py::test_lost_samples_are_reported_and_disturb_nobody",
    ),
    # actuators
    Mutant(
        "fault before its onset",
        "components/faults/interface.py",
        "lambda onset: t >= onset",
        "lambda onset: t < onset",
        ONSET,
    ),
    Mutant("sign of the bias", "components/faults/bias.py", "u + numbers.share * upper", "u - numbers.share * upper", ONSET),
    Mutant(
        "lost phase of the disturbance",
        "components/disturbances/sinusoid.py",
        "a * sin(w * t + phi)",
        "a * sin(w * t)",
        "test_flight.py::test_disturbances_are_as_drawn",
    ),
    Mutant(
        "swapped limits of the tanh",
        "physics/saturation.py",
        "    limit = jnp.where(v >= 0, upper, lower)\n    share",
        "    limit = jnp.where(v >= 0, lower, upper)\n    share",
        "test_saturation.py::test_each_side_reaches_its_own_limit",
    ),
    Mutant(
        "slope of the erf",
        "physics/saturation.py",
        "jnp.exp(-x * x)",
        "jnp.exp(-2.0 * x * x)",
        "test_saturation.py::test_value_and_slope",
    ),
    # controller
    Mutant("cosine half a turn off", "physics/fast_trig.py", "return -_alternate(half)", "return _alternate(half)", SINE),
    Mutant("a part of π/2 missing", "physics/fast_trig.py", "6.123233932053594e-17, ", "", SINE),
    Mutant("a term of the sine missing", "physics/fast_trig.py", "        2.7314368769379893e-15,\n", "", SINE),
    Mutant(
        "sign of the Nussbaum gain",
        "physics/nussbaum.py",
        "return jnp.exp(chi * chi) *",
        "return -jnp.exp(chi * chi) *",
        NUSSBAUM,
    ),
    Mutant(
        "sine for cosine in the Nussbaum gain",
        "physics/nussbaum.py",
        "chi * chi * cos(chi)",
        "chi * chi * jnp.sin(chi)",
        NUSSBAUM,
    ),
    Mutant("sign of Levant's first gain", "physics/differentiators.py", "z1 - 1.5 *", "z1 + 1.5 *", DERIVATIVE),
    Mutant("sign of Levant's second gain", "physics/differentiators.py", "-1.1 * bound", "1.1 * bound", DERIVATIVE),
    Mutant("sign of K₃", ADAPTIVE, "- z3 * gains.k3", "+ z3 * gains.k3", IDENTITY),
    Mutant("sign of κ", ADAPTIVE, "* wanted - state.v * gains.kappa", "* wanted + state.v * gains.kappa", IDENTITY),
    Mutant("sign of χ̇", ADAPTIVE, "chi=z3 / limit", "chi=-z3 / limit", IDENTITY),
    Mutant("no α̂̇₂", ADAPTIVE, "gains.kappa + derivative -", "gains.kappa -", IDENTITY),
    Mutant(
        "sign of the adaptation of m̂",
        "physics/backstepping.py",
        "gains.gamma_mass * mass_rate",
        "-gains.gamma_mass * mass_rate",
        GRADIENT,
    ),
    Mutant("sign of D̂ in α₂", "physics/backstepping.py", "return bound * z / reach", "return -bound * z / reach", GRADIENT),
    Mutant(
        "sign of Ω×JΩ in Yθ",
        "physics/backstepping.py",
        "now.turn) - cross(now.omega, apply",
        "now.turn) + cross(now.omega, apply",
        LINEAR,
    ),
    Mutant("sign of α̇_ν", "physics/backstepping.py", "motion.nu) - alpha1_rate.force", "motion.nu) + alpha1_rate.force", LINEAR),
    Mutant(
        "no Ω×ρ in α̇_ν",
        "physics/backstepping.py",
        "rho_rate = measurement.motion.nu - cross(known.omega_p, rho)",
        "rho_rate = measurement.motion.nu",
        LINEAR,
    ),
    Mutant(
        "sign of Yᵀ",
        "physics/backstepping.py",
        "symmetric_gradient(cross(now.omega, z.torque)",
        "symmetric_gradient(cross(z.torque, now.omega)",
        "test_adaptation.py::test_gradient_of_the_model",
    ),
    Mutant(
        "projection at the other side",
        "physics/backstepping.py",
        "(x >= high) & (rate > 0)",
        "(x >= high) & (rate < 0)",
        "test_adaptation.py::test_projection_stops_at_the_bounds_only",
    ),
    Mutant(
        "feed-forward of PD+",
        "components/controllers/pd_plus.py",
        "-known.alpha - motion.sigma",
        "known.alpha - motion.sigma",
        "test_adaptation.py::test_pd_plus_lyapunov_function_falls",
    ),
    # noise
    Mutant("ln u without its factor", "physics/noise.py", "np.float32(-2.0)", "np.float32(-1.0)", NORMAL),
    Mutant("half a turn", "physics/noise.py", "np.float32(2.0 * math.pi * 2.0**-32)", "np.float32(math.pi * 2.0**-32)", NORMAL),
    Mutant("one word for two numbers", "physics/noise.py", "second.astype", "first.astype", APART),
    Mutant("the component is not counted", "physics/noise.py", "(step, jnp.uint32(j))", "(step, jnp.uint32(0))", APART),
    Mutant("the step is not counted", "physics/noise.py", "(step, jnp.uint32(j))", "(step * 0, jnp.uint32(j))", APART),
    Mutant(
        "a key that is half read", "physics/noise.py", "words = ((a << 16) | b, (c << 16) | d)", "words = (d * 0, d * 0)", APART
    ),
    Mutant(
        "a round less",
        "physics/noise.py",
        "for group in range(5)",
        "for group in range(4)",
        "test_noise.py::test_the_generator_is_the_published_one",
    ),
    # disturbances
    Mutant("√(1−a) for √(1−a²)", OU, "-fall * (2.0 + fall)", "-fall", COLOURED),
    Mutant("Euler's a", OU, "jnp.expm1(-tick.h / tau)", "-tick.h / tau", COLOURED),
    Mutant("a start at zero", OU, "jnp.where(tick.k == 0, -1.0, jnp.expm1(-tick.h / tau))", "jnp.expm1(-tick.h / tau)", COLOURED),
    Mutant("time constant as a rate", OU, "-tick.h / tau", "-tick.h * tau", COLOURED),
    Mutant("drag without ω_t×δ", DRAG, "y.target.v + cross(y.target.w, plant.port)", "y.target.v", TWO_IN_AIR),
    Mutant("drag without ν", DRAG, "rotate(known.r, port) + y.motion.nu", "rotate(known.r, port)", TWO_IN_AIR),
    Mutant("sign of the target's drag", DRAG, "(pursuer - target)", "(pursuer + target)", TWO_IN_AIR),
    Mutant("one coefficient for both", DRAG, "numbers.target_m2_kg, numbers", "numbers.pursuer_m2_kg, numbers", TWO_IN_AIR),
    Mutant("J2 without φ₇", J2, " + s * s * phi7)", ")", "test_disturbances.py::test_the_difference_of_j2_has_every_digit"),
    Mutant(
        "J2 without d²",
        J2,
        "d * (2.0 * s + d) * seventh",
        "d * 2.0 * s * seventh",
        "test_disturbances.py::test_the_difference_of_j2_has_every_digit",
    ),
    Mutant(
        "sin u for cos u",
        J2,
        "out * sin(u) + cross(normal, out) * cos(u)",
        "out * cos(u) + cross(normal, out) * sin(u)",
        TWO_PULLED,
    ),
    Mutant("r̂×ĥ for ĥ×r̂", J2, "cross(normal, out)", "cross(out, normal)", TWO_PULLED),
    Mutant("the pole in T", J2, "rotate(known.r, k))", "k)", TWO_PULLED),
    Mutant("J2 without the port", J2, "y.motion.rho + rotate(known.r, plant.port)", "y.motion.rho", TWO_PULLED),
    Mutant(
        "no ü",
        J2,
        "(memory.rate + memory.half * since)",
        "memory.rate",
        "test_disturbances.py::test_the_argument_of_latitude_follows_the_orbit",
    ),
    Mutant(
        "u starts over",
        J2,
        "latitude(tick.t, memory), rate",
        "memory.u, rate",
        "test_disturbances.py::test_the_argument_of_latitude_follows_the_orbit",
    ),
    Mutant(
        "pulses before the first",
        PULSE,
        "jnp.maximum(jnp.floor(since / numbers.period_s), 0.0)",
        "jnp.floor(since / numbers.period_s)",
        PULSES,
    ),
    Mutant(
        "an edge that adds to the width",
        PULSE,
        "(since - numbers.width_s) / numbers.edge_s",
        "(since - numbers.width_s - numbers.edge_s) / numbers.edge_s",
        PULSES,
    ),
    Mutant(
        "an edge with a kink",
        PULSE,
        "inside * inside * inside * (10.0 + inside * (6.0 * inside - 15.0))",
        "inside",
        "test_disturbances.py::test_what_rk4_makes_of_an_edge",
    ),
    Mutant("a table shifted the other way", TABLE, "t - numbers.shift_s", "t + numbers.shift_s", ROWS),
    Mutant("the row behind", TABLE, '"scan_unrolled") - 1, 0', '"scan_unrolled"), 0', ROWS),
    Mutant("a table held during a step", TABLE, "((t - memory.t) / memory.h)", "0.0", ROWS),
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
        "test_dynamics.py::test_rotations_are_composed",
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
        "test_navigation.py::test_what_is_not_named_is_exact_and_changes_nothing_else",
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
        "test_navigation.py::test_a_delay_is_exact",
    ),
    Mutant(
        "an error that is given the true motion",
        "simulation/closed_loop.py",
        "error.keep(tick, motion, memory, numbers)",
        "error.keep(tick, drawn.motion, memory, numbers)",
        ORDER,
    ),
    Mutant(
        "a start on the true motion",
        "simulation/closed_loop.py",
        "measurement(tick.t, first, drawn.target",
        "measurement(tick.t, motion, drawn.target",
        "test_navigation.py::test_the_controller_starts_on_what_it_sees",
    ),
    # sampled control
    Mutant("a command at every step", "simulation/closed_loop.py", "tick.k % loop.sampling == 0", "tick.k >= 0", BY_HAND),
    Mutant(
        "an own state that sees the present",
        "simulation/closed_loop.py",
        "loop.controller.respond(last_view, state",
        "loop.controller.respond(view, state",
        BY_HAND,
    ),
    Mutant(
        "a command of the present within a step",
        "simulation/closed_loop.py",
        "due = False if tick",
        "due = True if tick",
        "test_sampling.py::test_a_command_stands_between_two_instants",
    ),
    Mutant(
        "a look that comes late",
        "simulation/closed_loop.py",
        "last_view = measurement(last.t, last.motion",
        "last_view = measurement(last.t, control.motion",
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
        "test_margins.py::test_not_always_is_eventually_not",
    ),
    Mutant(
        "a lost negation of a flight",
        MARGINS,
        "lambda acc, context: -part(acc, context)",
        "lambda acc, context: part(acc, context)",
        "test_margins.py::test_a_margin_is_above_zero_where_the_formula_is_true",
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
        "accumulators = accumulate(metrics, carry.accumulators, observe(evaluate, drawn, carry, k), weight, drawn)",
        "accumulators = carry.accumulators",
        OF_ITS_TRACE,
    ),
    Mutant(
        "speed away from the target",
        "simulation/signals.py",
        "return -dot(step.motion.rho",
        "return dot(step.motion.rho",
        "test_margins.py::test_the_closing_speed_is_the_rate_of_the_distance",
    ),
)
