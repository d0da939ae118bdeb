"""Components of a user in every command: explain, list, tune, worst, Dask; broken packages of others."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from rvjax.components import registry
from rvjax.components.manual import campaign_schema
from rvjax.components.registry import choosable, component
from rvjax.execution.component_check import check
from rvjax.execution.run import run
from rvjax.run_folder import RunFolder
from rvjax.search.tuning.tune import tune
from rvjax.search.worst_case import find_worst_case
from rvjax.simulation import problem
from rvjax.simulation.problem import load
from rvjax.testing import check_component
from tests.program import Run
from tests.user_code.mistakes import LAW
from tests.user_code.test_user_mistakes import project

pytestmark = pytest.mark.usefixtures("bare")
REQUIRE = "require: [{metric: delta_v_m_s, below: 100, at_least: 0.5, confidence: 0.5}]\n"
TUNE = """tune:
  parameters: {controller.gains.kp: {linear: [0.005, 0.02]}}
  objective: [{metric: delta_v_m_s, mean: true}]
  method: {use: random}
  budget: {candidates: 4}
  confirm: {samples: 8}
"""


def test_the_manual_page_of_a_file(tmp_path: Path, rvjax: Run) -> None:
    """Docstring, gains with unit, default and range. Kills: a page of the module alone."""
    project(tmp_path, LAW)
    code, out, _ = rvjax("explain", tmp_path / "law.py")
    assert code == 0
    assert "PD on position and attitude." in out
    assert "gains.kp" in out
    assert "1/s²" in out


def test_a_broken_package_breaks_nothing_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, rvjax: Run) -> None:
    """A metric and a controller of packages that cannot be imported: they are named by `list`, and other campaigns fly. Kills:
    one import for all."""
    (tmp_path / "broken_here.py").write_text("import nowhere_at_all\n")
    monkeypatch.syspath_prepend(tmp_path)
    whole = registry.members
    extra = {"metrics": {"mine": "broken_here:METRIC"}, "controllers": {"theirs": "broken_here:LAW"}}
    for module in (registry, problem):
        monkeypatch.setattr(module, "members", lambda family: {**whole(family), **extra.get(family, {})})
    code, _, err = rvjax("list")
    assert code == 0
    assert "controllers.theirs cannot be used: the installed module broken_here cannot be imported" in err
    assert "metrics.mine cannot be used" in err
    campaign = project(tmp_path, LAW)
    assert rvjax("validate", campaign)[0] == 0
    code, _, err = rvjax("validate", campaign, "--set", "controller={use: theirs}")
    assert code == 2
    assert "No module named 'nowhere_at_all'" in err
    assert "Traceback" not in err


@pytest.mark.parametrize("family", ["controllers", "actuators", "allocations", "effects"])
def test_shipped_components_pass_their_check(family: str) -> None:
    """Kills: a check that users must pass and the shipped components do not."""
    for name, member in choosable(family).items():
        assert check(name, family, member).operations > 0


def test_the_check_of_a_file_has_its_numbers(tmp_path: Path) -> None:
    """As `rvjax.testing` gives them. Kills: the check of another object of the file, a cost of zero."""
    project(tmp_path, LAW)
    (found,) = check_component(tmp_path / "law.py")
    assert (found.family, found.parameters, found.signals) == ("controllers", ("kp", "kd"), ("integral",))
    assert 0.1 < found.cost < 1.0
    assert component("controllers", "pd-plus").parameters().gains.k_rho.medians == (0.0025,)


def test_tune_and_worst_fly_a_file(tmp_path: Path) -> None:
    """A gain without a value in the campaign is searched from its default; the folder keeps the code. Kills: a search that needs
    the name of a shipped component."""
    campaign = project(tmp_path, LAW)
    campaign.write_text(campaign.read_text() + REQUIRE + TUNE)
    folder, record = tune(campaign, tmp_path / "tuned", progress=False)
    assert record.rows
    assert (folder / "inputs" / "law.py").exists() or (folder / "law.py").exists()
    load(folder / "best.yaml")
    found = find_worst_case(campaign, 1, flights=500)
    assert found.flights > 0


def test_workers_get_the_code(tmp_path: Path) -> None:
    """Two Dask workers fly the file and its helper, which are not where the workers run. Kills: an order without the code."""
    from rvjax.execution.executors.dask_client import workers

    (tmp_path / "gains_of.py").write_text("FACTOR = 100.0\n")
    law = LAW.replace("import numpy as np\n", "from gains_of import FACTOR\n").replace("-100.0 *", "-FACTOR *")
    campaign = project(tmp_path, law)
    here = run(campaign, tmp_path / "here", ["samples=832"], progress=False)
    there = run(campaign, tmp_path / "there", ["samples=832"], progress=False, executor=workers(2, lambda text: None))
    first, second = (RunFolder.open(folder) for folder in (here, there))
    assert first.identity == second.identity
    assert first.samples().frame.equals(second.samples().frame)


@pytest.mark.parametrize(
    ("section", "use", "accepted"),
    [
        ("controller", "./my_law.py", True),
        ("controller", "laws/mine.py:SlidingPid", True),
        ("controller", "pd-plus", True),
        ("controller", "pd_plus", False),
        ("controller", "./my_law.txt", False),
        ("sampler", "./mine.py", True),
    ],
)
def test_editors_accept_a_file(section: str, use: str, accepted: bool) -> None:
    """The JSON Schema by its own rules: exactly one branch of `oneOf` has a constant or a pattern that fits. Kills: a red line
    under every component of a user."""
    branches = campaign_schema()["properties"][section]["oneOf"]
    uses = [branch["properties"]["use"] for branch in branches]
    fits = [rule.get("const") == use or ("pattern" in rule and re.search(rule["pattern"], use) is not None) for rule in uses]
    assert sum(fits) == accepted


SATURATION = """
import jax.numpy as jnp
from rvjax.components import Saturation


