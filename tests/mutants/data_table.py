"""Mutants of the statistics, the verdicts and the run folder."""

from __future__ import annotations

from tests.mutants.mutant import Mutant

BINOMIAL, QUANTILES, SEQUENTIAL, PAIRED = (f"stats/{name}.py" for name in ("binomial", "quantiles", "sequential", "paired"))
FAMILIES, MEANS = "stats/multiplicity.py", "stats/means.py"
SHARES, FILES = "analysis/verdicts/share_tally.py", "run_folder/atomic_files.py"
JOURNAL, MANIFEST, TABLE = "run_folder/journal.py", "run_folder/manifest.py", "run_folder/samples_table.py"
STORE, LOCAL, OBJECTS = "run_folder/store.py", "run_folder/local_storage.py", "run_folder/object_storage.py"

BOUNDARY = "stats/test_fixed.py::test_boundary_is_that_of_the_clopper_pearson_bounds"
COVERS = "stats/test_quantiles.py::test_quantile_interval_covers_exactly_as_promised"
REACHED = "stats/test_sequential.py::test_boundaries_are_where_the_evidence_reaches_its_limit"
THEOREM = "stats/test_means.py::test_bound_is_theorem_4"
NEWCOMBE = "stats/test_paired.py::test_intervals_reproduce_published_ones"
DAMAGE = "results/test_run_folder.py::test_no_damage_goes_unnoticed"

