"""Mutants of the mean wrench in traces."""

from __future__ import annotations

from tests.mutants.mutant import Mutant

LOOP, MEAN, BATCH = "simulation/closed_loop.py", "simulation/mean_wrench.py", "simulation/batch.py"
TABLES, ENGINE = "simulation/tables.py", "simulation/engines/llvm/engine.py"
REPEATED = "physics/test_mean_wrench.py::test_the_mean_wrench_repeats_a_flight"
WEIGHTS = "physics/test_mean_wrench.py::test_the_weights_are_those_of_the_step"
THINNED = "physics/test_mean_wrench.py::test_a_thinned_row_has_the_mean_up_to_the_next"
INTERPRETED = "engines/test_mean_wrench.py::test_it_is_that_of_the_interpreter"
XLA = "engines/test_mean_wrench.py::test_xla_agrees"

MUTANTS = (
    Mutant("a total moment about the reference point", LOOP, "total=wrench)", "total=wrench + Channels(applied.force * 0.0, applied.torque - moment))", REPEATED),
    Mutant("a total without the disturbances", LOOP, "total=wrench)", "total=wrench - disturbance)", REPEATED),
    Mutant("a total without the effects", LOOP, "total=wrench)", "total=Channels(applied.force, moment) + disturbance)", REPEATED),
    Mutant("stages that count alike", "simulation/rk4.py", "(h / 6.0) * (p + 2.0 * (q + r) + s)", "(h / 4.0) * (p + q + r + s)", WEIGHTS),
    Mutant("the wrench at the start of the step for its mean", MEAN, "accumulators=carry.accumulators), means)", "accumulators=carry.accumulators), summed.means + flight.step_start(evaluate, drawn, carry, k)[1].total)", WEIGHTS),
    Mutant("the mean of the step at the row alone", BATCH, "flying.mean_wrench(first, last)", "flying.mean_wrench(first, first + 1)", THINNED),
    Mutant("the mean of the row before", TABLES, "np.stack(each), *means, none)", "np.stack(each), none, *means)", REPEATED),
    Mutant("a mean where no trace is kept", BATCH, "                if len(chosen):\n                    means", "                if True:\n                    means", "physics/test_mean_wrench.py::test_without_a_trace_nothing_is_computed"),
    Mutant("a sum for a mean", ENGINE, "summed[:, carry:] / (last - first)", "summed[:, carry:]", THINNED),
    Mutant("a divisor of XLA's that is always 1", MEAN, "summed.means * (1.0 / (last - first))", "summed.means * 1.0", XLA),
    Mutant("means of the first samples for the traced", BATCH, "means.append(traced(flying.mean_wrench(first, last)))", "means.append(jax.tree.map(lambda x: np.asarray(x)[: len(chosen)], flying.mean_wrench(first, last)))", XLA),
    Mutant("a chunk that its means move on", ENGINE, "        summed[:, :carry] = self._carry\n        self._flight.function(\"mean_wrench\")(self._groups, first, last, self._numbers, summed, summed)\n", "        summed[:, :carry] = self._carry\n        self._flight.function(\"mean_wrench\")(self._groups, first, last, self._numbers, summed, summed)\n        self._carry[:] = summed[:, :carry]\n", INTERPRETED),
    Mutant("a margin on a mean is only unknown", "simulation/margin_checks.py", "if name in MEAN_WRENCH:", "if not name:", "campaign/test_campaign.py::test_bad_file"),
)  # fmt: skip
