"""Tables and traces of a run folder as files for other tools. Units and descriptions travel with the numbers. No JAX."""
