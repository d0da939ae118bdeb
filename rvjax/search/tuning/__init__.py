"""Tuning: a search for better values of a campaign on common draws, and a verdict on fresh ones."""
