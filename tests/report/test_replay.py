"""The replay and the linked plots in a real browser: one Chromium, one page for all tests, a made-up run of 300 samples."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray
from scipy import stats
from scipy.spatial.transform import Rotation

from rvjax.report import build
from rvjax.report.interactive.data_blocks import MOST
from tests.report.browser import Browser, required
from tests.report.replay_folder import PORT, add_traces

KEPT = [0, 4, 17]
RESET = """(async () => {
  scrollTo({ top: 0, behavior: "instant" });
  rvjax.linked.samples.clear();
  Object.assign(rvjax.shown, { speed: 8, frame: "port" });
  Object.assign(rvjax.shown.camera, { name: "free", yaw: -0.9, pitch: 0.35, zoom: 1, blend: null });
  await rvjax.shown.open(0);
})()"""
Make = Callable[..., Path]
Within = Callable[[], AbstractContextManager[None]]


@pytest.fixture(scope="module")
def folder(made: Make, tmp_path_factory: pytest.TempPathFactory, undrawn: Within) -> Path:
    path = made(tmp_path_factory.mktemp("replay") / "it's a run", 300, (0.9, 0.06, 0.04))
    add_traces(path, KEPT)
    with undrawn():
        build(path)
    return path


@pytest.fixture(scope="module")
def table(folder: Path) -> pd.DataFrame:
    return pd.concat([pd.read_parquet(path) for path in sorted((folder / "samples").glob("*.parquet"))], ignore_index=True)


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    required()
    with Browser(tmp_path_factory.mktemp("profile")) as opened:
        yield opened


@pytest.fixture
def page(browser: Browser, folder: Path) -> Iterator[Browser]:
    """The page, at the first flight and its start. Whatever a test does, the page must log nothing and ask for nothing."""
    browser.media()
    browser.size(800, 600)
    if browser.run("location.protocol") == "file:":
        browser.run(RESET)
    else:
        browser.open(folder / "report.html")
    yield browser
    assert browser.console == []
    assert [url for url in browser.requests if not url.startswith((folder / "report.html").as_uri())] == []


def columns(frame: pd.DataFrame, form: str) -> NDArray[np.float64]:
    """(rows, 3) of a trace, to be written to, as SciPy wants it."""
    return np.array([frame[form.format(axis)] for axis in "xyz"]).T.copy()


def settled(page: Browser, t: float) -> None:
    """Until the picture of an instant is drawn."""
    page.wait(f"Math.abs(rvjax.shown.seen.t - {t}) < 1e-6")


def test_the_picture_moves_along_the_time_line(page: Browser) -> None:
    """By WebGL2. Kills: a scene that is drawn once, or not at all; a frame or a camera without effect."""
    assert page.run("rvjax.shown.renderer instanceof rvjax.webgl.Renderer")
    shots = []
    for t in (0, 60, 61, 200):
        page.run(f"rvjax.shown.to({t})")
        settled(page, t)
        shots.append(page.picture("#stage"))
    page.run("rvjax.shown.inFrame('lvlh'); rvjax.shown.draw()")
    shots.append(page.picture("#stage"))
    page.run("rvjax.shown.look('hbar'); rvjax.shown.camera.blend = null; rvjax.shown.draw()")
    shots.append(page.picture("#stage"))
    assert len(set(shots)) == len(shots)
    assert min(map(len, shots)) > 5_000


def test_scrubbing_moves_scene_signals_and_table_together(page: Browser) -> None:
    """Kills: a listener that is not called; a cursor of another scale."""
    read = "[...document.querySelectorAll('#signals .cursor')].map((c) => Number(c.getAttribute('d').slice(1).split(',')[0]))"
    rows = "document.getElementById('instant').textContent"
    before = page.run(rows)
    page.run(
        "(() => { const time = document.getElementById('time'); time.value = 90; time.dispatchEvent(new Event('input')); })()"
    )
    settled(page, 90)
    assert page.run(read) == [300.0] * 4  # of 1000 for 300 s
    assert page.run("document.getElementById('clock').textContent").startswith("90.0 of 300")
    error = page.run("rvjax.shown.flight.at(90).position_error_m")
    text = page.run(rows)
    assert text != before
    assert f"position error{error:.3g}" in text
    page.drag("#signals svg", (0.2, 0.5), (0.5, 0.5))
    settled(page, page.run("rvjax.shown.t"))
    assert page.run("rvjax.shown.t") == pytest.approx(150, abs=1)
    assert page.run(read) == pytest.approx([500] * 4, abs=4)


def test_an_address_opens_the_instant_and_follows_it(page: Browser, browser: Browser, folder: Path) -> None:
    """Kills: a fragment that is read before the flights, an address that stays behind, a flight that is not kept."""
    browser.open(folder / "report.html", "#sample=17&t=83.2")
    settled(page, 83.2)
    assert page.run("rvjax.shown.seen.sample") == 17
    assert page.run("document.getElementById('flight').value") == "17"
    page.run("location.hash = '#sample=4&t=12.5'")
    page.wait("rvjax.shown.seen.sample === 4")
    settled(page, 12.5)
    page.run("document.getElementById('stage').focus({preventScroll: true})")
    page.key("End")
    settled(page, 300)
    page.wait("location.hash === '#sample=4&t=300'")
    page.run("location.hash = '#sample=5&t=1'")
    page.wait("document.getElementById('replay-message').textContent !== ''")
    message = page.run("document.getElementById('replay-message').textContent")
    assert "sample 5 is not kept" in message
    assert "rvjax replay '" in message  # the quote in the path is quoted
    assert f"{str(folder).replace(chr(39), chr(39) + chr(34) + chr(39) + chr(34) + chr(39))}' --sample 5" in message
    assert page.run("rvjax.shown.flight.about.sample") == 4
    page.wait("Math.abs(document.getElementById('replay').getBoundingClientRect().top) < 2")


def test_keys_play_step_and_change_the_speed(page: Browser) -> None:
    """Kills: a key that scrolls the page instead, a step that is not a row, a speed outside of ×1 … ×64."""
    page.run("document.getElementById('stage').focus({preventScroll: true})")
    place = page.run("scrollY")
    for key, t in (
        ("ArrowRight", 1.0),
        ("ArrowRight", 2.0),
        ("ArrowLeft", 1.0),
        ("End", 300.0),
        ("ArrowLeft", 299.0),
        ("Home", 0.0),
    ):
        page.key(key)
        assert page.run("rvjax.shown.t") == pytest.approx(t, abs=1e-9)
    for key, speed in (("+", 16), ("+", 32), ("+", 64), ("+", 64), *(("-", s) for s in (32, 16, 8, 4, 2, 1, 1))):
        page.key(key, text=key)
        assert page.run("rvjax.shown.speed") == speed
    page.key(" ", "Space", " ")
    page.wait("rvjax.shown.t > 0.01")
    assert page.run("document.getElementById('play').textContent") == "Pause"
    page.key(" ", "Space", " ")
    assert page.run("rvjax.shown.playing") is False
    assert page.run("scrollY") == place


def test_places_and_attitudes_are_those_of_the_trace(page: Browser, folder: Path) -> None:
    """Read back from what was drawn, at rows and between them. Kills: components along other axes, an attitude that turns the
    long way round where the MRP switch, a place of the row before."""
    frame = pd.read_parquet(next((folder / "traces").glob("sample-0000017*")))
    sigma = Rotation.from_mrp(columns(frame, "sigma_{}"))
    place = sigma.apply(columns(frame, "rho_{}_m")) + PORT
    quantum = np.ptp(place, axis=0) / MOST
    t = frame["t_s"].to_numpy()
    page.run("rvjax.shown.open(17)")
    for row in (0, 1, 74, 75, 76, 150, 299, 300):
        page.run(f"rvjax.shown.to({t[row]}); rvjax.shown.draw()")
        seen = page.run("rvjax.shown.seen")
        assert seen["sample"] == 17
        assert np.all(np.abs(np.array(seen["place"]) - place[row]) <= quantum * 0.5001 + 1e-12)
        off = Rotation.from_quat(seen["quaternion"], scalar_first=True) * sigma[row].inv()
        assert off.magnitude() < 4 * 2 / MOST  # four components of at most 2, each to half a quantum
    turn = Rotation.from_rotvec(np.outer(0.9 + 0.03 * (t + 0.5), [0.6, 0.0, 0.8]))
    for row in (60, 74, 75, 200):
        page.run(f"rvjax.shown.to({t[row] + 0.5}); rvjax.shown.draw()")
        seen = page.run("rvjax.shown.seen")
        assert np.abs(np.array(seen["place"]) - (place[row] + place[row + 1]) / 2).max() <= quantum.max()
        off = Rotation.from_quat(seen["quaternion"], scalar_first=True) * turn[row].inv()
        assert off.magnitude() < 8 / MOST


def test_frames_are_those_of_port_and_orbit(page: Browser, folder: Path) -> None:
    """The drawn place in each frame, against SciPy. Kills: the transposed rotation, the wrong origin, a turn the other way."""
    frame = pd.read_parquet(next((folder / "traces").glob("sample-0000017*")))
    row = 120
    sigma = Rotation.from_mrp(columns(frame, "sigma_{}"))
    place = (sigma.apply(columns(frame, "rho_{}_m")) + PORT)[row]
    r, v = (frame.loc[row, [f"target_{n}_{a}_{u}" for a in "xyz"]].to_numpy(float) for n, u in (("r", "m"), ("v", "m_s")))
    unit = [x / np.linalg.norm(x) for x in (r, v, np.cross(r, v))]
    lvlh = np.array([place @ unit[1], -place @ unit[2], -place @ unit[0]])
    turned = Rotation.from_rotvec([0, -7612.7 / 6.878e6 * frame.loc[row, "t_s"], 0]).apply(lvlh)  # about −H-bar, with the orbit
    page.run("rvjax.shown.open(17)")
    for name, truth in (("port", place - PORT), ("lvlh", lvlh), ("inertial", turned)):
        page.run(f"rvjax.shown.to({frame.loc[row, 't_s']}); rvjax.shown.inFrame('{name}'); rvjax.shown.draw()")
        assert page.run("rvjax.shown.seen.centre") == pytest.approx(truth, abs=3e-3), name


def test_a_brush_counts_what_pandas_counts(page: Browser, table: pd.DataFrame) -> None:
    """And its interval is SciPy's. Kills: < for <=, a lost sample that is within a range, an interval of other counts."""
    column = "draw.pursuer.mass_kg"
    order = np.sort(table[column].to_numpy())
    gaps = np.diff(order[30:150])
    low = order[30 + gaps.argmax()] + gaps.max() / 2
    settling = table["metric.settling_time_s"]
    page.run(f"rvjax.linked.samples.choose({{'pursuer.mass_kg': [{low}, Infinity], 'metric.settling_time_s': [0, 1e6]}})")
    chosen = table[(table[column] >= low) & (settling <= 1e6)]
    counts = page.run("rvjax.linked.samples.counts")
    captured = int((chosen["outcome"] == "captured").sum())
    assert (counts["shown"], counts["n"], counts["captured"]) == (len(chosen), len(chosen), captured)
    page.run("rvjax.linked.samples.clear(); rvjax.linked.samples.only('captured', false)")
    rest = table[table["outcome"] != "captured"]
    assert page.run("rvjax.linked.samples.counts.n") == len(rest)
    shown = page.run("[...document.querySelectorAll('#sample-table tbody tr')].map((row) => row.textContent)")
    assert len(shown) == min(len(rest), 25)
    page.run(f"rvjax.linked.samples.clear(); rvjax.linked.samples.choose({{'pursuer.mass_kg': [{low}, Infinity]}})")
    chosen = table[table[column] >= low]
    k, n = int((chosen["outcome"] == "captured").sum()), len(chosen)
    truth = stats.binomtest(k, n).proportion_ci(0.95, method="exact")
    assert page.run("rvjax.linked.samples.counts.interval") == pytest.approx([truth.low, truth.high], rel=1e-9)
    sentence = page.run("document.getElementById('selection').textContent")
    assert f"{n} of 300 samples selected, {k} captured: {100 * k / n:.2f} %" in sentence
    assert "exploration" in page.run("document.getElementById('brushing').textContent")


