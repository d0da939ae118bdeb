"""Mutants of what lets users fly their code: reading, executing, checking it, and its identity; effects and actuators."""

from __future__ import annotations

from tests.mutants.mutant import Mutant

FILES, CODE, CHECKS = "campaign/python_files.py", "components/user_code.py", "simulation/user_checks.py"
ARRAYS, LOOP, SLOSH = "components/forms/arrays.py", "simulation/closed_loop.py", "components/effects/slosh_pendulum.py"
FORM = "components/forms/allocation.py"
APPENDAGE, PULSES = "components/effects/flexible_appendage.py", "components/actuators/pulse_width.py"
OBJECTS, CELLS = "components/object_files.py", "user_code/test_notebook_cells.py"
MISTAKES = "user_code/test_user_mistakes.py::test_a_mistake_has_its_line_and_words"
PLANTED = "user_code/test_shipped_mistakes.py::test_a_mistake_in_a_shipped_controller_is_named"
EDITED = "user_code/test_user_identity.py::test_an_edited_file_is_the_new_one_in_a_running_process"
RESUMED = "user_code/test_user_identity.py::test_other_code_does_not_resume_a_folder"
BYTES = "user_code/test_user_identity.py::test_the_bytes_that_are_digested_are_those_that_are_executed"
PENDULUM = "physics/test_effects.py::test_the_pendulum_moves_as_in_the_inertial_frame"
EFFECT = "components/effects/interface.py"
SWING = "physics/test_effects_modes.py::test_a_pendulum_swings_as_its_mode"
MODES = "physics/test_effects_modes.py::test_an_appendage_off_the_centre_has_the_modes_of_two_bodies"
STIFF = "physics/test_effects_modes.py::test_a_stiff_appendage_on_a_turning_body_is_a_mass_on_springs"
SPRING = "physics/test_effects.py::test_a_mass_on_a_spring_is_two_masses"
COUNTED = "physics/test_actuators.py::test_pulses_have_the_impulse_of_their_command"
OPENED = "user_code/test_user_allocations.py"
INSTANTS = "user_code/test_user_flights.py::test_a_discrete_controller_acts_at_its_instants"