def limited(command, upper, lower):
    return jnp.where(command >= 0.0, upper * jnp.tanh(command / upper), lower * jnp.tanh(command / lower))


SATURATION = Saturation(limited)
"""


def test_a_saturation_of_a_user_flies_like_ours(tmp_path: Path) -> None:
    """The smooth tanh written again: the same flights to rounding; its slope is its derivative. Kills: limits that are swapped, a
    slope of 1."""
    (tmp_path / "soft.py").write_text(SATURATION)
    campaign = project(tmp_path, LAW)
    campaign.write_text(campaign.read_text().replace("upper: [4, 4, 4,", "upper: [1, 1, 1,"))
    tables = [
        RunFolder.open(run(campaign, tmp_path / name, [f"saturation={{use: {use}}}"], progress=False)).samples().frame
        for name, use in (("mine", "./soft.py"), ("ours", "smooth-tanh"))
    ]
    for name in (name for name in tables[0].columns if name.startswith("metric.")):
        np.testing.assert_allclose(tables[0][name], tables[1][name], rtol=1e-9, atol=1e-9, err_msg=name)
    mine, ours = load(campaign, ["saturation={use: ./soft.py}"]).loop.saturation, load(campaign).loop.saturation
    for command in (-2.0, -0.1, 0.3, 5.0):
        np.testing.assert_allclose(mine(command, 1.0, 0.6), ours(command, 1.0, 0.6), rtol=1e-6)


SAMPLER = """
from dataclasses import dataclass
import numpy as np
from rvjax.campaign import Model
from rvjax.components.samplers.interface import Sampling, Scheme


class Parameters(Model):
    pass


@dataclass(frozen=True)
class Middle:
    samples: object

    def uniforms(self, name, count):
        return np.full((len(self.samples), count), 0.25 + 0.5 * (self.samples[:, None] % 2))

    def prescribed(self, name):
        return None


class Alternating:
    def at(self, samples):
        return Middle(samples)


SAMPLER = Sampling(Parameters, lambda parameters: Scheme(lambda setting: Alternating()))
"""
METHOD = """
import numpy as np
from rvjax.campaign import Model
from rvjax.components.search_methods.interface import Method
from rvjax.components.search_methods.point_sets import propose


class Parameters(Model):
    pass


def search(task, evaluate):
    propose(task, evaluate, lambda count: np.linspace(0.1, 0.9, count)[:, None], None)


METHOD = Method(Parameters, lambda parameters: search)
"""


def test_a_sampler_and_a_search_method_of_a_user(tmp_path: Path, rvjax: Run) -> None:
    """The draws are those of the sampler, and nothing is judged on them; the search proposes what the method says. Kills: a
    verdict on samples whose independence nobody has shown."""
    (tmp_path / "quartiles.py").write_text(SAMPLER)
    (tmp_path / "line.py").write_text(METHOD)
    campaign = project(tmp_path, LAW)
    folder = run(campaign, tmp_path / "run", ["sampler={use: ./quartiles.py}"], progress=False)
    np.testing.assert_allclose(RunFolder.open(folder).samples().frame["draw.pursuer.mass_kg"], [95.0, 105.0] * 4)
    campaign.write_text(campaign.read_text() + REQUIRE + TUNE)
    code, _, err = rvjax("validate", campaign, "--set", "sampler={use: ./quartiles.py}")
    assert code == 2
    assert "which are not independent" in err
    _, record = tune(campaign, tmp_path / "tuned", ["tune.method={use: ./line.py}"], progress=False)
    values = sorted(row.values["controller.gains.kp"] for row in record.rows)
    np.testing.assert_allclose(values[:1] + values[-1:], [0.0065, 0.0185])
