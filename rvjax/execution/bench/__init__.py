"""The speed of this machine: the product against yardsticks, in one run, on the same closed loop and the same samples.

Every way of flying is a process of its own, because compiler settings are made once a process. The processes stand ready and fly
in turn, round after round, so that a ratio is between flights of the same moment; each waits for its results and hands them over,
and all of them are compared.
"""

from __future__ import annotations

from rvjax.execution.bench.measurement import Bench, measure

__all__ = ["Bench", "measure"]
