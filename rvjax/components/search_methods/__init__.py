"""Search methods: how a tuning chooses the next candidates. One file per member."""

MEMBERS = {
    "grid": "rvjax.components.search_methods.grid",
    "random": "rvjax.components.search_methods.random",
    "sobol": "rvjax.components.search_methods.sobol",
    "cma-es": "rvjax.components.search_methods.cma_es",
    "tpe": "rvjax.components.search_methods.tpe",
    "nsga": "rvjax.components.search_methods.nsga",
    "gradient": "rvjax.components.search_methods.gradient",
}
"""Name in a campaign → module. A module that needs an optional package names it."""
