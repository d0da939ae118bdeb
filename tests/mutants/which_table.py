"""Mutants of which draws matter and of other laws: rank dependence, pick-freeze, thinning, densities, refusals."""

from __future__ import annotations

from tests.mutants.mutant import Mutant

DRIVERS = "analysis/drivers.py"
DENSITIES, LAWS = "stats/densities.py", "stats/other_laws.py"
GROUPS = "search/sensitivity.py"
CHECKS, REWEIGH, NAMED = "simulation/law_checks.py", "execution/reweigh.py", "simulation/named_laws.py"
COMPLIANCE, SLOPES = "analysis/verdicts/compliance.py", "stats/slopes.py"
UNDER = "reweigh/test_under.py"
RANKS, FREEZE, WEIGHTS = "stats/rank_dependence.py", "stats/pick_freeze.py", "stats/reweighting.py"

XI = "stats/test_rank_dependence.py::test_xi_is_its_definition"
RUNS = "stats/test_rank_dependence.py::test_runs_have_their_exact_law"
SPREAD = "stats/test_rank_dependence.py::test_the_error_is_the_spread"
ISHIGAMI = "stats/test_pick_freeze.py::test_ishigami"
RARE = "stats/test_pick_freeze.py::test_a_rare_indicator_has_exact_bounds"
SEEN = "report/test_which_draws.py::test_every_form_is_seen_and_lost_flights_count"
EXCHANGED = "sensitivity/test_sensitivity.py::test_a_group_exchanges_its_numbers_and_no_other"
SUPREMUM = "stats/test_densities.py::test_the_supremum_is_exact"
REFUSED = "reweigh/test_reweigh.py::test_refusals_name_the_place_and_the_fresh_run"
KEPT = "stats/test_reweighting.py::test_what_is_kept_has_the_new_law"

