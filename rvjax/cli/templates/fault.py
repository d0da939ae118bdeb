"""Dead band: while the fault acts, a channel gives nothing for commands below a share of its limit."""

import jax.numpy as jnp

from rvjax.components import Fault, FaultParameters, channels


class Parameters(FaultParameters):
    """Width of the dead band. Onset, duration and channels are those of every fault."""

    width: float = channels("1", default=0.1, at_least=0.0, below=1.0, doc="width of the dead band as a share of the limit")


def failed(wrench, since, numbers):
    """What the channels give while the fault acts."""
    return jnp.where(jnp.abs(wrench) < numbers.width * numbers.limit, 0.0, wrench)


FAULT = Fault(Parameters, failed)
