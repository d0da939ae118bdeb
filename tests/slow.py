"""Tests that take several seconds each: they run with `--slow` or `--long`, every night and before a release.

A name without a parameter stands for all parameters of a test, the name of a file for all its tests.
"""

from __future__ import annotations

SLOW = frozenset(
    {
        "acceptance/test_scenarios.py::test_the_shaped_law_captures_and_the_textbook_law_does_not",
        "campaign/test_audit.py::test_a_component_that_does_not_look_at_its_numbers_is_named",
        "campaign/test_audit_fixed.py::test_a_warning_is_on_stderr_and_in_the_report",
        "campaign/test_audit_fixed.py::test_what_changes_no_flight_is_named_and_can_be_allowed",
        "campaign/test_nominal_body.py::test_a_scaled_plant_makes_the_same_motion[saturated-adaptive]",
        "ci/test_pytest_plugin.py::test_an_output_folder_that_exists_is_not_the_root",
        "ci/test_pytest_plugin.py::test_what_only_flying_finds_fails_every_requirement",
        "cli/test_explain.py::test_every_example_is_accepted_when_pasted",
        "cli/test_program.py::test_a_stopped_run_keeps_its_chunks_and_says_how_to_go_on[15-143]",
        "docs/test_extending.py::test_other_components_join_the_campaign",
        "extras/test_extras.py",
        "physics/test_adaptation.py::test_estimates_stay_inside_their_bounds",
        "physics/test_flight.py::test_order_four[filtered-gentle]",
        "physics/test_flight.py::test_what_float32_costs[pd_plus-pd-plus-slow_pd]",
        "physics/test_margins.py::test_a_flight_has_the_margins_of_its_trace",
        "physics/test_margins.py::test_folds_are_the_definition_on_random_traces",
        "physics/test_noise.py::test_noise_is_the_sample_s_own_wherever_it_flies",
        "physics/test_sampling.py::test_where_a_flight_is_interrupted_changes_nothing_of_what_is_held",
        "physics/test_thrusters.py::test_bounded_least_squares_is_that_of_scipy[crooked]",
        "physics/test_thrusters.py::test_bounded_least_squares_is_that_of_scipy[cube-24]",
        "physics/test_thrusters.py::test_the_solution_of_a_step_is_followed_to_first_order[crooked]",
        "reliability/test_cluster_docs.py::test_slurm_script",
        "reliability/test_disk.py::test_a_full_disk",
        "reliability/test_disk.py::test_any_failing_call_of_a_run[28]",
        "reliability/test_disk.py::test_any_failing_call_of_a_run[30]",
        "reliability/test_disk.py::test_any_failing_call_of_a_run[5]",
        "reliability/test_executors.py::test_a_chunk_that_kills_its_workers_is_named_and_all_others_are_kept",
        "reliability/test_executors.py::test_a_chunk_whose_flight_raises_is_named_and_all_others_are_kept",
        "reliability/test_executors.py::test_a_stopped_campaign_goes_on_without_dask[scheduler]",
        "reliability/test_executors.py::test_ctrl_c_in_the_terminal_of_local_workers",
        "reliability/test_executors.py::test_workers_of_this_machine_fly_the_same_bits[1]",
        "reliability/test_fuzzed_campaigns.py::test_hostile_files_are_refused_at_once",
        "reliability/test_injected_texts.py::test_a_report_of_hostile_texts_is_one_of_words",
        "reliability/test_kills.py",
        "report/test_exploration.py::test_independent_samples_keep_their_intervals",
        "report/test_large_run.py::test_quantiles_are_those_of_the_table",
        "report/test_large_run.py::test_the_summary_has_the_keys_of_a_small_run",
        "report/test_report.py::test_extreme_runs_have_a_report[none captured]",
        "run/test_compiling.py::test_another_run_of_the_same_structure_finds_its_programs",
        "run/test_keeping.py::test_a_kept_flight_has_at_most_601_rows[1201-402]",
        "run/test_keeping.py::test_a_kept_flight_has_at_most_601_rows[600-601]",
        "run/test_keeping.py::test_each_way_to_keep_and_from_one_to_another",
        "run/test_process.py::test_a_setting_that_xla_does_not_know_is_left_out_with_a_warning",
        "run/test_process.py::test_devices_share_the_chunks_and_change_no_bit",
        "run/test_process.py::test_outcomes_do_not_depend_on_the_settings",
        "run/test_yardsticks.py",
        "tuning/test_race.py::test_tests_alone_throw_the_best_out_seldom",
        "tuning/test_slopes.py::test_slopes_are_the_differences_of_flights[settling_time_s]",
        "tuning/test_tune.py::test_a_candidate_flies_as_its_campaign_does",
        "tuning/test_tune.py::test_a_sweep_is_compiled_once",
        "tuning/test_unmet.py",
        "worst/test_worst.py::test_a_pocket_that_a_million_samples_miss_is_found_and_replayed",
    }
)
"""Names as pytest prints them, from the folder of the tests on."""