MUTANTS = (
    # identity
    Mutant("helpers are not read", FILES, "            todo += _beside(", "            _ = lambda: _beside(", EDITED),
    Mutant("the digest of the file only", FILES, "repr((self.file, self.digests))", "repr((self.file, self.digests[self.file]))", EDITED),
    Mutant("a compiled program by the text alone", "campaign/model.py", "if isinstance(value.use, PythonFile) else []", "if False else []", EDITED),
    Mutant("user files outside of the identity", "execution/identity.py", "part.digests if isinstance", "{} if isinstance", RESUMED),
    Mutant("a file that is read again", CODE, "compile(self._file.sources[source], shown", "compile(open(shown).read(), shown", BYTES),
    Mutant(
        "modules by their names", CODE, 'f"{file.digest} {file.folder}".encode()', 'b""',
        "user_code/test_user_identity.py::test_two_files_of_the_same_name_do_not_meet",
    ),
    Mutant(
        "modules by their code alone", CODE, 'f"{file.digest} {file.folder}".encode()', "file.digest.encode()",
        "user_code/test_user_identity.py::test_the_same_code_in_two_folders_has_two_places",
    ),
    Mutant(
        "a package as it is on the disk", "components/installed_code.py", "if _digest(top) != _digests.get(top, \"\"):", "if False:",
        "user_code/test_user_identity.py::test_an_installed_package_that_changes_is_refused",
    ),
    Mutant(
        "an edit before the first use", "components/installed_code.py", "_newest(top) > _process_start()", "False",
        "user_code/test_user_identity.py::test_a_package_that_changed_before_its_first_use_is_refused",
    ),
    Mutant(
        "a comparison that executes", "components/settings.py", "isinstance(choice.use, PythonFile) and not flies", "False",
        "user_code/test_user_identity.py::test_who_only_reads_executes_nothing",
    ),
    Mutant(
        "a comparison without the code", "analysis/compare.py", "*_code(*folders)", "*()",
        "user_code/test_user_identity.py::test_a_comparison_says_that_the_code_differs",
    ),
    # notebook cells
    Mutant("cells of the same name", FILES, 'f"cell_{hashlib.sha256(data).hexdigest()[:8]}.py"', '"cell_00000000.py"', f"{CELLS}::test_the_cell_that_made_the_component_flies"),
    Mutant("the cell of the functions", OBJECTS, 'if hasattr(component, "made_in"):', "if False:", f"{CELLS}::test_a_name_of_another_cell_is_a_mistake_with_its_line"),
    Mutant("a name of another cell", OBJECTS, "        if name in bound:", "        if True:", f"{CELLS}::test_a_component_without_a_name_is_refused"),
    Mutant("a command in a run folder", OBJECTS, "node.id == _SHELL", "False", f"{CELLS}::test_a_cell_is_plain_python"),
    Mutant("no advice in a cell", CODE, "type(error) is NameError and is_cell(file.file)", "False", f"{CELLS}::test_a_name_of_another_cell_is_a_mistake_with_its_line"),
    Mutant(
        "a flight in itself", "components/user_watch.py", 'if getattr(_state, "paths", None):\n        raise', "if False:\n        raise",
        f"{CELLS}::test_a_cell_that_also_flies_is_refused",
    ),
    # mistakes
    Mutant("the first frame of the user", CODE, "{frames[-1].filename}:{frames[-1].lineno}", "{frames[0].filename}:{frames[0].lineno}", MISTAKES),
    Mutant("any structure of the state", ARRAYS, "if wanted != given:", "if False:", MISTAKES),
    Mutant("undeclared signals", ARRAYS, "[name for name in given if name not in declared]", "[]", MISTAKES),
    Mutant("a trace once", CHECKS, "if not _same(closed, again):", "if False:", MISTAKES),
    Mutant("dead gains", CHECKS, "if not any(uses)", "if False", MISTAKES),
    Mutant("files at trace time", "components/user_watch.py", "if name in _state.paths:", "if False:", MISTAKES),
    Mutant(
        "NaN without a name", "execution/audit_finite.py", "    if not np.all(np.isfinite(lost)):\n        return", "    if True:\n        return",
        "user_code/test_user_flights.py::test_nan_at_once_is_called_by_its_name",
    ),
    Mutant("results of a member's form that nobody looks at", "components/registry.py", "member_results\").checked(built)", "member_results\") and built", PLANTED),
    Mutant(
        "a gain of another option is dead", CHECKS, "for other in _otherwise(model) if dead else ():", "for other in ():",
        "user_code/test_shipped_mistakes.py::test_a_shipped_controller_passes_as_a_file",
    ),
    Mutant(
        "a component of any family", "components/registry.py", "(kind not in (family, ANY) and family != ANY)", "False",
        "user_code/test_shipped_mistakes.py::test_what_is_built_is_of_the_family",
    ),
    # flights
    Mutant("a transposed matrix", ARRAYS, "for row in (rows.a, rows.b, rows.c)", "for row in (rows.a, rows.c, rows.b)",
           "user_code/test_user_flights.py::test_every_family_flies_a_file"),
    Mutant("a discrete law in every step", LOOP, "            due = tick.k % loop.sampling == 0", "            due = tick.k >= 0", INSTANTS),
    Mutant("numbers of another metric", "simulation/chosen_metrics.py", "context.chosen[index]", "context.chosen[0]",
           "user_code/test_user_flights.py::test_every_family_flies_a_file"),
    Mutant("an audit without the state of a discrete-time law", "execution/audit.py", '{"controller": carry.held.control}, accumulators', "accumulators",
           "user_code/test_user_flights.py::test_a_gain_of_an_estimate_acts"),
    # allocations
    Mutant("shares that are not clipped", FORM, "return each(lambda x: jnp.clip(x, 0.0, 1.0), shares)", "return shares",
           f"{OPENED}::test_shares_are_clipped"),
    Mutant("upper and lower limits swapped", FORM, "np.array(layout.most), upper, lower)", "np.array(layout.most), lower, upper)",
           f"{OPENED}::test_a_user_gets_the_nominal_thrusters"),
    Mutant("a name alone without its code", FILES, ", *short_choices(campaign)]", "]", f"{OPENED}::test_the_code_is_part_of_the_run"),
    Mutant("an allocation without its line", CODE, "lambda layout: each(guard(built)(layout))", "guard(built)",
           f"{OPENED}::test_a_mistake_has_its_line_and_words"),
    Mutant("other thrusters than the campaign's", CHECKS, "built(layout or EXAMPLE)", "built(EXAMPLE)",
           f"{OPENED}::test_a_mistake_has_its_line_and_words"),
    Mutant("the controller is blamed for an allocation", "execution/audit_finite.py", "if not _finite(opened):", "if False:",
           f"{OPENED}::test_nan_is_called_by_its_name"),
    Mutant("a program for any centre", "campaign/model.py", "self.saturation, *allocations, self.sampler", "self.saturation, self.sampler",
           "campaign/test_allocations.py::test_a_name_alone_is_the_same_campaign"),
    Mutant("no parameter below a name alone", "campaign/overrides.py", "and isinstance(held.get(key), str)", "and False",
           "campaign/test_allocations.py::test_a_parameter_of_a_name_alone_can_be_set"),
    Mutant("a default that differs from itself", "components/settings.py", "                return choice.use", "                return None",
           "campaign/test_allocations.py::test_a_comparison_lists_what_differs"),
    # effects and actuators
    Mutant("signals of the effect before", "simulation/signals.py", "in enumerate((effects or {}).items()):\n        signals +=", "in enumerate((effects or {}).items(), -1):\n        signals +=",
           "physics/test_effects.py::test_a_campaign_flies_them"),
    Mutant("a wrong effect blamed on its margins", "simulation/margin_checks.py", "_nearest(name, known, few)) if self.effects[effect] else None", "_nearest(name, known, few))",
           "physics/test_effects.py::test_a_wrong_effect_gives_no_second_finding_about_its_signals"),
    Mutant("no reaction in the tension", SLOSH, "(1.0 / body.mass + dot(", "(0.0 / body.mass + dot(", PENDULUM),
    Mutant("no Coriolis term in the tension", SLOSH, "cross(body.rate, x.rate) * (2.0 * l)) - l", "cross(body.rate, x.rate) * l) - l", PENDULUM),
    Mutant("damping without its torque", SLOSH, "alpha = body.free_alpha + apply(", "alpha = body.free_alpha + 0.0 * apply(", PENDULUM),
    Mutant("a tension of a body that does not turn", SLOSH, "dot(lever, apply(body.inertia_inverse, lever))", "0.0 * dot(lever, lever)", PENDULUM),
    Mutant("a bob that does not feel the body turn", SLOSH, "accel + turned(body.rate, alpha, place(x, numbers))", "accel + turned(body.rate, alpha * 0.0, place(x, numbers))", SWING),
    Mutant("an appendage that does not feel the body turn", EFFECT, "cross(alpha, arm) + cross(rate, cross(rate, arm))", "cross(rate, cross(rate, arm))", MODES),
    Mutant("an appendage without centrifugal acceleration", EFFECT, "cross(alpha, arm) + cross(rate, cross(rate, arm))", "cross(alpha, arm)", STIFF),
    Mutant("the moment of the appendage the other way", APPENDAGE, "cross(numbers.place_m, force)", "cross(force, numbers.place_m)", MODES),
    Mutant("no reaction of the appendage", APPENDAGE, "force = pull(x, numbers) * numbers.modal_mass_kg", "force = pull(x, numbers) * 0.0", SPRING),
    Mutant("half the damping of an appendage", APPENDAGE, "2.0 * numbers.damping * w * v", "numbers.damping * w * v",
           "physics/test_effects.py::test_damping_is_that_of_the_held_body"),
    Mutant("whole steps of a pulse", PULSES, "(jnp.abs(x) - since) / tick.h, 0.0, 1.0", "jnp.ceil((jnp.abs(x) - since) / tick.h), 0.0, 1.0", COUNTED),
    Mutant("no shortest pause", PULSES, "jnp.where(period - on < shortest, period, on)", "on", COUNTED),
    Mutant("a pulse of the upper limit", PULSES, "jnp.where(x >= 0.0, upper, lower), memory.share", "upper, memory.share", COUNTED),
    Mutant(
        "a rate in absolute units", "components/actuators/rate_limit.py", "limits.upper * (numbers.rate", "limits.upper * 0.0 + (numbers.rate",
        "physics/test_actuators.py::test_the_rate_is_limited",
    ),
    Mutant(
        "the gain of the predictor", "physics/riccati.py", "return p @ inverted(p + noise)", "return a @ p @ inverted(p + noise)",
        "physics/test_lqr_kalman.py::test_the_filter_solves_the_riccati_equation",
    ),
    Mutant(
        "a prediction in a frame that does not turn", "components/controllers/lqr_kalman.py", "rho=rotate(turned, rho + nu", "rho=(rho + nu",
        "physics/test_lqr_kalman.py::test_its_prediction_is_what_comes",
    ),
)  # fmt: skip
