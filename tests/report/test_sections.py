"""What the sections make of a run: the order of the worst, fault severity, and that no metric is left out."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pandas as pd
import pytest

from rvjax.analysis.run_totals import HEAD, Totals, worst_first
from rvjax.campaign import Requirement, Spec, load
from rvjax.report.blocks import Code, Drawing, Number, Section, Table
from rvjax.report.metric_tables import quantiles
from rvjax.report.plotting import STYLE
from rvjax.report.run_view import OVERLAID, Run, open_run
from rvjax.report.sections import adaptation, captured, saturation, settling, verdicts, worst
from rvjax.report.sections import sections as all_sections
from rvjax.run_folder import Column, RunFolder
from tests.report.conftest import CAMPAIGN, CHANNELS


@pytest.fixture(scope="module")
def run(made: Callable[..., Path], tmp_path_factory: pytest.TempPathFactory) -> Run:
    return open_run(made(tmp_path_factory.mktemp("run") / "run", 200, (0.8, 0.1, 0.1)))


@pytest.fixture(scope="module")
def sections(run: Run) -> Iterator[list[Section]]:
    with matplotlib.rc_context(STYLE):
        yield all_sections(run)


def test_worst_samples_come_first(run: Run) -> None:
    """Mutations killed: a class out of order, a sign lost in one of the keys, NaN sorted last."""
    rows = run.head.iloc[worst_first(run.head, run.totals.columns)]
    assert list(rows["sample"][:10]) == list(run.totals.worst["sample"])
    assert sorted(rows["sample"]) == list(range(200))
    assert list(rows["outcome"]) == ["not_finite"] * 20 + ["not_settled"] * 20 + ["captured"] * 160
    assert rows["outcome_time_s"].iloc[:20].is_monotonic_increasing
    assert rows["metric.window_position_error_m"].iloc[20:40].is_monotonic_decreasing
    assert rows["metric.settling_time_s"].iloc[40:].is_monotonic_decreasing


def test_captions_over_time_say_how_many_instants_are_shown(run: Run, sections: list[Section]) -> None:
    """Kills: a caption that promises every step of a thinned history."""
    over_time = next(section for section in sections if section.key == "envelopes")
    captions = [block.caption for block in over_time.body if isinstance(block, Drawing)]
    traced = {len(trace) for trace in run.traces.values()}
    assert len(captions) == 2
    for caption in captions:
        assert f"samples at {run.envelopes['t_s'].nunique()} instants" in caption
        assert "Peaks between these instants are not shown" in caption
        assert all(f"kept trace, {rows} instants each" in caption for rows in traced)


def test_only_the_worst_flights_are_read(made: Callable[..., Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Five of those that are kept, the worst first. Kills: every kept flight read, one that is not among the worst drawn."""
    path = made(tmp_path / "run", 60)
    order = open_run(path).totals.worst["sample"].tolist()
    with RunFolder.open(path) as folder:
        trace = folder.trace(order[0])
        mild = next(sample for sample in range(60) if sample not in order)
        for sample in (mild, *order[3:]):
            folder.write_traces({sample: (trace, {name: Column(name, "", "made up") for name in trace})})
    read: list[int] = []
    monkeypatch.setattr(RunFolder, "trace", lambda _, sample: read.append(sample) or trace)
    assert list(open_run(path).traces) == read == order[:OVERLAID]


FAULTS = """[
  {use: effectiveness, onset_s: {uniform: [0, 400]}, remaining: {uniform: [0.2, 1]}, schedule: {probability: 0.6}},
  {use: effectiveness, name: fixed, channels: [fx, tz], onset_s: 250, remaining: 0.75, duration_s: {uniform: [10, 100]}},
  {use: effectiveness, name: late, onset_s: {uniform: [290, 310]}, remaining: 0.9, period_s: 7, duty: 0.5},
  {use: incipient, onset_s: {uniform: [0, 400]}, loss: {uniform: [0.1, 0.9]}, growth: 0.001, channels: [fx, fy]},
  {use: float, channels: [fx, ty], onset_s: {uniform: [0, 300]}, duration_s: {uniform: [2, 200]}},
  {use: stuck, channels: [fz], onset_s: {uniform: [200, 400]}, share: 0.3},
  {use: bias, onset_s: 0, share: 0.05}, {use: drift, onset_s: 0, growth: 0.001},
  {use: lag, onset_s: 0, time_constant_s: 1}, {use: delay, onset_s: 0, steps: 3}]"""


