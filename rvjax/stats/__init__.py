"""Statistics of Monte-Carlo samples: pure functions of NumPy and SciPy.

Exact at the stated confidence for every number of samples, and so used for verdicts: Clopper-Pearson bounds and their verdicts
(`binomial`), e-processes and the ratio test with Ville's bounds (`sequential`), order statistics and the band (`quantiles`),
empirical Bernstein (`means`), McNemar's exact test and its e-process (`paired`), Holm (`multiplicity`).

Approximate, for plots and effects: Wilson, Jeffreys, bootstraps, Newcombe, Tango, mid-p, shifts of quantiles
(`quantile_shifts`), sensitivity from given data (`sensitivity`, `rank_dependence`) and from flights of its own (`pick_freeze`),
weights (`reweighting`, whose thinning is exact). Their `Estimate.method` or docstring says so.

`walk` gives the exact errors of any rule that counts failures.
"""

from rvjax.stats.binomial import (
    Chances,
    Ends,
    Estimate,
    clopper_pearson,
    clopper_pearson_lower,
    clopper_pearson_upper,
    coverage,
    fixed_boundary,
    jeffreys,
    verdict_chances,
    wilks_smallest_n,
    wilson,
    worst_coverage,
)
from rvjax.stats.boundary_crossing import Boundary, Walk, decisions, schedule, walk
from rvjax.stats.means import (
    RESAMPLES,
    bernstein_bounds,
    bootstrap_interval,
    empirical_bernstein,
    empirical_bernstein_lower,
    empirical_bernstein_upper,
    mean_interval,
)
from rvjax.stats.multiplicity import holm
from rvjax.stats.paired import Pairs, log_e_paired, mcnemar, newcombe, noninferiority, pairs_of, tango
from rvjax.stats.paired_exact import inferiority_exact, noninferiority_exact
from rvjax.stats.quantile_shifts import quantile_shift
from rvjax.stats.quantiles import (
    Interval,
    dkw_band,
    lower_tolerance_bound,
    quantile_interval,
    quantile_rank,
    tolerance_interval,
    upper_tolerance_bound,
)
from rvjax.stats.sensitivity import Explained, explained
from rvjax.stats.sequential import e_boundary, log_e_fail, log_e_pass, log_ratio, sprt_boundary

__all__ = [
    "RESAMPLES",
    "Boundary",
    "Chances",
    "Ends",
    "Estimate",
    "Explained",
    "Interval",
    "Pairs",
    "Walk",
    "bernstein_bounds",
    "bootstrap_interval",
    "clopper_pearson",
    "clopper_pearson_lower",
    "clopper_pearson_upper",
    "coverage",
    "decisions",
    "dkw_band",
    "e_boundary",
    "empirical_bernstein",
    "empirical_bernstein_lower",
    "empirical_bernstein_upper",
    "explained",
    "fixed_boundary",
    "holm",
    "inferiority_exact",
    "jeffreys",
    "log_e_fail",
    "log_e_paired",
    "log_e_pass",
    "log_ratio",
    "lower_tolerance_bound",
    "mcnemar",
    "mean_interval",
    "newcombe",
    "noninferiority",
    "noninferiority_exact",
    "pairs_of",
    "quantile_interval",
    "quantile_rank",
    "quantile_shift",
    "schedule",
    "sprt_boundary",
    "tango",
    "tolerance_interval",
    "upper_tolerance_bound",
    "verdict_chances",
    "walk",
    "wilks_smallest_n",
    "wilson",
    "worst_coverage",
]
