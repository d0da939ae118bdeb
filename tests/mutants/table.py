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


DYNAMICS, ADAPTIVE = "dynamics.py", "controllers/saturated_adaptive.py"
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
OU, DRAG, J2 = (f"disturbances/{name}.py" for name in ("ornstein_uhlenbeck", "differential_drag", "j2_difference"))
PULSE, TABLE = "disturbances/plume_pulse.py", "disturbances/table.py"
TWO_IN_AIR = "test_disturbances.py::test_drag_is_that_of_two_bodies_in_inertial_space"
TWO_PULLED = "test_disturbances.py::test_j2_is_that_of_two_bodies_in_inertial_space"
PULSES = "test_disturbances.py::test_a_pulse_has_its_impulse_its_height_and_its_times"
ROWS = "test_disturbances.py::test_a_table_is_interpolated"
ORDER = "test_navigation.py::test_errors_act_in_the_order_of_the_campaign"
WHITE = "test_navigation.py::test_noise_is_white_and_of_its_size"
BIAS = "test_navigation.py::test_a_bias_is_the_one_that_was_drawn"
GYRO = "test_navigation.py::test_the_bias_of_a_gyro_wanders_by_the_root_of_time"
BY_HAND = "test_sampling.py::test_a_sampled_flight_is_the_one_written_by_hand"