def test_dragging_selects_in_every_picture(page: Browser, table: pd.DataFrame) -> None:
    """The form, an axis, the scatter and the histogram set ranges of the same selection. Kills: a brush upside down."""
    ranges = "Object.fromEntries(rvjax.linked.samples.ranges)"
    page.drag("#parallel", (0.04, 0.3), (0.04, 0.5))
    first = page.run("rvjax.linked.parallel.columns[0].name")
    ((name, (low, high)),) = page.run(ranges).items()
    assert name == first
    assert page.run(f"rvjax.linked.samples.column({json.dumps(name)}).ends.low") < low < high
    selected = page.run("rvjax.linked.samples.counts.shown")
    assert 0 < selected < 300
    assert len(page.run("document.querySelector('#filters .chip').textContent")) > 5
    page.run("document.querySelector('#filters .chip').click()")
    assert page.run(ranges) == {}
    page.run("(() => { for (const [id, x] of [['scatter-x', 'pursuer.mass_kg'], ['scatter-y', 'metric.settling_time_s'],"
             "['histogram-column', 'pursuer.mass_kg']]) { const e = document.getElementById(id); e.value = x;"
             "e.dispatchEvent(new Event('change')); } })()")  # fmt: skip
    page.drag("#scatter", (0.3, 0.4), (0.7, 0.85))
    both = page.run(ranges)
    assert set(both) == {"pursuer.mass_kg", "metric.settling_time_s"}
    inside = table
    for name, column in (("pursuer.mass_kg", "draw.pursuer.mass_kg"), ("metric.settling_time_s", "metric.settling_time_s")):
        inside = inside[inside[column].between(*both[name])]
    assert page.run("rvjax.linked.samples.counts.shown") == pytest.approx(len(inside), abs=1)  # one on an edge
    page.run("document.getElementById('filter-clear').click()")
    page.drag("#histogram", (0.4, 0.5), (0.6, 0.5))
    assert set(page.run(ranges)) == {"pursuer.mass_kg"}
    page.run("(() => { const at = (id) => document.getElementById(id); at('filter-column').value = 'pursuer.mass_kg';"
             "at('filter-from').value = '90'; at('filter-to').value = '100'; at('filter-set').click(); })()")  # fmt: skip
    assert page.run(ranges) == {"pursuer.mass_kg": [90, 100]}
    assert page.run("rvjax.linked.samples.counts.shown") == table["draw.pursuer.mass_kg"].between(90, 100).sum()


