"""The job in Basilisk's Monte Carlo: two spacecraft in inertial space, point-mass gravity, RK4, the law as a module in Python.

Given draws are the initial conditions of its `runInitialConditions`. Its retention of data waits a second in each run, so the end
of a flight is written by the execution function instead.
"""

from __future__ import annotations

import json
import tempfile
import time
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from Basilisk.architecture import messaging, sysModel
from Basilisk.simulation import extForceTorque, spacecraft, svIntegrators
from Basilisk.utilities import SimulationBaseClass, simIncludeGravBody
from Basilisk.utilities.MonteCarlo.Controller import Controller

from benchmarks.peers import job

NANO = 1e-9


class Law(sysModel.SysModel):
    """PD in the Hill frame."""

    def __init__(self, bodies: list[Any]) -> None:
        super().__init__()
        self.bodies, self.force = bodies, messaging.CmdForceBodyMsg()

    def UpdateState(self, now: int) -> None:
        """The command until the next step."""
        command = messaging.CmdForceBodyMsgPayload()
        command.forceRequestBody = job.law(*relative(self.bodies)).tolist()
        self.force.write(command, now, self.moduleID)


def simulation() -> Any:
    """Target and pursuer. Both bodies turn with the orbit, so their axes are those of the Hill frame."""
    simulation: Any = SimulationBaseClass.SimBaseClass()
    step = round(job.STEP / NANO)
    simulation.CreateNewProcess("process").addTask(simulation.CreateNewTask("task", step))
    gravity = simIncludeGravBody.gravBodyFactory()
    earth = gravity.createEarth()
    earth.isCentralBody, earth.mu = True, job.MU
    simulation.kept, simulation.bodies = [gravity], []
    for _ in range(2):
        body = spacecraft.Spacecraft()
        body.hub.IHubPntBc_B = np.diag([20.0, 20.0, 20.0]).tolist()
        body.hub.r_CN_NInit, body.hub.v_CN_NInit = [job.AXIS, 0.0, 0.0], [0.0, job.RATE * job.AXIS, 0.0]
        body.hub.omega_BN_BInit = [0.0, 0.0, job.RATE]
        body.gravField.gravBodies = spacecraft.GravBodyVector(list(gravity.gravBodies.values()))
        integrator = svIntegrators.svIntegratorRK4(body)
        body.setIntegrator(integrator)
        simulation.AddModelToTask("task", body)
        simulation.kept.append(integrator)
        simulation.bodies.append(body)
    simulation.pursuer = simulation.bodies[1]
    law, push = Law(simulation.bodies), extForceTorque.ExtForceTorque()
    push.cmdForceBodyInMsg.subscribeTo(law.force)
    simulation.pursuer.addDynamicEffector(push)
    simulation.AddModelToTask("task", law)
    simulation.AddModelToTask("task", push)
    simulation.kept += [law, push]
    return simulation


def relative(bodies: list[Any]) -> tuple[job.Array, job.Array]:
    """Position and velocity relative to the hold point, in the Hill frame."""
    target, pursuer = (body.scStateOutMsg.read() for body in bodies)
    r, v = np.array(target.r_BN_N), np.array(target.v_BN_N)
    out, normal = r / np.linalg.norm(r), np.cross(r, v) / np.linalg.norm(np.cross(r, v))
    axes = np.stack([out, np.cross(normal, out), normal])
    position = axes @ (np.array(pursuer.r_BN_N) - r)
    turning = np.array([0.0, 0.0, np.linalg.norm(np.cross(r, v)) / (r @ r)])
    return position - job.HOLD, axes @ (np.array(pursuer.v_BN_N) - v) - np.cross(turning, position)


def execute(simulation: Any) -> None:
    """A flight, whose end goes into a file."""
    simulation.InitializeSimulation()
    simulation.ConfigureStopTime(round(job.STEP * job.STEPS / NANO))
    simulation.ExecuteSimulation()
    Path(simulation.end).write_text(repr(float(np.linalg.norm(relative(simulation.bodies)[0]))))


def fly(draws: job.Array, cores: int) -> job.Result:
    """A process for each core."""
    turning = np.array([0.0, 0.0, job.RATE])
    with tempfile.TemporaryDirectory() as place:
        for k, (mass, *drawn) in enumerate(draws):
            position = np.array(drawn[:3]) + job.HOLD + np.array([job.AXIS, 0.0, 0.0])
            velocity = np.array(drawn[3:]) + np.cross(turning, position)
            values = {
                "pursuer.hub.mHub": repr(float(mass)),
                "pursuer.hub.r_CN_NInit": str(position.tolist()),
                "pursuer.hub.v_CN_NInit": str(velocity.tolist()),
                "end": f"{place}/end{k}",
            }
            Path(place, f"run{k}.json").write_text(json.dumps(values))
        batch = Controller()
        batch.setSimulationFunction(simulation)
        batch.setExecutionFunction(execute)
        batch.setICDir(place)
        batch.setICRunFlag(True)
        batch.setThreadCount(cores)
        began = time.perf_counter()
        failed = batch.runInitialConditions(list(range(len(draws))))
        fly_s = time.perf_counter() - began
        if failed:
            raise RuntimeError(f"{len(failed)} flights failed")
        ends = [float(Path(place, f"end{k}").read_text()) for k in range(len(draws))]
    return job.Result(ends, version("bsk"), fly_s=fly_s)


if __name__ == "__main__":
    job.main(fly)