MUTANTS = (
    # plant
    Mutant("sign of Ω×JΩ", DYNAMICS, "wrench.torque - gyro", "wrench.torque + gyro", MOMENTUM),
    Mutant("J for J⁻¹", DYNAMICS, "apply(plant.inertia_inverse, wrench", "apply(plant.inertia, wrench", MOMENTUM),
    Mutant("R for Rᵀ", "algebra.py", "c = -4.0 * (1.0 - s2) * scale", "c = 4.0 * (1.0 - s2) * scale", ROTATION),
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
    Mutant("factor of G(σ)", "algebra.py", "+ cross(sigma, omega) * 2.0 +", "+ cross(sigma, omega) +", ROTATION),
    Mutant("shadow without its sign", "algebra.py", "s2 > 1.0, -1.0 / s2, 1.0", "s2 > 1.0, 1.0 / s2, 1.0", ROTATION),
    Mutant(
        "shadow inside the step",
        "algebra.py",
        "    s2 = dot(sigma, sigma)\n    return (omega",
        "    sigma = shadow(sigma)\n    s2 = dot(sigma, sigma)\n    return (omega",
        "test_oracle.py::test_attitude_is_continuous_across_the_shadow_switch",
    ),
    Mutant(
        "no shadow switch",
        "flight.py",
        "    y = closed_loop.between_steps(y)\n",
        "",
        "test_oracle.py::test_attitude_is_continuous_across_the_shadow_switch",
    ),
    # integration and metrics
    Mutant(
        "weights of RK4",
        "rk4.py",
        "(p + 2.0 * (q + r) + s)",
        "(2.0 * p + q + r + 2.0 * s)",
        "test_flight.py::test_rk4_is_exact_for_cubics_and_no_further",
    ),
    Mutant(
        "last stage of RK4 at the middle",
        "rk4.py",
        "rate(t + h, along(y, h, k3))",
        "rate(t + 0.5 * h, along(y, h, k3))",
        "test_flight.py::test_rk4_is_exact_for_cubics_and_no_further",
    ),
    Mutant("first weight of the trapezoid", "flight.py", "jnp.where(k == 0, 0.5, 1.0)", "1.0", FOLDS),
    Mutant(
        "last weight of the trapezoid", "flight.py", "weight = 0.5 * drawn.rules.step_s", "weight = drawn.rules.step_s", FOLDS
    ),
    Mutant(
        "Rρ for Rᵀρ in the corridor",
        "metrics/approach.py",
        "rho = rotate_back(rotation(step.motion.sigma), step",
        "rho = rotate_back(rotation(-step.motion.sigma), step",
        FOLDS,
    ),
    Mutant(
        "limit of the other side in the duty",
        "metrics/saturation.py",
        "jnp.where(h >= 0, up, low), step",
        "jnp.where(h < 0, up, low), step",
        FOLDS,
    ),
    Mutant(
        "settled one step early", "metrics/tubes.py", "jnp.maximum(last + rules.step_s, 0.0)", "jnp.maximum(last, 0.0)", FOLDS
    ),
    Mutant(
        "loss not remembered",
        "flight.py",
        "lost = jnp.minimum(carry.lost_s, ",
        "lost = jnp.maximum(0.0, ",
        "test_flight.py::test_lost_samples_are_reported_and_disturb_nobody",
    ),
    # actuators
    Mutant(
        "fault before its onset",
        "faults/effectiveness.py",
        "jnp.where(t >= start, e * h, h)",
        "jnp.where(t < start, e * h, h)",
        ONSET,
    ),
    Mutant("sign of the bias", "faults/bias.py", "h + share * upper", "h - share * upper", ONSET),
    Mutant(
        "lost phase of the disturbance",
        "disturbances/sinusoid.py",
        "a * sin(w * t + phi)",
        "a * sin(w * t)",
        "test_flight.py::test_disturbances_are_as_drawn",
    ),
    Mutant(
        "swapped limits of the tanh",
        "saturation.py",
        "    limit = jnp.where(v >= 0, upper, lower)\n    share",
        "    limit = jnp.where(v >= 0, lower, upper)\n    share",
        "test_saturation.py::test_each_side_reaches_its_own_limit",
    ),
    Mutant(
        "slope of the erf",
        "saturation.py",
        "jnp.exp(-x * x)",
        "jnp.exp(-2.0 * x * x)",
        "test_saturation.py::test_value_and_slope",
    ),
    # controller
    Mutant("cosine half a turn off", "elementary.py", "return -_alternate(half)", "return _alternate(half)", SINE),
    Mutant("a part of π/2 missing", "elementary.py", "6.123233932053594e-17, ", "", SINE),
    Mutant("a term of the sine missing", "elementary.py", "        2.7314368769379893e-15,\n", "", SINE),
    Mutant("sign of the Nussbaum gain", "nussbaum.py", "return jnp.exp(chi * chi) *", "return -jnp.exp(chi * chi) *", NUSSBAUM),
    Mutant("sine for cosine in the Nussbaum gain", "nussbaum.py", "chi * chi * cos(chi)", "chi * chi * jnp.sin(chi)", NUSSBAUM),
    Mutant("sign of Levant's first gain", "differentiator.py", "z1 - 1.5 *", "z1 + 1.5 *", DERIVATIVE),
    Mutant("sign of Levant's second gain", "differentiator.py", "-1.1 * bound", "1.1 * bound", DERIVATIVE),
    Mutant("sign of K₃", ADAPTIVE, "- z3 * gains.k3", "+ z3 * gains.k3", IDENTITY),
    Mutant("sign of κ", ADAPTIVE, "* wanted - state.v * gains.kappa", "* wanted + state.v * gains.kappa", IDENTITY),
    Mutant("sign of χ̇", ADAPTIVE, "chi=z3 / limit", "chi=-z3 / limit", IDENTITY),
    Mutant("no α̂̇₂", ADAPTIVE, "gains.kappa + derivative -", "gains.kappa -", IDENTITY),
    Mutant(
        "sign of the adaptation of m̂",
        "backstepping.py",
        "gains.gamma_mass * mass_rate",
        "-gains.gamma_mass * mass_rate",
        GRADIENT,
    ),
    Mutant("sign of D̂ in α₂", "backstepping.py", "return bound * z / reach", "return -bound * z / reach", GRADIENT),
    Mutant(
        "sign of Ω×JΩ in Yθ",
        "backstepping.py",
        "now.turn) - cross(now.omega, apply",
        "now.turn) + cross(now.omega, apply",
        LINEAR,
    ),
    Mutant("sign of α̇_ν", "backstepping.py", "motion.nu) - alpha1_rate.force", "motion.nu) + alpha1_rate.force", LINEAR),
    Mutant(
        "no Ω×ρ in α̇_ν",
        "backstepping.py",
        "rho_rate = seen.motion.nu - cross(known.omega_p, rho)",
        "rho_rate = seen.motion.nu",
        LINEAR,
    ),
    Mutant(
        "sign of Yᵀ",
        "backstepping.py",
        "symmetric_gradient(cross(now.omega, z.torque)",
        "symmetric_gradient(cross(z.torque, now.omega)",
        "test_adaptation.py::test_gradient_of_the_model",
    ),
    Mutant(
        "projection at the other side",
        "backstepping.py",
        "(x >= high) & (rate > 0)",
        "(x >= high) & (rate < 0)",
        "test_adaptation.py::test_projection_stops_at_the_bounds_only",
    ),
    Mutant(
        "feed-forward of PD+",
        "controllers/pd_plus.py",
        "-known.alpha - motion.sigma",
        "known.alpha - motion.sigma",
        "test_adaptation.py::test_pd_plus_lyapunov_function_falls",
    ),
    # noise
    Mutant("ln u without its factor", "noise.py", "np.float32(-2.0)", "np.float32(-1.0)", NORMAL),
    Mutant(
        "16 bits for 32",
        "noise.py",
        "pair(*threefry(words, (step, jnp.uint32(j))))",
        "pair(*(w << 16 for w in threefry(words, (step, jnp.uint32(j)))))",
        NORMAL,
    ),
    Mutant("one word for two numbers", "noise.py", "second.astype", "first.astype", APART),
    Mutant("the component is not counted", "noise.py", "(step, jnp.uint32(j))", "(step, jnp.uint32(0))", APART),
    Mutant("the step is not counted", "noise.py", "(step, jnp.uint32(j))", "(step * 0, jnp.uint32(j))", APART),
    Mutant("a key that is half read", "noise.py", "words = ((a << 16) | b, (c << 16) | d)", "words = (d * 0, d * 0)", APART),
    Mutant(
        "a round less",
        "noise.py",
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
    # navigation
    Mutant(
        "sign in compose",
        "algebra.py",
        "- cross(a, b) * 2.0) / (1.0",
        "+ cross(a, b) * 2.0) / (1.0",
        "test_dynamics.py::test_rotations_are_composed",
    ),
    Mutant(
        "an attitude's error in T",
        "navigation/interface.py",
        'compose(errors["attitude_rad"] * 0.25, sigma)',
        'compose(sigma, errors["attitude_rad"] * 0.25)',
        BIAS,
    ),
    Mutant("an angle as an MRP", "navigation/interface.py", 'errors["attitude_rad"] * 0.25', 'errors["attitude_rad"]', WHITE),
    Mutant("noise that stands", "navigation/noise.py", "numbers.noise, tick.k, 3", "numbers.noise, tick.k * 0, 3", WHITE),
    Mutant(
        "noise that moves up",
        "navigation/noise.py",
        "for place, name in enumerate(MEASURED)}",
        "for place, name in enumerate(memory)}",
        "test_navigation.py::test_what_is_not_named_is_exact_and_changes_nothing_else",
    ),
    Mutant("q h for q √h", "navigation/gyro_drift.py", "jnp.sqrt(tick.h)", "tick.h", GYRO),
    Mutant(
        "a gyro that wanders before the flight",
        "navigation/gyro_drift.py",
        "jnp.where(tick.k == 0, 0.0, jnp.sqrt(tick.h))",
        "jnp.sqrt(tick.h)",
        GYRO,
    ),
    Mutant(
        "a step less of delay",
        "navigation/delay.py",
        "return memory[-1]",
        "return memory[-2]",
        "test_navigation.py::test_a_delay_is_exact",
    ),
    Mutant(
        "an error that is given the true motion",
        "closed_loop.py",
        "one.keep(tick, motion, memory, own)",
        "one.keep(tick, drawn.motion, memory, own)",
        ORDER,
    ),
    Mutant(
        "a start on the true motion",
        "closed_loop.py",
        "seen(tick.t, first, drawn.target",
        "seen(tick.t, motion, drawn.target",
        "test_navigation.py::test_the_controller_starts_on_what_it_sees",
    ),
    # sampled control
    Mutant("a command at every step", "closed_loop.py", "tick.k % loop.sampling == 0", "tick.k >= 0", BY_HAND),
    Mutant(
        "an own state that sees the present",
        "closed_loop.py",
        "loop.law.respond(looked, own",
        "loop.law.respond(view, own",
        BY_HAND,
    ),
    Mutant(
        "a command of the present within a step",
        "closed_loop.py",
        "due = False if tick",
        "due = True if tick",
        "test_sampling.py::test_a_command_stands_between_two_instants",
    ),
    Mutant(
        "a look that comes late",
        "closed_loop.py",
        "looked = seen(last.t, last.motion",
        "looked = seen(last.t, control.motion",
        BY_HAND,
    ),
)
