"""Each bad campaign file is refused at the right place, with the right words; nothing else ever comes out of a file."""

from __future__ import annotations

import os
import stat
import time
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rvjax.campaign import Spec, load, parse
from rvjax.errors import CampaignError
from tests.spec.corpus import bad_files, check_refused

BAD = bad_files(Path(__file__).parent / "bad")
GOOD = Path(__file__).parent / "good.yaml"


@pytest.mark.parametrize("path", BAD, ids=[path.stem for path in BAD])
def test_bad_file(path: Path) -> None:
    check_refused(path, load)


def test_the_corpus_is_large_and_the_good_file_good(good: Path) -> None:
    assert len(BAD) >= 50
    assert load(good).name == "docking"


def test_a_byte_order_mark_is_no_mistake(good: Path, tmp_path: Path) -> None:
    path = tmp_path / "marked.yaml"
    path.write_text(good.read_text(), encoding="utf-8-sig")
    assert load(path) == load(good)


def test_one_missing_key_is_one_finding(good: Path, tmp_path: Path) -> None:
    path = tmp_path / "short.yaml"
    path.write_text(good.read_text().replace("controller: {use: pd-plus}\n", ""))
    assert [str(finding) for finding in parse(path)[1]] == [
        f"{path}:1:1: controller: missing; accepted: the controller under test"
    ]


def test_five_mistakes_are_five_findings_in_file_order(good: Path, tmp_path: Path) -> None:
    """Also those that come from the file itself (a key twice) and from two values together (window and duration)."""
    text = good.read_text()
    for old, new in (
        ("samples: 100", "samples: 0"),
        ("seed: 7", "seed: 7\nseed: 8"),
        ("step_s: 0.05}", "step_s: 0.05}\ncapture: {window_s: 400}"),
        ("[80, 120]", "[-80, 120]"),
        ("at_least: 0.9", "at_last: 0.9"),
    ):
        assert old in text
        text = text.replace(old, new)
    path = tmp_path / "five.yaml"
    path.write_text(text)
    with pytest.raises(CampaignError) as caught:
        load(path)
    places = [(finding.where.removeprefix(f"{path}:"), finding.path) for finding in caught.value.findings]
    assert places == [
        ("3:10", "samples"),
        ("5:1", "seed"),
        ("8:21", "capture.window_s"),
        ("14:22", "pursuer.mass_kg.uniform"),
        ("22:24", "require.0.at_last"),
    ]
    assert str(caught.value).count("\n") == 4


@pytest.mark.parametrize(
    ("content", "place", "fragment"),
    [
        (b"", "1:1", "the file is empty"),
        (b"# only a comment\n---\n", "1:1", "the file is empty"),
        (b"- 1\n- 2\n", "1:1", "found a list of 2; accepted: a mapping"),
        (b"just words", "1:1", "found the text 'just words'"),
        (b"a: 1\nb: \x00", "2:4", "character U+0000"),
        (b"a: 1\nb: \xff\xfe", "2:4", "byte 0xff is not UTF-8"),
        ("a: é\n".encode("utf-16"), "1:1", "byte 0xff is not UTF-8"),
        (b'a: "\\UFFFFFFFF"', "1:1", "this is not YAML"),
        (b"a: [1, 2", "1:9", "this is not YAML"),
        (b"x" * 200_000, "1:1", "the file is larger than 128 KiB"),
        (b"a: [" + b"1," * 6000 + b"]", "1:9999", "more than 5,000 values"),
        (b"a: " + b"9" * 5000, "1:4", "a number of 5000 characters"),
        (b"a: &x [" + b"*x," * 100 + b"]", "1:8", "the alias *x"),
        (b"[" * 100_000, "1:34", "nested deeper than 32 levels"),
    ],
)
def test_files_that_are_no_campaign(content: bytes, place: str, fragment: str, tmp_path: Path) -> None:
    path = tmp_path / "file.yaml"
    path.write_bytes(content)
    _, findings, _ = parse(path)
    assert any(str(finding).startswith(f"{path}:{place}: ") and fragment in str(finding) for finding in findings)


