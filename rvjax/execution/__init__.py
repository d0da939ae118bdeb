"""Execution: a campaign becomes a run folder. Run, replay, audit, identity, executors and the benchmark."""