def test_severity_is_what_the_faults_have_taken_by_the_end(run: Run, tmp_path: Path) -> None:
    """1 − ∂u/∂h of the output at the end of each flight, sample by sample, from the equations of the faults.

    Kills: a sum instead of a product, a fault that begins after the end or has ended before it, a family that is left out
    (incipient, float, stuck), a fixed number that is left out because it is not drawn, channels that do not fail.
    """
    rng, n, end = np.random.default_rng(7), 400, 300.0
    campaign = tmp_path / "campaign.yaml"
    text = CAMPAIGN.format(name="x", description="x", samples=n, require="[]")
    campaign.write_text("\n".join(f"faults: {FAULTS}" if line.startswith("faults:") else line for line in text.splitlines()))
    spec = load(campaign)
    frame = {"sample": np.arange(n)}
    for path, low, high, channels in (
        ("effectiveness.onset_s", 0, 400, CHANNELS),
        ("effectiveness.remaining", 0.2, 1, CHANNELS),
        ("fixed.duration_s", 10, 100, ("fx", "tz")),
        ("late.onset_s", 290, 310, CHANNELS),
        ("incipient.onset_s", 0, 400, ("fx", "fy")),
        ("incipient.loss", 0.1, 0.9, ("fx", "fy")),
        ("float.onset_s", 0, 300, ("fx", "ty")),
        ("float.duration_s", 2, 200, ("fx", "ty")),
        ("stuck.onset_s", 200, 400, ("fz",)),
    ):
        for channel in channels:
            frame[f"draw.faults.{path}.{channel}"] = rng.uniform(low, high, n)
    for channel in CHANNELS:
        onset = frame[f"draw.faults.effectiveness.onset_s.{channel}"]
        frame[f"draw.faults.effectiveness.onset_s.{channel}"] = np.where(rng.uniform(size=n) < 0.6, onset, np.inf)
    head = pd.DataFrame(frame)

    def output(h: float, k: int, channel: str) -> float:
        def drawn(path: str) -> float:
            return float(frame[f"draw.faults.{path}.{channel}"][k])

        u = h
        if drawn("effectiveness.onset_s") < end:
            u = drawn("effectiveness.remaining") * u
        if channel in ("fx", "tz") and 250 + drawn("fixed.duration_s") >= end:
            u = 0.75 * u
        if drawn("late.onset_s") < end:
            u = 0.9 * u
        if channel in ("fx", "fy") and drawn("incipient.onset_s") < end:
            u = (1.0 - drawn("incipient.loss")) * u
        if channel in ("fx", "ty") and drawn("float.onset_s") + drawn("float.duration_s") >= end:
            u = 0.0
        if channel == "fz" and drawn("stuck.onset_s") < end:
            u = 0.3 * 4.0
        return u + 0.05 + min(0.001 * end, 1.0)

    changed = replace(run, spec=spec, head=head)
    for channel in CHANNELS:
        expected = [1.0 - (output(1.0, k, channel) - output(0.0, k, channel)) for k in range(n)]
        severity = changed.severity(channel)
        assert severity is not None
        assert severity == pytest.approx(expected, abs=1e-12)
    healthy = replace(run, spec=replace_faults(spec, ("bias", "drift", "lag", "delay")), head=head)
    assert healthy.severity("fx") is None
    assert replace(run, spec=replace_faults(spec, ("stuck",)), head=head).severity("fx") is None