def test_paths_that_cannot_be_read(tmp_path: Path) -> None:
    locked = tmp_path / "locked.yaml"
    locked.write_text("a: 1")
    locked.chmod(0)
    paths = {tmp_path: "this is a folder", tmp_path / "no.yaml": "No such file", Path("a\0b"): "null byte"}
    if os.geteuid():  # nothing is locked for the superuser
        paths[locked] = "Permission denied"
    for path, fragment in paths.items():
        with pytest.raises(CampaignError) as caught:
            load(path)
        assert fragment in str(caught.value)
    locked.chmod(stat.S_IRUSR | stat.S_IWUSR)


@pytest.mark.parametrize(
    "text",
    [
        "pursuer: {" + "".join(f"mass_{i}: 1, " for i in range(2_000)) + "}",
        "require: [" + "{metrik: a}, " * 1_500 + "]",
        "faults: [" + "{use: a}, " * 1_500 + "]",
        "a: [" + "&x 1," * 25_000 + "]",
        'a: "' + "b\n" * 60_000 + '"',
        "? " * 50_000,
    ],
    ids=["keys", "requirements", "faults", "anchors", "folded", "nested-keys"],
)
def test_hostile_files_take_a_bounded_time(text: str, tmp_path: Path) -> None:
    """Each takes about a second of processor time; unlimited nodes, or work that grows with their square, take far more."""
    path = tmp_path / "hostile.yaml"
    path.write_text(text)
    start = time.process_time()
    spec, findings, _ = parse(path)
    assert spec is None
    assert findings
    assert time.process_time() - start < 5.0


def _accepted_or_refused(text: str, path: Path) -> None:
    path.write_bytes(text.encode("utf-8", errors="surrogatepass"))
    spec, findings, _ = parse(path)
    assert isinstance(spec, Spec) != bool(findings)
    for finding in findings:
        assert finding.where.startswith(f"{path}:")
        assert finding.found


SCALARS = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-3, 400),
    st.floats(width=16, allow_nan=False, allow_infinity=False),
    st.sampled_from(["a", "", "all", "captured", "float64"]),
)
WORDS = st.sampled_from(["uniform", "normal", "choice", "box", "ball", "use", "name", "metric", "force", "principal", "x"])
VALUES = st.recursive(
    SCALARS, lambda inner: st.lists(inner, max_size=6) | st.dictionaries(WORDS, inner, max_size=3), max_leaves=8
)


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(text=st.text(max_size=200))
def test_any_text_is_accepted_or_refused(text: str, tmp_path: Path) -> None:
    _accepted_or_refused(text, tmp_path / "any.yaml")


@settings(max_examples=80, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data(), junk=st.text(alphabet=st.sampled_from("{}[]:,-&*!|>'\"%@#? \n\tab01.~<"), max_size=6))
def test_any_damage_to_a_good_file_is_accepted_or_refused(data: st.DataObject, junk: str, tmp_path: Path) -> None:
    text = GOOD.read_text()
    at = data.draw(st.integers(0, len(text)))
    end = data.draw(st.integers(at, min(at + 8, len(text))))
    _accepted_or_refused(text[:at] + junk + text[end:], tmp_path / "damaged.yaml")


@settings(max_examples=80, deadline=None)
@given(data=st.data(), value=VALUES)
def test_any_value_at_any_place_is_accepted_or_refused(data: st.DataObject, value: object) -> None:
    spec, findings, source = parse(GOOD)
    assert spec is not None
    place = data.draw(st.sampled_from([place for place in source.marks if place and "?" not in place]))
    text = repr(value).replace("None", "null").replace("True", "true").replace("False", "false")
    changed, findings, _ = parse(GOOD, [f"{'.'.join(map(str, place))}={text}"])
    assert isinstance(changed, Spec) != bool(findings)
