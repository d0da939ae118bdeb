"""The speed of this machine: rvjax against yardsticks, in the same run, on the same closed loop and the same samples.

Every way of flying has its process, because compiler settings are made once for a process. The prepared processes fly in turn,
round after round, so a ratio compares flights of the same moment. Each hands over its results, and all results are compared.
"""

from __future__ import annotations

from rvjax.execution.bench.measurement import Bench, measure

__all__ = ["Bench", "measure"]
