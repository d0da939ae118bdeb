"""Simulation: a campaign becomes a problem, draws, a closed loop and flights. The only package that compiles."""
