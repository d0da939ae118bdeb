"""Analysis: what a run folder says. Verdicts, totals, comparisons, baselines, sample sizes. NumPy and SciPy only."""