MUTANTS = (
    # shares
    Mutant(
        "a bound of both sides for one",
        BINOMIAL,
        "special.betaincinv(some, size - k + 1, 1 - confidence)",
        "special.betaincinv(some, size - k + 1, (1 - confidence) / 2)",
        "stats/test_shares.py::test_bound_without_a_failure_is_the_root_of_the_risk",
    ),
    Mutant(
        "one failure too few in a bound",
        BINOMIAL,
        "betaincinv(some, size - k + 1,",
        "betaincinv(some, size - k,",
        "stats/test_shares.py::test_lower_bound_solves_its_equation_in_exact_arithmetic",
    ),
    Mutant(
        "an interval with the risk of one side on each",
        BINOMIAL,
        "    side = (1 + confidence) / 2",
        "    side = confidence",
        "stats/test_shares.py::test_two_sided_interval_reproduces_the_published_one",
    ),
    Mutant(
        "half the risk in a number of samples",
        BINOMIAL,
        "binomial_cdf(failures, n, 1 - q) <= 1 - confidence)",
        "binomial_cdf(failures, n, 1 - q) <= (1 - confidence) / 2)",
        "stats/test_shares.py::test_smallest_n_reproduces_the_published_table",
    ),
    Mutant(
        "PASS at twice the risk",
        BINOMIAL,
        "binomial_cdf(k, size, 1 - p0) <= risk",
        "binomial_cdf(k, size, 1 - p0) <= 2 * risk",
        BOUNDARY,
    ),
    Mutant(
        "FAIL one failure early",
        BINOMIAL,
        "Boundary(n, passes, n - successes)",
        "Boundary(n, passes, n - successes - 1)",
        BOUNDARY,
    ),
    # quantiles
    Mutant(
        "a quantile one rank too low",
        QUANTILES,
        "math.ceil(n * q - 1e-9)",
        "math.floor(n * q - 1e-9)",
        "stats/test_quantiles.py::test_quantile_is_a_value_that_occurred",
    ),
    Mutant(
        "ends of an interval exchanged",
        QUANTILES,
        "_upper_rank(n, 1 - q, side), _upper_rank(n, q, side)",
        "_upper_rank(n, q, side), _upper_rank(n, 1 - q, side)",
        COVERS,
    ),
    Mutant(
        "a quantile with the risk of one side on each",
        QUANTILES,
        "    side = (1 + confidence) / 2",
        "    side = confidence",
        COVERS,
    ),
    Mutant(
        "a band of one side",
        QUANTILES,
        "math.log(2 / (1 - confidence))",
        "math.log(1 / (1 - confidence))",
        "stats/test_quantiles.py::test_band_holds_everywhere_at_once",
    ),
    Mutant(
        "half the ranks of a tolerance interval",
        QUANTILES,
        "binomial_cdf(2 * m - 1, n, 1 - q)",
        "binomial_cdf(m - 1, n, 1 - q)",
        "stats/test_quantiles.py::test_tolerance_interval_is_the_narrowest_of_equal_ranks",
    ),
    # several at once
    Mutant(
        "Bonferroni for Holm",
        FAMILIES,
        "np.arange(p.size, 0, -1) * p[order]",
        "p.size * p[order]",
        "stats/test_families.py::test_a_known_example",
    ),
    Mutant(
        "adjusted values that fall",
        FAMILIES,
        "np.maximum.accumulate(np.arange(p.size, 0, -1) * p[order])",
        "np.arange(p.size, 0, -1) * p[order]",
        "stats/test_families.py::test_adjusted_p_values_are_those_of_the_closed_test",
    ),
    # looks
    Mutant("evidence of twice the risk", SEQUENTIAL, "-np.log(alpha)\n    passes", "-np.log(2 * alpha)\n    passes", REACHED),
    Mutant(
        "a mixture without its weight",
        SEQUENTIAL,
        "np.log(scipy.special.betainc(0.5, 0.5, q)) + np.log(np.pi)",
        "np.log(np.pi)",
        "stats/test_sequential.py::test_e_is_the_mixture_of_likelihood_ratios",
    ),
    Mutant(
        "a failure that speaks for PASS",
        SEQUENTIAL,
        "(size - f) * gain - f * loss",
        "(size - f) * gain + f * loss",
        "stats/test_sequential.py::test_the_ratio_is_that_of_two_binomial_laws",
    ),
    Mutant("the limit of FAIL with the other sign", SEQUENTIAL, "(reach - np.log(beta))", "(reach + np.log(beta))", REACHED),
    # pairs
    Mutant(
        "the better design exchanged",
        PAIRED,
        '"a": c, "b": b}',
        '"a": b, "b": c}',
        "stats/test_paired.py::test_mcnemar_is_the_binomial_test_of_the_pairs_that_differ",
    ),
    Mutant(
        "mid-p without the observed half",
        PAIRED,
        "(p + binomial_cdf(k - 1, n, 0.5)) / 2",
        "binomial_cdf(k - 1, n, 0.5)",
        "stats/test_paired.py::test_mcnemar_reproduces_published_p_values",
    ),
    Mutant("no correction of the correlation", PAIRED, "(max(excess - n / 2, 0) if excess > 0 else excess)", "excess", NEWCOMBE),
    Mutant(
        "the margin on the other side",
        PAIRED,
        "-_score(f, g, pairs.n, -margin)",
        "-_score(f, g, pairs.n, margin)",
        "stats/test_paired.py::test_noninferiority_is_the_lower_end_of_tangos_interval",
    ),
    Mutant(
        "the supremum at no nuisance share",
        "stats/paired_exact.py",
        "best = float(values.max())",
        "return float(values[0])",
        "stats/test_paired_exact.py::test_p_is_the_supremum_over_the_nuisance_share",
    ),
    Mutant(
        "the observed table not among the extreme",
        "stats/paired_exact.py",
        "z >= seen - tolerance",
        "z > seen + tolerance",
        "stats/test_paired_exact.py::test_p_is_the_supremum_over_the_nuisance_share",
    ),
    Mutant(
        "evidence without the pairs for B",
        PAIRED,
        "(b + c) * math.log(2)",
        "b * math.log(2)",
        "stats/test_paired.py::test_e_value_of_pairs",
    ),
    # means
    Mutant(
        "a bound without its range",
        MEANS,
        "(high - low) * 7 * log",
        "7 * log",
        "stats/test_means.py::test_bounds_move_with_the_unit",
    ),
    Mutant("the variance of a population", MEANS, "ddof=1", "ddof=0", THEOREM),
    # verdicts
    Mutant(
        "doubt before failure",
        "analysis/verdicts/verdict.py",
        '1 if "FAIL" in words else 3 if "UNDECIDED" in words else 0',
        '3 if "UNDECIDED" in words else 1 if "FAIL" in words else 0',
        "stats/test_verdicts.py::test_exit_code_prefers_failure_to_doubt",
    ),
    Mutant(
        "chunks counted behind a gap",
        SHARES,
        "            if first != behind:\n                break\n",
        "",
        "stats/test_forms.py::test_chunks_in_any_order_and_none_behind_a_gap",
    ),
    Mutant(
        "a decision that later samples change",
        SHARES,
        "at = evidence.decided if evidence.decided is not None else len(evidence.samples) - 1",
        "at = len(evidence.samples) - 1",
        "stats/test_forms.py::test_the_first_look_with_enough_evidence_decides",
    ),
    Mutant(
        "FAIL by the observed share",
        SHARES,
        '"FAIL" if estimate.high < requirement.limit',
        '"FAIL" if estimate.value < requirement.limit',
        "stats/test_verdicts.py::test_wrong_verdicts_are_no_likelier_than_promised",
    ),
    # the run folder
    Mutant(
        "a write that is not compared",
        FILES,
        "if temporary.read_bytes() != data:",
        "if False:",
        "results/test_disk_failures.py::test_what_the_disk_gives_back_is_compared",
    ),
    Mutant(
        "a name before the bytes are durable",
        FILES,
        "                os.fsync(file.fileno())\n",
        "",
        "results/test_disk_failures.py::test_bytes_are_durable_before_they_have_a_name",
    ),
    Mutant(
        "a lock that two may have",
        FILES,
        "fcntl.LOCK_EX | fcntl.LOCK_NB",
        "fcntl.LOCK_SH | fcntl.LOCK_NB",
        "results/test_resuming.py::test_one_process_writes_at_a_time",
    ),
    Mutant("a journal that is not checked", JOURNAL, 'if _checked(line[_CHECK:-1]) != line + b"\\n":', "if False:", DAMAGE),
    Mutant(
        "half a line before the next one",
        LOCAL,
        "os.ftruncate(self._handle, self._length)",
        "pass",
        "results/test_disk_failures.py::test_a_run_may_go_on_behind_a_line_that_did_not_fit",
    ),
    Mutant(
        "lines of a group whose names are not durable",
        LOCAL,
        "for folder in sorted({(self.place / name).parent for name in names}):",
        "for folder in sorted({(self.place / name).parent for name in names})[1:]:",
        "results/test_group_commit.py::test_names_are_durable_before_the_lines_and_synced_once",
    ),
    Mutant(
        "a group whose files are not compared with each other",
        STORE,
        "entries.get(key) or new.get(key)",
        "entries.get(key)",
        "results/test_group_commit.py::test_two_tables_of_one_chunk_in_a_group_are_an_alarm",
    ),
    Mutant(
        "a group that is committed without its lines",
        STORE,
        "for key in new:\n                del entries[key]",
        "pass",
        "results/test_group_commit.py::test_lines_that_did_not_fit_commit_no_file_of_the_group",
    ),
    Mutant(
        "an entries file that is not checked",
        JOURNAL,
        "if atomic_files.sha256(data) != entries.sha256:",
        "if False:",
        "results/test_large_folders.py::test_a_bit_anywhere_in_the_entries_file_is_noticed",
    ),
    Mutant(
        "a journal that grows with the run",
        JOURNAL,
        " or self._lines >= self.storage.most_lines",
        "",
        "results/test_large_folders.py::test_the_journal_stays_short",
    ),
    Mutant(
        "an older entries file that stays",
        JOURNAL,
        "            self._sweep()\n",
        "",
        "results/test_large_folders.py::test_a_stop_between_two_steps_of_a_fold",
    ),
    Mutant(
        "a replaced entry that stays in the columns",
        "run_folder/entries.py",
        "kept[replaced[replaced >= 0]] = False",
        "pass",
        "results/test_entries.py::test_entries_are_what_a_dictionary_would_be",
    ),
    Mutant(
        "a file of another size that counts",
        "run_folder/stock.py",
        "listed & (sizes == entries.size[rows])",
        "listed",
        "results/test_entries.py::test_stock_is_that_of_every_name",
    ),
    Mutant(
        "an answer that was lost taken for another writer",
        OBJECTS,
        "            return self.read(name) == data\n        return True",
        "            return False\n        return True",
        "results/test_object_storage.py::test_a_store_that_fails_one_request_in_twenty",
    ),
    Mutant(
        "a manifest that is replaced whatever is there",
        OBJECTS,
        'condition = self._etags.get(name, "new")',
        "condition = None",
        "results/test_object_storage.py::test_a_lease_that_was_taken_over_is_noticed",
    ),
    Mutant(
        "a commit into a journal that another writer has folded",
        OBJECTS,
        "if not self._storage.unchanged(MANIFEST):",
        "if False:",
        "results/test_object_storage.py::test_a_writer_that_was_taken_for_dead_is_refused",
    ),
    Mutant(
        "a lease that nobody looks at",
        OBJECTS,
        'if holder is not None and holder["until"] > time.time() and not _ended(holder):',
        "if False:",
        "results/test_object_storage.py::test_a_second_writer_is_refused",
    ),
    Mutant(
        "a store without conditional writes",
        OBJECTS,
        """for condition in ("new", '"00000000000000000000000000000000"'):""",
        "for condition in ():",
        "results/test_object_storage.py::test_a_store_that_ignores_conditions_is_refused",
    ),
    Mutant(
        "a request that is not repeated",
        "run_folder/object_client.py",
        "for attempt in range(ATTEMPTS - 1):",
        "for attempt in range(0):",
        "results/test_object_storage.py::test_a_store_that_fails_one_request_in_twenty",
    ),
    Mutant("a manifest that is not checked", MANIFEST, "if body + _seal(body) != data:", "if False:", DAMAGE),
    Mutant(
        "an audit that does not add up",
        MANIFEST,
        "self.acting != len(self.moved) or ",
        "",
        "results/test_audit_record.py::test_a_record_that_does_not_add_up_is_none",
    ),
    Mutant(
        "RK4 without its middle weight",
        "components/effect.py",
        "4.0 * value(t + 0.5 * h)",
        "2.0 * value(t + 0.5 * h)",
        "campaign/test_audit_fixed.py::test_a_pulse_with_edges_shorter_than_a_step_is_warned_of",
    ),
    Mutant(
        "an audit without the instants in the middle of a step",
        "components/effect.py",
        "room, half = rounding_s(spec), 0.5 * spec.horizon.step_s",
        "room, half = rounding_s(spec), spec.horizon.step_s",
        "campaign/test_audit_fixed.py::test_an_input_that_acts_in_some_sample_passes",
    ),
    Mutant(
        "a pulse whose flat top has no impulse",
        "components/wrench_over_time.py",
        " + np.maximum(x - 1.0, 0.0)",
        "",
        "campaign/test_audit_fixed.py::test_a_pulse_with_edges_shorter_than_a_step_is_warned_of",
    ),
    Mutant(
        "a fault after the end that passes",
        "components/faults/effect.py",
        "if low >= spec.horizon.duration_s:",
        "if low > 2.0 * spec.horizon.duration_s:",
        "campaign/test_audit_fixed.py::test_an_input_that_does_nothing_is_named_and_can_be_allowed",
    ),
    Mutant(
        "a probe that switches nothing off",
        "execution/audit_fixed.py",
        "np.where(samples, value, leaf)",
        "leaf",
        "campaign/test_audit_fixed.py::test_a_thruster_is_switched_off_alone",
    ),
    Mutant(
        "rows in the order of the chunks",
        TABLE,
        'frame.sort_values("sample", kind="stable", ignore_index=True)',
        "frame",
        "results/test_run_folder.py::test_rows_come_in_the_order_of_the_samples",
    ),
    Mutant(
        "one sample more than was requested",
        TABLE,
        "sample[-1] >= requested",
        "sample[-1] > requested",
        "results/test_run_folder.py::test_samples_that_are_twice_or_were_not_requested_are_refused",
    ),
    Mutant(
        "an account that does not add up",
        TABLE,
        "min(parts) < 0 or sum(parts) != self.requested",
        "min(parts) < 0",
        "stats/test_totals.py::test_the_account_adds_up",
    ),
    Mutant(
        "pages without checksums",
        "run_folder/parquet.py",
        "write_page_checksum=True",
        "write_page_checksum=False",
        "results/test_run_folder.py::test_pages_carry_checksums",
    ),
    # the nominal body
    Mutant(
        "Steiner's term with the other sign",
        "campaign/nominal_body.py",
        "about_reference - 2.0",
        "about_reference + 2.0",
        "campaign/test_nominal_body.py::test_the_nominal_inertia_is_about_the_centre_of_mass",
    ),
    Mutant(
        "a law of 100 kg on every plant",
        "simulation/problem.py",
        "body.complete(form, values)",
        "values",
        "campaign/test_nominal_body.py::test_a_law_is_scaled_to_the_plant_that_it_flies",
    ),
    Mutant(
        "a guess that is warned about on one side only",
        "simulation/plausibility.py",
        "nominal / TWICE <= value <= nominal * TWICE",
        "value <= nominal * TWICE",
        "campaign/test_plausibility.py::test_a_guess_may_be_half_or_twice_the_nominal_mass",
    ),
    # merging
    Mutant(
        "samples of two folds counted twice",
        "analysis/ledger.py",
        "        if doubled:",
        "        if False:",
        "stats/test_merging.py::test_a_sample_in_two_chunks_is_refused",
    ),
    Mutant(
        "times of lost flights that a merge forgets",
        "analysis/run_totals.py",
        "        self._lost.merge(other._lost)",
        "        pass",
        "stats/test_merging.py::test_order_and_grouping_of_merges_change_no_bit",
    ),
    Mutant(
        "totals of other requirements decoded",
        "analysis/accumulator.py",
        'if record.document["purpose"] != accumulator._purpose:',
        "if False:",
        "stats/test_merging.py::test_totals_of_another_purpose_are_refused",
    ),
)
