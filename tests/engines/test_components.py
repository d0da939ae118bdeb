"""Every component of this package can be flown with the engine `llvm`, which is taken for granted when it is chosen."""

from __future__ import annotations

import pytest

from rvjax.components.registry import choosable
from rvjax.execution.component_check import _model
from rvjax.simulation import user_checks
from rvjax.simulation.engines.llvm.from_jaxpr import scalarised


@pytest.mark.parametrize("family", sorted(user_checks._TRACED))
def test_llvm_has_a_rule_for_all_that_a_component_does(family: str) -> None:
    """With every choice of its options. Kills: a component with an operation that the engine does not know: its flights would end
    in a traceback."""
    for member in choosable(family).values():
        plain = _model(member.parameters, None)
        for model in (plain, *user_checks._otherwise(plain)):
            function = user_checks.traced(family, member.build(model))
            given = user_checks.numbers(user_checks.own_quantities(model), member.noisy)
            program, _ = scalarised(function, given, user_checks.ARGUMENTS, step=False)
            assert program.body.results