def replace_faults(spec: Spec, uses: tuple[str, ...]) -> Spec:
    """The campaign with the faults of some kinds only."""
    return spec.model_copy(update={"faults": tuple(fault for fault in spec.faults if fault.use in uses)})


def requirement(**given: Any) -> Requirement:
    return Requirement(metric="settling_time_s", **given)


def test_captions_say_how_each_requirement_is_judged() -> None:
    """Kills: bounds of a fixed number claimed of an e-process, of SPRT or of a mean; 0 % at a limit of at_most or of a mean."""
    kinds = {
        "lower confidence bound": {"below": 9, "at_least": 0.9},
        "Method sequential": {"below": 9, "at_least": 0.9, "method": "sequential"},
        "Method sprt": {"below": 9, "at_least": 0.9, "method": "sprt", "expected": 0.99},
        "Mean:": {"below": 9, "mean": True},
    }
    for words, given in kinds.items():
        caption = verdicts._caption([requirement(**given)])
        assert [word for word in kinds if word in caption] == [words]
    assert settling._much(requirement(above=9, at_most=0.01)) == "at most 1\u00a0%"
    assert settling._much(requirement(below=9, mean=True)) == "mean"
    assert settling._much(requirement(above=9, quantile=0.9)) == "90\u00a0% quantile"
    assert settling._much(requirement(below=9, at_least=0.95)) == "at least 95\u00a0%"


def _with(run: Run, frame: pd.DataFrame) -> Run:
    """The run with other samples."""
    totals = Totals()
    totals.add(0, frame, run.totals.columns)
    return replace(run, totals=totals, head=totals.head)


def test_events_are_counted_at_their_edge(run: Run) -> None:
    """Kills: > for >= at the runaway, a late settling that counts as never, one flight's time for the first one's."""
    place = np.arange(200)
    chi, times = np.where(place < 30, 10.0, np.nextafter(10.0, 0.0)), np.where(place < 40, math.inf, 299.0)
    outcome = np.where(place < 5, "not_finite", "captured")
    values = {"metric.peak_chi": chi, "metric.settling_time_s": times, "outcome": outcome, "outcome_time_s": place + 3.0}
    changed = _with(run, run.head.assign(**values))
    numbers = {number.name: number for section in all_sections(changed) for number in section.numbers()}
    assert numbers["peak_chi.runaway.share"].estimate.value == 30 / 200
    assert numbers["settling_time_s.never.share"].estimate.value == 40 / 200
    assert "between 3.00 s and 7.00 s." in captured.section(changed).body[-1]
    for drift in (-1.0, 1.0):
        drifts = {"metric.peak_chi": 0.0, "metric.peak_estimate_drift": np.where(place == 7, drift, 0.0)}
        section = adaptation.section(_with(run, run.head.assign(**drifts)))
        assert section is not None
        assert "is adaptive but has no Nussbaum gain" in section.lead
    silent = _with(run, run.head.assign(**{"metric.peak_chi": 0.0, "metric.peak_estimate_drift": 0.0}))
    assert adaptation.section(silent) is None


