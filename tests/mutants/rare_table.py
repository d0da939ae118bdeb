"""Mutants of rare failures: splitting, importance sampling, their bounds, margins and verdicts."""

from __future__ import annotations

from tests.mutants.mutant import Mutant

SPLITTING, IMPORTANCE, REPLICATES = (f"stats/rare/{name}.py" for name in ("splitting", "importance", "replicates"))
MIXTURE, TAIL, CHECK, POINTS = (f"stats/rare/{name}.py" for name in ("gaussian_mixture", "tail_index", "level_check", "points"))

SPACE, VERDICTS = "execution/draw_space.py", "analysis/verdicts/rare.py"

SIGNS = "rare/test_rare_search.py::test_margins_have_the_sign_of_the_verdict"
AGAIN = "rare/test_rare_search.py::test_a_failing_flight_flies_again"
RESTS = "rare/test_rare_verdicts.py::test_what_a_verdict_rests_on"
MET = "stats/test_rare_splitting.py::test_the_probability_is_met"
SEEDS = "stats/test_rare_splitting.py::test_survivors_begin_equally_many_chains"
MOVES = "stats/test_rare_splitting.py::test_moves_keep_the_normal_law_and_the_keys"
REFUSED = "stats/test_rare_importance.py::test_weights_that_cannot_be_trusted_are_refused"

