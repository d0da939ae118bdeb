"""Noise of the measured position that grows with the distance: standard deviation s |ρ|, new in every step."""

import jax.numpy as jnp

from rvjax.components import NavigationError, Parameters, scalar


class Noise(Parameters):
    """Size of the noise."""

    share: float = scalar("1", default=0.005, at_least=0.0, doc="standard deviation s as a share of the distance")


def see(motion, xi, numbers):
    """The measured motion; xi: three standard normal numbers."""
    return motion._replace(rho=motion.rho + numbers.share * jnp.linalg.norm(motion.rho) * xi)


NAVIGATION = NavigationError(Noise, see, noise=3)
