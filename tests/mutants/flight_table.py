"""Mutants of the plant, the integration, metrics, actuators, the controller, noise and disturbances."""

from __future__ import annotations

from tests.mutants.mutant import Mutant

TRIG = "elementary/trigonometric.py"
DYNAMICS, ADAPTIVE = "physics/dynamics.py", "components/controllers/saturated_adaptive.py"
AUGMENTED = "physics/augmented_system.py"
RATES = "physics/test_dynamics.py::test_rates_are_those_of_the_absolute_motion"
MOMENTUM = "physics/test_dynamics.py::test_momentum_follows_from_the_torque_alone"
TARGET = "physics/test_dynamics.py::test_the_target_is_free"
ROTATION = "physics/test_dynamics.py::test_rotation_agrees_with_scipy"
DIFFERENCE = "physics/test_dynamics.py::test_differential_gravity_has_every_digit"
FOLDS = "physics/test_metrics.py::test_folds_agree_with_the_trace"
IDENTITY = "physics/test_adaptation.py::test_lyapunov_like_identity"
GRADIENT = "physics/test_adaptation.py::test_adaptation_follows_the_gradient"
LINEAR = "physics/test_adaptation.py::test_the_plant_is_linear_in_its_parameters"
DERIVATIVE = "physics/test_adaptation.py::test_differentiators_find_the_derivative"
SINE = "physics/test_sine_and_cosine.py::test_sine_and_cosine_have_every_digit"
NUSSBAUM = "physics/test_adaptation.py::test_nussbaum_gains_by_definition"
UNKNOWN = "physics/control_direction.py"
SWINGS = "physics/test_control_direction.py::test_the_gain_swings_to_both_sides"
STANDS = "physics/test_control_direction.py::test_the_argument_moves_only_where_the_error_grows_against_the_demand"
PULLED = "physics/test_control_direction.py::test_the_argument_is_pulled_to_even_numbers"
SMOOTHED = "physics/test_control_direction.py::test_the_growth_is_smoothed_over_its_time"
REVERSED = "physics/test_control_direction.py::test_a_reversed_channel_is_flown"
ONSET = "physics/test_flight.py::test_faults_begin_at_their_onset"
NORMAL = "physics/test_noise.py::test_the_numbers_are_normal"
APART = "physics/test_noise.py::test_numbers_depend_on_nothing_of_each_other"
COLOURED = "physics/test_noise.py::test_coloured_noise_has_its_variance_and_correlation"
OU, DRAG, J2 = (f"components/disturbances/{name}.py" for name in ("ornstein_uhlenbeck", "differential_drag", "j2_difference"))
PULSE, TABLE = "components/disturbances/plume_pulse.py", "components/disturbances/table.py"
TWO_IN_AIR = "physics/test_disturbances.py::test_drag_is_that_of_two_bodies_in_inertial_space"
TWO_PULLED = "physics/test_disturbances.py::test_j2_is_that_of_two_bodies_in_inertial_space"
PULSES = "physics/test_disturbances.py::test_a_pulse_has_its_impulse_its_height_and_its_times"
ROWS = "physics/test_disturbances.py::test_a_table_is_interpolated"

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
        "physics/test_dynamics.py::test_the_known_acceleration_survives_float32",
    ),
    Mutant("sign of Battin's F", DYNAMICS, "(delta - r * f)", "(delta + r * f)", DIFFERENCE),
    Mutant(
        "sign of the gravity gradient",
        DYNAMICS,
        "cross(unit, apply(inertia, unit))",
        "cross(apply(inertia, unit), unit)",
        "physics/test_dynamics.py::test_gravity_gradient_is_the_moment_of_gravity",
    ),
    Mutant("factor of G(σ)", "physics/vectors.py", "+ cross(sigma, omega) * 2.0 +", "+ cross(sigma, omega) +", ROTATION),
    Mutant("shadow without its sign", "physics/vectors.py", "s2 > 1.0, -1.0 / s2, 1.0", "s2 > 1.0, 1.0 / s2, 1.0", ROTATION),
    Mutant(
        "shadow inside the step",
        "physics/vectors.py",
        "    s2 = dot(sigma, sigma)\n    return (omega",
        "    sigma = shadow(sigma)\n    s2 = dot(sigma, sigma)\n    return (omega",
        "physics/test_oracle.py::test_attitude_is_continuous_across_the_shadow_switch",
    ),
    Mutant(
        "no shadow switch",
        "simulation/flight.py",
        "    y = closed_loop.between_steps(y)\n",
        "",
        "physics/test_oracle.py::test_attitude_is_continuous_across_the_shadow_switch",
    ),
    # integration and metrics
    Mutant(
        "weights of RK4",
        "simulation/rk4.py",
        "(p + 2.0 * (q + r) + s)",
        "(2.0 * p + q + r + 2.0 * s)",
        "physics/test_flight.py::test_rk4_is_exact_for_cubics_and_no_further",
    ),
    Mutant(
        "last stage of RK4 at the middle",
        "simulation/rk4.py",
        "rate(t + h, along(y, h, k3))",
        "rate(t + 0.5 * h, along(y, h, k3))",
        "physics/test_flight.py::test_rk4_is_exact_for_cubics_and_no_further",
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
        "physics/test_flight.py::test_lost_samples_are_reported_and_disturb_nobody",
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
        "physics/test_flight.py::test_disturbances_are_as_drawn",
    ),
    Mutant(
        "swapped limits of the tanh",
        "physics/saturation.py",
        "jnp.where(v >= 0, upper, lower), jnp.where(v >= 0, 1.0 / upper, 1.0 / lower)",
        "jnp.where(v >= 0, lower, upper), jnp.where(v >= 0, 1.0 / lower, 1.0 / upper)",
        "physics/test_saturation.py::test_each_side_reaches_its_own_limit",
    ),
    Mutant(
        "inverse of the other limit",
        "physics/saturation.py",
        "1.0 / upper, 1.0 / lower",
        "1.0 / lower, 1.0 / upper",
        "physics/test_saturation.py::test_value_and_slope",
    ),
    Mutant(
        "slope of the erf",
        "physics/saturation.py",
        "exp(-(x * x))",
        "exp(-2.0 * x * x)",
        "physics/test_saturation.py::test_value_and_slope",
    ),
    # controller
    Mutant("cosine half a turn off", TRIG, "return -_alternating(", "return _alternating(", SINE),
    Mutant("sine without its sign", TRIG, "_alternating(_sine(x, 2.0 * half), half)", "_sine(x, 2.0 * half)", SINE),
    Mutant("a part of π/2 missing", TRIG, "6.123233932053594e-17, ", "", SINE),
    Mutant("a term of the sine missing", TRIG, "        2.7314368769379893e-15,\n", "", SINE),
    Mutant(
        "sign of the Nussbaum gain",
        "physics/nussbaum.py",
        "return exp(chi * chi) *",
        "return -exp(chi * chi) *",
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
    Mutant("sign of K₃", AUGMENTED, "- z3 * gains.k3", "+ z3 * gains.k3", IDENTITY),
    Mutant("sign of κ", AUGMENTED, "* w - v * gains.kappa", "* w + v * gains.kappa", IDENTITY),
    Mutant("sign of χ̇", AUGMENTED, "drive = z3 * inverse", "drive = -z3 * inverse", IDENTITY),
    Mutant("sign of the leak of χ", AUGMENTED, "drive - chi * gains.leak_chi", "drive + chi * gains.leak_chi", IDENTITY),
    Mutant("leak in the textbook form", ADAPTIVE, '.modification == "leakage"', '.modification != ""', IDENTITY),
    Mutant(
        "sign of the leak of D̂",
        "physics/backstepping.py",
        "- bound * gains.leak_bound",
        "+ bound * gains.leak_bound",
        "physics/test_adaptation.py::test_bounds_leak",
    ),
    Mutant("sign of N(η)", UNKNOWN, "* cos((0.5 * math.pi) * eta)", "* -cos((0.5 * math.pi) * eta)", SWINGS),
    Mutant("no growth of N(η)", UNKNOWN, "0.05 * (eta * eta)", "0.0 * (eta * eta)", SWINGS),
    Mutant("η moves while |z₂| falls", UNKNOWN, "jnp.maximum(grown, 0.0)", "jnp.abs(grown)", STANDS),
    Mutant("η moves with a demand that pushes along", UNKNOWN, "jnp.clip(-jnp.sign(z)", "jnp.abs(jnp.sign(z)", STANDS),
    Mutant("η is pushed off the even numbers", UNKNOWN, "drive - gains.leak_eta", "drive + gains.leak_eta", PULLED),
    Mutant("growth over T²", UNKNOWN, "growth * (1.0 / gains.growth_time_s)", "growth * gains.growth_time_s", SMOOTHED),
    Mutant(
        "α₂ without N(η)", ADAPTIVE, "raw = raw * each(control_direction.gain, state.direction.eta)", "raw = raw * 1.0", REVERSED
    ),
    Mutant(
        "a reversal without its sign",
        "components/faults/reversed.py",
        "return -(numbers.remaining * u)",
        "return numbers.remaining * u",
        "physics/test_faults.py::test_while_it_acts_a_fault_gives_what_it_is_known_for",
    ),
    Mutant(
        "a thruster that pulls",
        "components/faults/reversed.py",
        "!= CHANNELS:",
        "is None:",
        "campaign/test_campaign.py::test_bad_file",
    ),
    Mutant("no α̂̇₂", AUGMENTED, "gains.kappa + wanted.rate -", "gains.kappa -", IDENTITY),
    Mutant(
        "sign of the adaptation of m̂",
        "physics/backstepping.py",
        "gains.gamma_mass * mass_rate",
        "-gains.gamma_mass * mass_rate",
        GRADIENT,
    ),
    Mutant("sign of D̂ in α₂", ADAPTIVE, "+ state.bound * smooth_sign", "- state.bound * smooth_sign", GRADIENT),
    Mutant("root without ε", "physics/backstepping.py", "jnp.sqrt(a * a + e * e)", "jnp.sqrt(a * a)", GRADIENT),
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
        "physics/test_adaptation.py::test_gradient_of_the_model",
    ),
    Mutant(
        "projection at the other side",
        "physics/backstepping.py",
        "(x >= high) & (rate > 0)",
        "(x >= high) & (rate < 0)",
        "physics/test_adaptation.py::test_projection_stops_at_the_bounds_only",
    ),
    Mutant(
        "feed-forward of PD+",
        "components/controllers/pd_plus.py",
        "-known.alpha - motion.sigma",
        "known.alpha - motion.sigma",
        "physics/test_adaptation.py::test_pd_plus_lyapunov_function_falls",
    ),
    # allocation
    Mutant(
        "rounding decides who is at a bound",
        "physics/thruster_allocation.py",
        "movable(solved.x, rounding(*solved.x.parts()) / EPSILON)",
        "movable(solved.x)",
        "physics/test_thrusters.py::test_rounding_at_a_bound_decides_nothing",
    ),
    # noise
    Mutant("ln u without its factor", "physics/noise.py", "jnp.sqrt(-2.0 * log", "jnp.sqrt(-1.0 * log", NORMAL),
    Mutant("half a turn", "physics/noise.py", "second * (2.0 * math.pi", "second * (math.pi", NORMAL),
    Mutant("one word for two numbers", "physics/noise.py", "angle = second", "angle = first", APART),
    Mutant(
        "noise in single precision",
        "physics/noise.py",
        "word.astype(real)",
        "word.astype(jnp.float32)",
        "physics/test_noise.py::test_they_are_those_of_box_and_muller",
    ),
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
        "physics/test_noise.py::test_the_generator_is_the_published_one",
    ),
    # disturbances
    Mutant("√(1−a) for √(1−a²)", OU, "-fall * (2.0 + fall)", "-fall", COLOURED),
    Mutant("Euler's a", OU, "expm1(-tick.h / tau)", "-tick.h / tau", COLOURED),
    Mutant("a start at zero", OU, "jnp.where(tick.k == 0, -1.0, expm1(-tick.h / tau))", "expm1(-tick.h / tau)", COLOURED),
    Mutant("time constant as a rate", OU, "-tick.h / tau", "-tick.h * tau", COLOURED),
    Mutant("drag without ω_t×δ", DRAG, "y.target.v + cross(y.target.w, plant.port)", "y.target.v", TWO_IN_AIR),
    Mutant("drag without ν", DRAG, "rotate(known.r, port) + y.motion.nu", "rotate(known.r, port)", TWO_IN_AIR),
    Mutant("sign of the target's drag", DRAG, "(pursuer - target)", "(pursuer + target)", TWO_IN_AIR),
    Mutant("one coefficient for both", DRAG, "numbers.target_m2_kg, numbers", "numbers.pursuer_m2_kg, numbers", TWO_IN_AIR),
    Mutant(
        "J2 without φ₇", J2, " + s * s * phi7)", ")", "physics/test_disturbances.py::test_the_difference_of_j2_has_every_digit"
    ),
    Mutant(
        "J2 without d²",
        J2,
        "d * (2.0 * s + d) * seventh",
        "d * 2.0 * s * seventh",
        "physics/test_disturbances.py::test_the_difference_of_j2_has_every_digit",
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
        "physics/test_disturbances.py::test_the_argument_of_latitude_follows_the_orbit",
    ),
    Mutant(
        "u starts over",
        J2,
        "latitude(tick.t, memory), rate",
        "memory.u, rate",
        "physics/test_disturbances.py::test_the_argument_of_latitude_follows_the_orbit",
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
        "physics/test_disturbances.py::test_what_rk4_makes_of_an_edge",
    ),
    Mutant("a table shifted the other way", TABLE, "t - numbers.shift_s", "t + numbers.shift_s", ROWS),
    Mutant("the row behind", TABLE, '"scan_unrolled") - 1, 0', '"scan_unrolled"), 0', ROWS),
    Mutant("a table held during a step", TABLE, "((t - memory.t) / memory.h)", "0.0", ROWS),
)