MUTANTS = (
    Mutant("moves accepted wherever they lead", SPLITTING, "inside = came <= level", "inside = came <= np.inf", MET),
    Mutant(
        "survivors above the level",
        SPLITTING,
        "rows = np.flatnonzero(margins <= level)\n        shares",
        "rows = np.flatnonzero(margins <= 1.5 * level)\n        shares",
        MET,
    ),
    Mutant(
        "seeds drawn independently",
        SPLITTING,
        "np.concatenate([np.repeat(rows, every), rng.choice(rows, rest, replace=False)])",
        "rng.choice(rows, chains)",
        SEEDS,
    ),
    Mutant("a remainder that the first survivors have", SPLITTING, "rng.choice(rows, rest, replace=False)", "rows[:rest]", SEEDS),
    Mutant(
        "ρ and √(1 − ρ²) exchanged",
        SPLITTING,
        "math.sqrt(1.0 - step * step) * points.z + step * rng",
        "step * points.z + step * rng",
        MOVES,
    ),
    Mutant(
        "a key that is never drawn again", SPLITTING, "rng.random(len(points)) < REDRAWN", "rng.random(len(points)) < 0.0", MOVES
    ),
    Mutant(
        "a level at the cap",
        SPLITTING,
        "    if level < float(np.max(margins)):",
        "    if level <= float(np.max(margins)):",
        "stats/test_rare_splitting.py::test_an_atom_is_left_by_the_states_below",
    ),
    Mutant(
        "no end without a slope",
        SPLITTING,
        "if len(smaller) < FEWEST:",
        "if len(smaller) < 0:",
        "stats/test_rare_splitting.py::test_a_margin_without_a_slope_is_refused",
    ),
    Mutant("only no number counted as failure", POINTS, "return ~(margins > 0.0)", "return margins <= -np.inf", MET),
    Mutant(
        "no number counted as no failure",
        POINTS,
        "np.where(np.isnan(margins), -np.inf, margins)",
        "np.where(np.isnan(margins), np.inf, margins)",
        "stats/test_rare_splitting.py::test_no_number_is_a_failure",
    ),
    Mutant(
        "a last level that counts as failure",
        SPLITTING,
        "    fails = failed(margins)\n",
        "    fails = margins <= ladder.levels[-1]\n",
        "stats/test_rare_splitting.py::test_a_margin_that_stays_positive_ends_at_the_floor",
    ),
    Mutant(
        "replicates that share their numbers",
        SPLITTING,
        "np.random.default_rng([seed, 1, number])",
        "np.random.default_rng([seed, 1])",
        MET,
    ),
    Mutant(
        "levels that never disagree",
        CHECK,
        "self.counted.low <= self.split.high and",
        "self.counted.low <= 1.0 and",
        "stats/test_rare_splitting.py::test_ordinary_flights_refute_levels",
    ),
    Mutant(
        "evidence at half the limit",
        REPLICATES,
        "needed = -math.log1p(-confidence)",
        "needed = -0.5 * math.log1p(-confidence)",
        "stats/test_rare_replicates.py::test_the_bound_is_where_the_evidence_reaches_its_limit",
    ),
    Mutant(
        "bets that are not averaged",
        REPLICATES,
        "logsumexp(logs) - math.log(len(BETS))",
        "logsumexp(logs)",
        "stats/test_rare_replicates.py::test_the_evidence_is_the_mixture_of_products",
    ),
    Mutant(
        "an error without the number of replicates",
        REPLICATES,
        "np.std(p, ddof=1)) / math.sqrt(p.size)",
        "np.std(p, ddof=1))",
        "stats/test_rare_replicates.py::test_student_is_that_of_scipy",
    ),
    Mutant(
        "weights without the defensive part",
        IMPORTANCE,
        "np.exp(-np.logaddexp(math.log(DEFENSIVE), math.log1p(-DEFENSIVE) + ratio))",
        "np.exp(-math.log1p(-DEFENSIVE) - ratio)",
        "stats/test_rare_importance.py::test_weights_are_the_ratio_of_the_densities",
    ),
    Mutant(
        "points without the defensive part",
        IMPORTANCE,
        "tilted = rng.random(count) >= DEFENSIVE",
        "tilted = rng.random(count) >= 0.0",
        "stats/test_rare_importance.py::test_points_are_drawn_from_the_law_that_weighs_them",
    ),
    Mutant(
        "coordinates chosen by their means alone",
        IMPORTANCE,
        "(mean > limit) | (variance > limit)",
        "(mean > limit)",
        "stats/test_rare_importance.py::test_the_coordinates_that_matter_are_selected",
    ),
    Mutant(
        "a small effective sample that is not refused",
        IMPORTANCE,
        "if not self.effective >= LEAST_EFFECTIVE:",
        "if False:",
        REFUSED,
    ),
    Mutant(
        "a large weight that is not refused", IMPORTANCE, "if self.largest > LARGEST_SHARE:", "if self.largest > 0.5:", REFUSED
    ),
    Mutant("a heavy tail that is not refused", IMPORTANCE, "if self.shape > HEAVIEST:", "if self.shape > 1.0:", REFUSED),
    Mutant(
        "a mean over the failing alone",
        IMPORTANCE,
        "np.where(failed(margins), proposal.weights(points.z), 0.0)",
        "proposal.weights(points.z)[failed(margins)]",
        "stats/test_rare_importance.py::test_failing_weights_make_the_estimate",
    ),
    Mutant(
        "splitting that never refutes",
        IMPORTANCE,
        "None if ours.low <= theirs.high and theirs.low <= ours.high else",
        "None if ours.low <= 1.0 else",
        "stats/test_rare_importance.py::test_splitting_may_refute_it",
    ),
    Mutant(
        "parts without a price",
        MIXTURE,
        "+ parameters * math.log(size)",
        "+ 0.0 * math.log(size)",
        "stats/test_rare_importance.py::test_the_number_of_parts_is_found",
    ),
    Mutant(
        "variances without the dimension",
        MIXTURE,
        "(sizes * x.shape[1])",
        "sizes",
        "stats/test_rare_importance.py::test_a_fit_is_no_worse_than_the_law_it_came_from",
    ),
    Mutant(
        "a heavy prior of the tail",
        TAIL,
        "+ 10 * 0.5) / (n + 10)",
        "+ 1000 * 0.5) / (n + 1000)",
        "stats/test_rare_importance.py::test_the_shape_of_a_pareto_law_is_recovered",
    ),
    Mutant(
        "a lost flight without a time",
        SPACE,
        "-1.0 - (duration - np.minimum(time, duration)) / duration",
        "-1.0 - 0.0 * time",
        SIGNS,
    ),
    Mutant(
        "0 as a failure where it complies",
        SPACE,
        "np.where(complies, np.fmax(margin, tiny),",
        "np.where(complies, margin,",
        SIGNS,
    ),
    Mutant(
        "noise of sample 0 for every flight",
        SPACE,
        "np.zeros(len(z), dtype=np.int64) if keys is None else keys",
        "np.zeros(len(z), dtype=np.int64)",
        AGAIN,
    ),
    Mutant(
        "the noise of sample k for that of the row",
        "simulation/dispersions.py",
        "self.sampler.noise(samples, stream) if isinstance",
        "samples if isinstance",
        AGAIN,
    ),
    Mutant(
        "chunks of another search that are believed",
        "execution/rare/flights.py",
        "int(table[POINTS.name].iloc[0]) != _mark(points)",
        "False",
        "rare/test_rare_search.py::test_chunks_of_other_points_are_refused",
    ),
    Mutant(
        "each part for itself",
        "execution/rare/regions.py",
        "axis=2) < NEAR",
        "axis=2) < 0.5",
        "rare/test_rare_search.py::test_parts_near_each_other_are_one_region",
    ),
    Mutant(
        "FAIL at the whole risk twice",
        VERDICTS,
        "half = 1.0 - (1.0 - confidence) / 2.0",
        "half = confidence",
        "rare/test_rare_verdicts.py::test_the_bounds_are_those_that_are_stated",
    ),
    Mutant(
        "an estimate that passes unasked",
        VERDICTS,
        "if accepted and rare.high <= rare.allowed:",
        "if rare.high <= rare.allowed:",
        RESTS,
    ),
    Mutant("a refused estimate that decides", VERDICTS, "    if rare.refusals:", "    if False:", RESTS),
    Mutant(
        "the value for its upper bound",
        VERDICTS,
        "accepted and rare.high <= rare.allowed",
        "accepted and rare.value <= rare.allowed",
        RESTS,
    ),
    Mutant(
        "a search that the verdicts forget",
        "analysis/verdicts/folders.py",
        "conclude_all(counted.verdicts(), folder.path)",
        "counted.verdicts()",
        "rare/test_rare_search.py::test_verdicts_of_the_folder",
    ),
)
