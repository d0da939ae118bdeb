"""Searches: how the next candidates of a tuning are chosen, one file each."""

MEMBERS: dict[str, str] = {}
"""Name in a campaign → module; of those that need an extra, the module says which."""
