"""The job in OpenTURNS: the flights of `with_numpy` as its Python function, the share by its Monte Carlo."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import openturns

from benchmarks.peers import job
from benchmarks.peers.with_numpy import distances


def fly(draws: job.Array, cores: int) -> job.Result:
    """On the given draws; its interval is that of a normal distribution."""
    ends = np.zeros(len(draws))

    def margins(points: Any) -> Any:
        ends[:] = distances(np.asarray(points))
        return (ends - job.TUBE)[:, None]

    function = openturns.PythonFunction(len(job.COLUMNS), 1, func_sample=margins)
    mass, box, speed = openturns.Uniform(80.0, 120.0), openturns.Uniform(-50.0, 50.0), openturns.Uniform(-0.1, 0.1)
    inputs = openturns.RandomVector(openturns.JointDistribution([mass, box, box, box, speed, speed, speed]))
    event = openturns.ThresholdEvent(openturns.CompositeRandomVector(function, inputs), openturns.Less(), 0.0)
    algorithm = openturns.ProbabilitySimulationAlgorithm(event, openturns.FixedExperiment(openturns.Sample(draws)))
    algorithm.setBlockSize(len(draws))
    algorithm.setMaximumOuterSampling(1)
    began = time.perf_counter()
    algorithm.run()
    fly_s = time.perf_counter() - began
    share = algorithm.getResult().getProbabilityDistribution()
    low, high = (share.computeQuantile(level)[0] for level in (0.025, 0.975))
    return job.Result(ends.tolist(), openturns.__version__, (low, high), fly_s)


if __name__ == "__main__":
    job.main(fly)
