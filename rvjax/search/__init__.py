"""Searches above the run: tuning gains, the worst draws, rare failures. They only call the run."""
