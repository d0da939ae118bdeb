"""Mutants of which draws matter and of other laws: rank dependence, pick-freeze, thinning, densities, refusals."""

from __future__ import annotations

from tests.mutants.mutant import Mutant

RANKS, FREEZE, WEIGHTS = "stats/rank_dependence.py", "stats/pick_freeze.py", "stats/reweighting.py"

XI = "stats/test_rank_dependence.py::test_xi_is_its_definition"
RUNS = "stats/test_rank_dependence.py::test_runs_have_their_exact_law"
SPREAD = "stats/test_rank_dependence.py::test_the_error_is_the_spread"
ISHIGAMI = "stats/test_pick_freeze.py::test_ishigami"
RARE = "stats/test_pick_freeze.py::test_a_rare_indicator_has_exact_bounds"
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
)
