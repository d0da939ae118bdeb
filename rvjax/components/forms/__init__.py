"""Forms of the user's components: what a Python file beside a campaign declares. Each becomes a `Component` of its family."""