def test_a_draw_stands_out_by_its_rank_among_the_first(run: Run) -> None:
    """Ties share their middle; a sample behind the first ones has the rank that its draw would have among them.

    Kills: the rank of the other end of ties, that of the row in the table of the worst, the head's draws for the worst ones'.
    """
    first = run.head.assign(**{name: 1.0 for name in run.head if name.startswith("draw.")})
    place = np.arange(200)
    first["draw.pursuer.mass_kg"] = np.where((place % 10 >= 3) & (place % 10 < 6), 80.0, 100.0)
    first.loc[[57, 199], "draw.pursuer.mass_kg"] = 120.0
    first["outcome"], first["outcome_time_s"] = np.where(place == 199, "not_finite", "captured"), 9.0
    first["metric.settling_time_s"] = np.where(place == 3, 900.0, 10.0)
    first["metric.saturation_duty.any"] = 0.125
    changed = _with(run, first)
    table, replay = worst.section(changed).body
    assert isinstance(table, Table)
    assert isinstance(replay, Table)
    assert table.rows[0][-1] == "pursuer.mass_kg = 120\u00a0kg (p99.5)"
    assert table.rows[1][-1] == "pursuer.mass_kg = 80.0\u00a0kg (p15.0)"
    assert table.rows[1][-2] == "12.5\u00a0%"
    assert [row[0] for row in replay.rows] == [row[0] for row in table.rows] == ["199", "3", *map(str, (0, 1, 2, 4, 5, 6, 7, 8))]
    assert [row[1] for row in replay.rows[:2]] == [Code(f"rvjax replay {run.folder} --sample {k}") for k in (199, 3)]
    last = first.assign(sample=place + 200, **{"draw.pursuer.mass_kg": 130.0, "outcome_time_s": 1.0, "outcome": "not_finite"})
    changed.totals.add(HEAD, last, changed.totals.columns)
    (table, _) = worst.section(changed).body
    assert isinstance(table, Table)
    assert table.rows[0][0] == "203"
    assert table.rows[0][-1] == "pursuer.mass_kg = 130\u00a0kg (p100.0)"
    assert table.caption.endswith("Of the first 200 samples.")


def test_the_spread_of_saturation_is_drawn_from_all_samples(run: Run) -> None:
    """Kills: a rank off by one or of another share, infinity drawn as the largest. Values 1 … 200 thousandths, 20 infinite."""
    values = np.where(np.arange(200) < 180, np.arange(1, 201) / 1000, math.inf)
    names = [name for name in run.head if name.startswith("metric.saturation_duty.")]
    figure = saturation.section(_with(run, run.head.assign(**dict.fromkeys(names, values)))).drawings[0].figure
    (axis,) = figure.axes
    bar, (far, largest) = axis.patches[0], axis.lines
    assert (bar.get_x(), axis.collections[0].get_segments()[0][0][0]) == pytest.approx((1.0, 10.0))
    assert bar.get_x() + bar.get_width() == pytest.approx(1.05 * 18.0)
    assert np.isinf(far.get_xdata()).all()
    assert largest.get_xdata() == pytest.approx([18.0] * 7)


def test_quantiles_look_at_the_bad_side(run: Run) -> None:
    """Mutation killed: the upper quantile of a metric where higher is better. 20 of 200 are not finite: -inf there."""
    (row,) = quantiles(run, "", ["closest_approach_m"]).rows
    values = [cell.estimate.value for cell in row if isinstance(cell, Number)]
    assert values == sorted(values, reverse=True)
    assert values[1:] == [-np.inf] * 3
    (row,) = quantiles(run, "", ["settling_time_s"]).rows
    values = [cell.estimate.value for cell in row if isinstance(cell, Number)]
    assert values == sorted(values)
    assert values[1:] == [np.inf] * 3


def test_every_metric_is_shown(run: Run, sections: list[Section]) -> None:
    """Mutation killed: a metric that no section shows."""
    shown = {number.name for section in sections for number in section.numbers()}
    hidden = [name for name in run.metrics(".*") if not any(key.startswith(f"{name}.") for key in shown)]
    assert hidden == []


def test_sections_are_well_formed(sections: list[Section]) -> None:
    """Keys, names of numbers and of figures are unique and plain; every row fits its head; every text is a sentence."""
    keys = [section.key for section in sections]
    figures = [drawing.name for section in sections for drawing in section.drawings]
    numbers = [number for section in sections for number in section.numbers()]
    assert len(set(keys)) == len(keys)
    assert len(set(figures)) == len(figures)
    assert all(re.fullmatch(r"[a-z]+(-[a-z]+)*", name) for name in keys + figures)
    values: dict[str, Number] = {}
    assert all(values.setdefault(number.name, number) == number for number in numbers)
    for section in sections:
        assert section.lead.endswith(".")
        for block in section.body:
            if isinstance(block, Table):
                assert block.caption.endswith(".")
                assert all(len(row) == len(block.head) for row in block.rows)
