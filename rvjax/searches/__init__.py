"""Searches: how the next candidates of a tuning are chosen, one file each."""

MEMBERS = {
    "grid": "rvjax.searches.grid",
    "random": "rvjax.searches.random",
    "sobol": "rvjax.searches.sobol",
    "cma-es": "rvjax.searches.cma_es",
    "tpe": "rvjax.searches.tpe",
    "nsga": "rvjax.searches.nsga",
    "gradient": "rvjax.searches.gradient",
}
"""Name in a campaign → module; of those that need an extra, the module says which."""