MUTANTS = (
    Mutant("xi: ranks without equals", RANKS, 'values, side="right").astype', 'values, side="left").astype', XI),
    Mutant(
        "xi: a variance for many values alone",
        RANKS,
        "variance = (n - 2) * (4 * n - 7) / (10 * (n + 1) * (n - 1) ** 2)",
        "variance = 0.4 / n",
        "stats/test_rank_dependence.py::test_the_normal_p_has_the_exact_null_variance",
    ),
    Mutant("runs: even numbers half as probable", RANKS, "even = math.log(2.0) + ", "even = ", RUNS),
    Mutant(
        "permutations: the last p for all beyond",
        RANKS,
        "if reached >= SEEN:",
        "if True:",
        "stats/test_rank_dependence.py::test_far_tails_fall_and_never_reach_0",
    ),
    Mutant(
        "xi: equal x in the order of the samples",
        RANKS,
        "np.lexsort((rng.random(values.size), values))",
        'np.argsort(values, kind="stable")',
        "stats/test_rank_dependence.py::test_equal_x_are_in_a_random_order",
    ),
    Mutant("rank index: neighbours are independent", RANKS, "2.0 * (covariances[1] - covariances[2])", "0.0", SPREAD),
    Mutant("pick-freeze: a and b exchanged", FREEZE, "for x in (b, a))", "for x in (a, b))", ISHIGAMI),
    Mutant(
        "pick-freeze: intervals of one index each",
        FREEZE,
        "each = 1.0 - (1.0 - confidence) / (2.0 * max(1, len(parts)))",
        "each = confidence",
        "stats/test_pick_freeze.py::test_intervals_hold_together",
    ),
    Mutant(
        "pick-freeze: indicators by the delta method",
        FREEZE,
        "    if marks:\n",
        "    if False:\n",
        "stats/test_pick_freeze.py::test_lost_flights",
    ),
    Mutant("pick-freeze: q of all rows", FREEZE, "clopper_pearson(both, any_, level)", "clopper_pearson(both, n, level)", RARE),
    Mutant(
        "pick-freeze: the mean of the curves",
        FREEZE,
        "float(cov.sum() / var.sum()) if var.sum() > 0.0",
        "float(np.mean(cov / var)) if var.sum() > 0.0",
        "stats/test_pick_freeze.py::test_over_time_from_running_sums",
    ),
    Mutant(
        "no bit changed: alpha over n",
        FREEZE,
        "1.0 - (1.0 - confidence) ** (1.0 / n) if n",
        "1.0 - (1.0 - confidence) / n if n",
        "stats/test_pick_freeze.py::test_a_group_that_changes_no_bit",
    ),
    Mutant("thinning: without the supremum", WEIGHTS, "< weights - log_sup", "< weights", KEPT),
    Mutant(
        "thinning: a weight above the supremum",
        WEIGHTS,
        "if weights.size and float(weights.max()) > log_sup + CLOSE:",
        "if False:",
        "stats/test_reweighting.py::test_a_weight_above_the_supremum_is_refused",
    ),
    Mutant(
        "weights: the control variate is not used",
        WEIGHTS,
        "share = float(product.mean()) - beta * (float(weights.mean()) - 1.0)",
        "share, beta = float(product.mean()), 0.0",
        "stats/test_reweighting.py::test_the_control_variate_is_sharper",
    ),
    Mutant(
        "weights: nothing is lost beyond",
        WEIGHTS,
        "inside.low * within, inside.high * within + beyond",
        "inside.low, inside.high * within + beyond",
        "stats/test_reweighting.py::test_what_lies_beyond_is_unknown",
    ),
    Mutant(
        "classes: bars of one class each",
        WEIGHTS,
        "each = 1.0 - (1.0 - confidence) / len(present)",
        "each = confidence",
        "stats/test_reweighting.py::test_classes_have_bars_that_hold_together",
    ),
    Mutant("drivers: lost flights stay in the index", DRIVERS, "inside = order[finite[order]]", "inside = order[-n:]", SEEN),
    Mutant(
        "drivers: p-values of each pair by itself",
        DRIVERS,
        "adjusted = [float(p) for p in holm([pair.p or 0.0 for pair in pairs])]",
        "adjusted = [pair.p for pair in pairs]",
        "report/test_which_draws.py::test_p_values_are_holms_for_all_pairs",
    ),
    Mutant(
        "drivers: a test of an exploration",
        DRIVERS,
        "independent = isinstance(design, Independent)",
        "independent = True",
        "report/test_which_draws.py::test_an_exploration_has_no_p",
    ),
    Mutant(
        "drivers: an index that a flight decides",
        DRIVERS,
        "if float(squares.max()) > max(LARGEST_PART, LEAST_PARTS / n) * float(squares.sum()):",
        "if False:",
        "report/test_which_draws.py::test_an_index_that_a_flight_decides_is_not_shown",
    ),
    Mutant(
        "density: a truncated law without its share",
        DENSITIES,
        "- HALF_LOG_2PI - whole)",
        "- HALF_LOG_2PI)",
        "stats/test_densities.py::test_density_is_that_of_scipy",
    ),
    Mutant("supremum: at points only", DENSITIES, "for _ in range(REFINED):", "for _ in range(0):", SUPREMUM),
    Mutant("supremum: tails have no effect", DENSITIES, "float(known[-1] - known[-2]) > 1e-9", "False", SUPREMUM),
    Mutant(
        "supremum: the part beyond is not divided out",
        DENSITIES,
        "return Ratio(best - math.log1p(-beyond), beyond)",
        "return Ratio(best, beyond)",
        SUPREMUM,
    ),
    Mutant(
        "thinning: numbers of the stream of a draw",
        LAWS,
        'STREAM = "reweigh.thin"',
        'STREAM = "faults.effectiveness.remaining.fx"',
        "reweigh/test_reweigh.py::test_thinning_is_that_of_the_named_stream",
    ),
    Mutant(
        "weights: the wrong way round",
        LAWS,
        "found = log_density(self.new, x) - log_density(self.old, x)",
        "found = log_density(self.old, x) - log_density(self.new, x)",
        "reweigh/test_reweigh.py::test_what_lies_beyond_widens_the_interval",
    ),
    Mutant(
        "reweigh: correlated draws", CHECKS, "if any(name in group.names for group in dispersions.groups):", "if False:", REFUSED
    ),
    Mutant("reweigh: other steps", CHECKS, "if before.get(place) != after.get(place):", "if False:", REFUSED),
    Mutant("reweigh: any reach", CHECKS, "if not findings and law.beyond > MOST_BEYOND:", "if False:", REFUSED),
    Mutant(
        "reweigh: plans too",
        CHECKS,
        "if not isinstance(sampling_design_of(self.old.spec), Independent):",
        "if False:",
        "reweigh/test_reweigh.py::test_samples_of_a_plan_are_refused",
    ),
    Mutant("reweigh: a handful kept", REWEIGH, "elif kept < FEWEST_KEPT:", "elif kept < 0:", REFUSED),
    Mutant(
        "reweigh: the share of all samples of the run",
        REWEIGH,
        "inside = good[mask[chosen]]",
        "inside = good & mask[chosen]",
        "reweigh/test_reweigh.py::test_a_narrower_uniform_keeps_the_samples_inside",
    ),
    Mutant(
        "reweigh: a fresh run with another controller",
        NAMED,
        "pins = followers(problem, new)",
        "pins = followers(problem, problem)",
        "reweigh/test_reweigh.py::test_what_follows_from_a_law_stays_as_flown",
    ),
    Mutant(
        "groups: noise stays",
        "simulation/draws.py",
        "self.samples if self.noise is None else self.noise(name)",
        "self.samples",
        EXCHANGED,
    ),
    Mutant(
        "groups: redraws stay",
        "simulation/dispersions.py",
        'self.noise(samples, next(iter(retry.counts), ""))',
        "samples",
        EXCHANGED,
    ),
    Mutant(
        "groups: correlated draws apart",
        GROUPS,
        "if len(joined) > 1:",
        "if False:",
        "sensitivity/test_sensitivity.py::test_groups_are_sections_faults_and_noise",
    ),
    Mutant(
        "groups: A and B exchanged over time",
        GROUPS,
        "for sums, base in ((shared, SECOND), (kept, FIRST)):",
        "for sums, base in ((shared, FIRST), (kept, SECOND)):",
        "sensitivity/test_sensitivity.py::test_the_indices_of_real_flights",
    ),
    Mutant(
        "reweigh: a run that stopped when it was decided",
        REWEIGH,
        "if folder.requested < problem.spec.samples:",
        "if False:",
        "reweigh/test_reweigh.py::test_a_run_that_stopped_when_it_was_decided",
    ),
    Mutant(
        "curves: bars of one draw alone",
        "report/sections/epistemic.py",
        "each = 1.0 - (1.0 - CONFIDENCE) / len(names)",
        "each = CONFIDENCE",
        "report/test_epistemic.py::test_the_curves_are_the_classes_with_bars_for_all",
    ),
    Mutant(
        "slopes: a score that is not centred",
        SLOPES,
        "terms = (y - float(y.mean())) * s",
        "terms = y * s",
        "stats/test_law_slopes.py::test_they_are_the_difference_of_other_weights",
    ),
    Mutant(
        "slopes: one side of the difference",
        SLOPES,
        "for side in (1.0, -1.0))  # pyright",
        "for side in (1.0, 0.0))  # pyright",
        "stats/test_law_slopes.py::test_scores_are_their_closed_forms",
    ),
    Mutant(
        "slopes: the outer share against all",
        SLOPES,
        "for part in (outside, ~outside)",
        "for part in (outside, outside | True)",
        "stats/test_law_slopes.py::test_ends_have_exact_secants",
    ),
    Mutant(
        "slopes: a tenth of the width",
        SLOPES,
        "cut = float(law.ppf(OUTER))",
        "cut = law.low + OUTER * (law.high - law.low)",
        "stats/test_law_slopes.py::test_ends_have_exact_secants",
    ),
    Mutant(
        "slopes: normal intervals of a handful",
        SLOPES,
        "if few < FEWEST_OF_EACH:",
        "if few < 0:",
        "stats/test_law_slopes.py::test_what_has_no_slope",
    ),
    Mutant(
        "slopes: bounds of one row",
        "execution/slopes.py",
        "(1.0 - confidence) / sum(len(parameters(law)) for _, law in laws.values())",
        "(1.0 - confidence)",
        "reweigh/test_slopes_of_run.py::test_a_slope_is_that_of_the_table",
    ),
    Mutant(
        "slopes: correlated draws",
        "execution/slopes.py",
        "if obstacle is not None:",
        "if False:",
        "reweigh/test_slopes_of_run.py::test_what_is_left_out_is_named",
    ),
    Mutant(
        "groups: one joins the section of its name",
        GROUPS,
        "if _section(name) == group and not",
        "if False and not",
        "sensitivity/test_sensitivity.py::test_groups_of_ones_own",
    ),
    Mutant(
        "under: all samples count",
        COMPLIANCE,
        'return law.keeps(frame["sample"].to_numpy(dtype=np.int64), self._drawn(law, frame))',
        "return law.possible(self._drawn(law, frame))",
        f"{UNDER}::test_a_verdict_counts_the_kept_samples",
    ),
    Mutant(
        "under: a false pass",
        COMPLIANCE,
        "return self.kept(frame) & self.of_class(frame)",
        "return self.of_class(frame)",
        f"{UNDER}::test_a_baseline_is_of_the_kept_samples",
    ),
    Mutant(
        "under: the class alone",
        "analysis/verdicts/share_tally.py",
        "chosen = kept & self.evaluator.of_class(frame)",
        "chosen = self.evaluator.of_class(frame)",
        f"{UNDER}::test_the_risk_of_a_false_pass_is_the_stated_one",
    ),
    Mutant(
        "under: another stream",
        LAWS,
        "uniforms(self.seed, STREAM, samples)",
        "uniforms(self.seed, STREAM, samples - samples[:1])",
        f"{UNDER}::test_a_verdict_counts_the_kept_samples",
    ),
    Mutant(
        "under: the largest weight of the sample",
        LAWS,
        "return kept(self.log_weights(drawn), self.log_sup,",
        "return kept(self.log_weights(drawn), float(self.log_weights(drawn).max()),",
        f"{UNDER}::test_a_verdict_counts_the_kept_samples",
    ),
    Mutant(
        "under: laws that come after the flights",
        "execution/identity.py",
        "if problem.laws else {}),",
        "if False else {}),",
        f"{UNDER}::test_a_law_that_comes_later_is_another_run",
    ),
    Mutant(
        "under: unknown laws ignored",
        COMPLIANCE,
        "if law is None and self.requirement.under is not None:",
        "if False:",
        f"{UNDER}::test_without_its_law_a_requirement_is_not_judged",
    ),
    Mutant(
        "under: old laws read as new ones",
        LAWS,
        'old, new = _law_of(item["old"]), _law_of(item["new"])',
        'new, old = _law_of(item["old"]), _law_of(item["new"])',
        f"{UNDER}::test_a_folder_gives_the_laws_back",
    ),
    Mutant(
        "under: thinned twice",
        REWEIGH,
        'requirement.model_copy(update={"under": None}) if requirement.under else requirement',
        "requirement",
        f"{UNDER}::test_reweigh_shows_a_named_law",
    ),
    Mutant(
        "under: laws that reach beyond are judged",
        NAMED,
        "if law.beyond > 0.0:",
        "if False:",
        "campaign/test_campaign.py::test_bad_file",
    ),
    Mutant(
        "under: too few kept",
        NAMED,
        "elif kept < FEWEST_KEPT:",
        "elif kept < 0:",
        "campaign/test_campaign.py::test_bad_file",
    ),
)