def test_a_click_replays_a_kept_sample_and_names_the_command_of_others(page: Browser) -> None:
    """Kills: a button that opens another sample, a command without its sample."""
    page.run("document.querySelector('#sample-table button[aria-label=\"Command for sample 1\"], #sample-table button').blur()")
    page.run("rvjax.linked.open(17)")
    assert page.run("rvjax.shown.flight.about.sample") == 17
    page.run("rvjax.linked.open(3)")
    assert "--sample 3" in page.run("document.getElementById('sample-message').textContent")
    assert page.run("rvjax.shown.flight.about.sample") == 17
    page.run("rvjax.linked.samples.choose({'pursuer.mass_kg': [-Infinity, Infinity]})")
    button = "document.querySelector('#sample-table tbody button')"
    sample = page.run(f"Number({button}.getAttribute('aria-label').split(' ').pop())")
    page.run(f"{button}.click()")
    if sample in KEPT:
        page.wait(f"rvjax.shown.flight.about.sample === {sample}")
    else:
        page.wait(f"document.getElementById('sample-message').textContent.includes('--sample {sample}')")


def test_the_interval_is_exact(page: Browser) -> None:
    """Against SciPy's beta quantiles. Kills: the tail of the other side, a series that has not converged, 0 and n."""
    cases = [(k, n, c) for n in (1, 2, 7, 60, 1000, 8192) for k in {0, 1, n // 3, n - 1, n} for c in (0.9, 0.95, 0.999)]
    found = page.run(f"{json.dumps(cases)}.map(([k, n, c]) => rvjax.statistics.clopperPearson(k, n, c))")
    for (k, n, c), (low, high) in zip(cases, found, strict=True):
        tail = (1 - c) / 2
        assert low == pytest.approx(stats.beta.ppf(tail, k, n - k + 1) if k else 0.0, rel=1e-8), (k, n, c)
        assert high == pytest.approx(stats.beta.isf(tail, k + 1, n - k) if k < n else 1.0, rel=1e-8), (k, n, c)


def test_without_webgl_the_wires_are_drawn(page: Browser, browser: Browser, folder: Path) -> None:
    """Kills: a page that ends where there is no WebGL2."""
    hide = "const get = HTMLCanvasElement.prototype.getContext;"
    hide += "HTMLCanvasElement.prototype.getContext = function (kind, ...rest)"
    hide += " { return kind.startsWith('webgl') ? null : get.call(this, kind, ...rest); };"
    script = browser.send("Page.addScriptToEvaluateOnNewDocument", source=hide)["identifier"]
    try:
        browser.open(folder / "report.html")
        assert page.run("rvjax.shown.renderer instanceof rvjax.canvas.Renderer")
        assert page.run("document.getElementById('scene-plain').hidden") is False
        shots = []
        for t in (0, 100):
            page.run(f"rvjax.shown.to({t}); rvjax.shown.draw()")
            shots.append(page.picture("#stage"))
        assert shots[0] != shots[1]
    finally:
        browser.send("Page.removeScriptToEvaluateOnNewDocument", identifier=script)
        browser.blank()


def test_reduced_motion_dark_narrow_and_print(page: Browser) -> None:
    """Kills: a camera that glides though the reader asked for calm, a page that plays by itself, a page wider than the screen."""
    assert page.run("rvjax.shown.playing") is False
    assert page.run("(rvjax.shown.draw(), rvjax.shown.look('chase'), rvjax.shown.camera.blend !== null)") is True
    page.media(prefers_reduced_motion="reduce", prefers_color_scheme="dark")
    page.run("rvjax.shown.look('hbar')")
    assert page.run("rvjax.shown.camera.blend") is None
    ground = page.run("getComputedStyle(document.body).backgroundColor")
    assert sum(map(int, ground[4:-1].split(","))) < 150
    page.size(400, 800)
    assert page.run("document.documentElement.scrollWidth") <= 400
    page.media("print")
    assert page.run("getComputedStyle(document.getElementById('replay')).display") == "none"
    assert page.run("getComputedStyle(document.getElementById('brushing')).display") == "none"
    page.media()


def test_without_scripts_the_page_is_as_it_was(browser: Browser, folder: Path) -> None:
    """Kills: an empty frame or a link to nothing where no script runs."""
    browser.send("Emulation.setScriptExecutionDisabled", value=True)
    try:
        browser.open(folder / "report.html", ready="true")
        hidden = "getComputedStyle(document.getElementById('{}')).display"
        assert browser.run(hidden.format("replay")) == "none"
        assert browser.run("document.querySelectorAll('nav li:not([hidden])').length") == browser.run(
            "document.querySelectorAll('main > section:not(.live)').length"
        )
    finally:
        browser.send("Emulation.setScriptExecutionDisabled", value=False)
        browser.blank()


@pytest.mark.parametrize("place", ["description", "requirement"])
def test_hostile_texts_do_nothing_and_the_policy_holds(
    browser: Browser, made: Make, tmp_path: Path, undrawn: Within, place: str
) -> None:
    """Kills: a text of the campaign as markup or as a script, in the page or in its data; a policy that lets others run."""
    marks = [
        "</script>",
        "<script>window.pwned=1</script>",
        "<img src=x onerror=window.pwned=1>",
        "<svg onload=window.pwned=1>",
        "]]>",
    ]
    marks += ["<!--<script>", "--><script>window.pwned=1</script>", "${window.pwned=1}", "{{7*7}}", "javascript:window.pwned=1"]
    marks += [
        "<a href='javascript:window.pwned=1'>x</a>",
        "<base href='https://example.org/'>",
        "\u2028window.pwned=1",
        "'\"`|\\",
    ]
    marks += ["<iframe srcdoc='<script>parent.pwned=1</script>'></iframe>", "<meta http-equiv=refresh content='0;url=x'>"]
    text = " ".join(a + b for a in marks for b in marks)
    given = {"description": json.dumps(text)} if place == "description" else {}
    if place == "requirement":
        given["require"] = f"\n  - {{metric: captured, at_least: 0.9, name: {json.dumps(text)}}}\n"
    path = made(tmp_path / "<img src=x onerror=window.pwned=1>", 40, **given)
    with undrawn():
        build(path)
    browser.media()
    browser.open(path / "report.html")
    assert "onerror" in browser.run("document.body.textContent")
    assert browser.run("window.pwned") is None
    assert (
        browser.run("document.querySelectorAll('img, iframe, base, meta[http-equiv=refresh], a[href^=javascript]').length") == 0
    )
    assert browser.console == []
    assert len(browser.requests) == 1
    add = "(() => {{ const e = document.createElement('{}'); {}; document.body.append(e); return window.pwned; }})()"
    assert browser.run(add.format("script", "e.textContent = 'window.pwned = 1'")) is None
    assert browser.run(add.format("script", "e.src = 'data:text/javascript,window.pwned=1'")) is None
    assert browser.run("fetch('data:,x').then(() => 'fetched', () => 'refused')") == "refused"
    assert browser.run("new Promise((done) => setTimeout(() => done(window.pwned ?? 'nothing'), 50))") == "nothing"
    assert any("Content Security Policy" in line for line in browser.console)
    browser.blank()
