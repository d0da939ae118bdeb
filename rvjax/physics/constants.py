"""Constants of nature, without JAX."""

MU_EARTH = 3.986004418e14
"""Gravitational parameter of the Earth, m³/s² (IERS Conventions 2010, table 1.1, TT-compatible)."""
