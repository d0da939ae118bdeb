"""Rare failures: probabilities of 10⁻⁴ and less over standard normal space, with far fewer flights than counting takes.

Multilevel splitting (`splitting`), importance sampling that is learned once and then frozen (`importance`), intervals and a
proved lower bound from independent unbiased replicates (`replicates`), and what ordinary flights say about the levels
(`level_check`).

The estimates are conditional on every failure region of weight having been reached: docs/verdicts.md, "What n flights can prove".
"""
