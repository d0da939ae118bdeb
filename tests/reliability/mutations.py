"""Campaign files that went wrong: seeded mutations of good ones, and files made to hurt.

A text is UTF-8 decoded with `surrogateescape`, so that bytes which are none stay in it until it is encoded again.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from random import Random

TESTS = Path(__file__).parents[1]
GOOD = (*sorted((TESTS.parent / "campaigns").glob("*.yaml")), TESTS / "spec" / "good.yaml")

Mutation = Callable[[Random, str], str]

_TOKEN = re.compile(r"[\w.+-]+")
_NUMBER = re.compile(r"(?<![\w.])-?\d+(\.\d+)?(?![\w.])")
_COUNT = re.compile(r"\b(samples|seed): \d+")
_KEY = re.compile(r"\b[a-zA-Z_]\w*(?=:)")
_VALUE = re.compile(r"(?<=: )[\w.+-]+")

_EXTREMES = (
    "0", "-0.0", "1e-320", "5e-324", "1e100", "-1e100", "1.1e100", "1e308", "1e999", "9" * 39, "9" * 41, "9" * 5000,
    "1e-9999", ".inf", "-.Inf", ".nan", "NaN", "0x7fffffffffffffff", "0o777", "1_000", "1:30:00", "0b11", "1e", "+.5",
    "2147483648", "9223372036854775807", "9223372036854775808", "18446744073709551616", "٣", "１２", "½", "1,5", "1e5e5",
    "--1", "2026-01-01",
)  # fmt: skip
_VALUES = (
    "null", "~", "true", "no", "''", '""', "[]", "{}", "text", "[1, 2]", "[1, 2, 3]", "[[1, 2], [3, 4]]",
    "{a: {b: {c: 1}}}", "{uniform: [0, 1]}", "{uniform: [1, 0]}", "{normal: [100, 1]}", "{choice: []}", "{choice: [1, 2]}",
    "{box: -1}", "{ball: -2}", "{choice: {values: [1], weights: [0]}}", "{truncated_normal: [1, 1e-90, 0, 2]}",
    "{log_uniform: [1e-300, 1e90]}", "[0.5, {}]", "{half_normal: {half_normal: 1}}", "{use: pd-plus}", "[{use: bias}]",
    "{use: [1]}", "{force: 1}", "{force: 1, torque: [1]}", "\n  - 1\n  - 2", "|\n  text", "1e-30", "{1: 2}", "{[1]: 2}",
    "{? {a: 1} : 2}", "{a, b, c}", "- 1",
)  # fmt: skip
_SYNTAX = (
    ": ", ", ", "[", "]", "{", "}", "- ", "? ", "!", "!!", "&a ", "*a", "*a ", "|", ">", "'", '"', "#", " #", "%", "@", "`",
    "<<: ", "---\n", "...\n", "\n---\n", "\n", "\n\n", "\t", " ", "  ", "\\", '"\\x41"', '"\\u2028"', '"\\x1b[31m"',
    '"\\UFFFFFFFF"', '"\\ud800"', '"\\q"', "|-\n", "|9\n", ">+\n", "''", "?", "-", "=", "~", ":", "::", "\n:\n",
    "%YAML 1.1\n---\n", "%TAG ! x:\n---\n",
)  # fmt: skip
_STRANGE = (
    "\x00", "\x01", "\x07", "\x1b[31m", "\x7f", "\x85", "\x9b", "\xa0", "\u200b", "\u200e", "\u2028", "\u2029", "\u202e",
    "\u3000", "\ufeff", "\ufffd", "\uffff", "\U0001f680", "\U000e0001", "\v", "\f", "\r", "\r\n", "\x1c", "é", "e\u0301",
    "名", "\udcff", "\udcc3", "\udcc0\udc80", "\udced\udca0\udc80", "\udcf4\udc90\udc80\udc80", "\udcff\udcfe", "\udc80",
)  # fmt: skip
_TAGS = (
    "!!str ", "!!int ", "!!float ", "!!bool ", "!!null ", "!!binary ", "!!set ", "!!omap ", "!!timestamp ", "!local ", "! ",
    "!e!x ", "!<tag:x,2026:a%0Ab> ", "!<> ", "!!python/name:os.system ", "!!python/object/apply:os.system ",
    "!!python/tuple ", "!include ",
)  # fmt: skip


def _at(random: Random, text: str, put: str, length: int = 0) -> str:
    """`put` instead of `length` characters anywhere."""
    place = random.randint(0, len(text))
    return text[:place] + put + text[place + length :]


def _instead(random: Random, text: str, pattern: re.Pattern[str], make: Callable[[str], str]) -> str:
    """Another text for one match of a pattern."""
    found = list(pattern.finditer(text))
    if not found:
        return text
    one = random.choice(found)
    return text[: one.start()] + make(one[0]) + text[one.end() :]


def _lines(random: Random, text: str, change: Callable[[list[str], int], object]) -> str:
    """The lines after a change in place around one of them."""
    lines = text.split("\n")
    change(lines, random.randrange(len(lines)))
    return "\n".join(lines)


def flip_a_bit(random: Random, text: str) -> str:
    data = bytearray(text.encode("utf-8", "surrogateescape") or b"\0")
    data[random.randrange(len(data))] ^= 1 << random.randrange(8)
    return data.decode("utf-8", "surrogateescape")


def delete(random: Random, text: str) -> str:
    return _at(random, text, "", random.randint(1, 12))


def insert_bytes(random: Random, text: str) -> str:
    return _at(random, text, random.randbytes(random.randint(1, 6)).decode("utf-8", "surrogateescape"))


def duplicate_a_line(random: Random, text: str) -> str:
    return _lines(random, text, lambda lines, at: lines.insert(at, lines[at]))


def repeat_a_line(random: Random, text: str) -> str:
    return _lines(random, text, lambda lines, at: lines.__setitem__(slice(at, at), [lines[at]] * random.choice((3, 20, 100))))


def delete_a_line(random: Random, text: str) -> str:
    return _lines(random, text, lambda lines, at: lines.pop(at))


def swap_lines(random: Random, text: str) -> str:
    def swap(lines: list[str], at: int) -> None:
        other = random.randrange(len(lines))
        lines[at], lines[other] = lines[other], lines[at]

    return _lines(random, text, swap)


def indent_a_line(random: Random, text: str) -> str:
    indent = random.choice(("", " ", "  ", "   ", "\t", " \t", "        "))
    return _lines(random, text, lambda lines, at: lines.__setitem__(at, indent + lines[at].lstrip()))


def join_lines(random: Random, text: str) -> str:
    return _lines(random, text, lambda lines, at: lines.__setitem__(slice(at, at + 2), ["".join(lines[at : at + 2])]))


def swap_tokens(random: Random, text: str) -> str:
    found = list(_TOKEN.finditer(text))
    if len(found) < 2:
        return text
    one, two = sorted(random.sample(found, 2), key=lambda match: match.start())
    return text[: one.start()] + two[0] + text[one.end() : two.start()] + one[0] + text[two.end() :]


def insert_syntax(random: Random, text: str) -> str:
    return _at(random, text, random.choice(_SYNTAX), random.choice((0, 0, 1)))


def insert_strange(random: Random, text: str) -> str:
    return _at(random, text, random.choice(_STRANGE))


def exchange_a_bracket(random: Random, text: str) -> str:
    return _instead(random, text, re.compile(r"[\[\]{},:]"), lambda _: random.choice("[]{},:"))


def take_an_extreme_number(random: Random, text: str) -> str:
    return _instead(random, text, _NUMBER, lambda _: random.choice(_EXTREMES))


def change_a_number(random: Random, text: str) -> str:
    return _instead(random, text, _NUMBER, lambda found: f"{float(found) * random.uniform(0.8, 1.3):.4g}")


def change_a_whole_number(random: Random, text: str) -> str:
    return _instead(random, text, _COUNT, lambda found: f"{found.partition(' ')[0]} {random.randint(1, 10**9)}")


def rename_a_key(random: Random, text: str) -> str:
    ways: list[Callable[[str], str]] = [
        str.upper, str.title, lambda key: key[:-1], lambda key: key[1:] + key[:1], lambda key: f"{key}_", lambda key: f'"{key}"',
        lambda key: key.replace("_s", "_ms").replace("_m", "_km").replace("_kg", "_g"), lambda _: "<<", lambda _: "x" * 2000,
        lambda key: f'"{key}\\n\\x85\\u2028x"', lambda key: f"{key}.{key}", lambda _: "", lambda _: "null", lambda _: "1",
    ]  # fmt: skip
    return _instead(random, text, _KEY, random.choice(ways))


def take_another_value(random: Random, text: str) -> str:
    return _instead(random, text, _VALUE, lambda _: random.choice(_VALUES))


def quote_a_value(random: Random, text: str) -> str:
    return _instead(random, text, _VALUE, lambda value: random.choice((f'"{value}"', f"'{value}'", f'"{value}', f"|\n  {value}")))


def truncate(random: Random, text: str) -> str:
    return text[: random.randint(0, len(text))]


def end_lines_otherwise(random: Random, text: str) -> str:
    return text.replace("\n", random.choice(("\r\n", "\r\n", "\r", "\x85", "\u2028", "\n\n")))


def mark_the_byte_order(random: Random, text: str) -> str:
    return random.choice(("\ufeff", "\ufeff", "\ufeff\ufeff", "\udcff\udcfe", "\udcfe\udcff")) + text


def anchor_or_alias(random: Random, text: str) -> str:
    anchored = _instead(random, text, _VALUE, lambda value: random.choice((f"&a {value}", "*a", f"&a {value}\nx: *a", "&a")))
    return _lines(random, anchored, lambda lines, at: lines.insert(at, random.choice(("", "<<: *a", "<<: {a: 1}", "x: &a [*a]"))))


def tag_a_value(random: Random, text: str) -> str:
    return _instead(random, text, _VALUE, lambda value: random.choice(_TAGS) + random.choice((value, "[os, 1]", "")))


def nest_deeply(random: Random, text: str) -> str:
    depth = random.choice((5, 31, 33, 500))
    begin, end = random.choice((("[", "]"), ("{a: ", "}"), ("{? ", "}")))
    return _instead(random, text, _VALUE, lambda value: begin * depth + value + end * depth)


def splice(random: Random, text: str) -> str:
    other = random.choice(_texts())
    return text[: random.randint(0, len(text))] + other[random.randint(0, len(other)) :]


def comment(random: Random, text: str) -> str:
    words = random.choice(("# a comment", "#", "", "   ", "# é 名 \U0001f680", "#" * 3000))
    return _lines(random, text, lambda lines, at: lines.insert(at, words))


def sort_sections(random: Random, text: str) -> str:
    """The sections in another order, which means the same."""
    parts = re.split(r"\n(?=\w)", text.strip("\n"))
    random.shuffle(parts)
    return "\n".join(parts) + "\n"


MUTATIONS: tuple[Mutation, ...] = (
    flip_a_bit, delete, insert_bytes, duplicate_a_line, repeat_a_line, delete_a_line, swap_lines, indent_a_line, join_lines,
    swap_tokens, insert_syntax, insert_strange, exchange_a_bracket, take_an_extreme_number, change_a_number,
    change_a_whole_number, rename_a_key, take_another_value, quote_a_value, truncate, end_lines_otherwise,
    mark_the_byte_order, anchor_or_alias, tag_a_value, nest_deeply, splice, comment, sort_sections,
)  # fmt: skip


@cache
def _texts() -> tuple[str, ...]:
    return tuple(path.read_text(encoding="utf-8") for path in GOOD)


def mutated(number: int) -> bytes:
    """A good file after one to three mutations; the same for the same number."""
    random = Random(number)
    text = random.choice(_texts())
    for _ in range(random.choice((1, 1, 1, 2, 3))):
        text = random.choice(MUTATIONS)(random, text)
    return text.encode("utf-8", "surrogateescape")


@dataclass(frozen=True)
class Hostile:
    """A file made to hurt; accepted: it is a good campaign, only a long one."""

    name: str
    content: bytes
    accepted: bool = False


def hostile() -> list[Hostile]:
    """Bombs, depths, sizes, tags, characters, and the most of everything that a file may hold."""
    refused: dict[str, str] = {**_bombs(), **_depths(), **_sizes(), **_tags(), **_characters(), **_most_refused()}
    files = [Hostile(name, text.encode("utf-8", "surrogateescape")) for name, text in refused.items()]
    files += [Hostile(name, text.encode(), accepted=True) for name, text in _most_accepted().items()]
    files += [Hostile(f"utf-{width}", _texts()[-1].encode(f"utf-{width}")) for width in (16, 32)]
    return files


def _bombs() -> dict[str, str]:
    """Aliases that stand for ever more."""
    levels = ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
    levels += [f"a{level}: &a{level} [{', '.join([f'*a{level - 1}'] * 10)}]" for level in range(1, 10)]
    maps = ["a0: &a0 {x: 1, y: 2}", *(f"a{level}: &a{level} {{<<: *a{level - 1}, x: *a{level - 1}}}" for level in range(1, 60))]
    return {
        "billion laughs": "\n".join(levels),
        "quadratic bomb": f"a: &a '{'x' * 60_000}'\nb: [{', '.join(['*a'] * 10_000)}]",
        "bomb of merges": "\n".join(maps),
        "alias of itself": "a: &a [*a, *a, *a]\n<<: *a",
        "anchors": f"a: [{'&x 1,' * 25_000}]",
        "aliases": f"a: &x 1\nb: [{'*x,' * 30_000}]",
    }


def _depths() -> dict[str, str]:
    """500 levels, and as many as a file holds."""
    return {
        "500 lists": "a: " + "[" * 500 + "]" * 500,
        "500 mappings": "{a: " * 500 + "1" + "}" * 500,
        "500 block lists": "a:\n" + " " + "- " * 500 + "1",
        "500 block mappings": "".join(" " * level + "a:\n" for level in range(500)),
        "500 keys of keys": "? " * 500 + "a",
        "500 flow keys": "{? " * 500 + "a" + "}" * 500,
        "120,000 open lists": "[" * 120_000,
        "30,000 open mappings": "{a: " * 30_000,
        "60,000 block lists": "- " * 60_000,
        "60,000 keys of keys": "? " * 60_000,
        "60,000 colons": ": " * 60_000,
    }


def _sizes() -> dict[str, str]:
    """100 MB, a million keys, and what has to be looked at twice within 128 KiB."""
    return {
        "100 MB": "a: 1 # and so on for ever\n" * 4_000_000,
        "a million keys": "".join(f"k{number}: 1\n" for number in range(1_000_000)),
        "a million times one key": "k: 1\n" * 1_000_000,
        "a million keys in a line": "{" + "".join(f"k{number}," for number in range(1_000_000)) + "}",
        "16,000 times one key": "k: 1\n" * 16_000,
        "60,000 lines of a text": 'a: "' + "b\n" * 60_000 + '"',
        "60,000 lines of plain text": "a\n" * 60_000,
        "one long key": "a b " * 30_000 + ": 1",
        "lines that might be keys": ("x" * 1020 + "\n") * 120,
        "one long number": "samples: " + "9" * 120_000,
        "quotes": '"' * 120_000,
        "apostrophes": "'" * 120_000,
        "block scalars": "|\n" * 60_000,
        "documents": "---\n" * 30_000,
        "ends of documents": "...\n" * 30_000,
        "directives": "%YAML 1.2\n" * 10_000,
        "commas": "a: [" + "," * 120_000 + "]",
        "dashes": "-" * 120_000,
        "carriage returns": "\r" * 120_000,
        "byte order marks": "\ufeff" * 40_000,
        "spaces": " " * 120_000 + "a: 1",
        "tabs": "\t" * 120_000,
        "merge keys": "<<: {a: 1}\n" * 10_000,
    }


def _tags() -> dict[str, str]:
    """Tags that some loaders obey."""
    calls = ("os.system ['touch injected']", "subprocess.Popen [[touch, injected]]", "builtins.exec ['raise SystemExit(7)']")
    return {
        **{f"tag that calls {call.split()[0]}": f"a: !!python/object/apply:{call}" for call in calls},
        "tag of a module": "a: !!python/module:antigravity",
        "15,000 tags": f"a: [{'!!str 1,' * 15_000}]",
        "handles of tags": "".join(f"%TAG !{number}! tag:x,2026:\n" for number in range(4_000)) + "---\na: 1",
        "one long tag": "!" * 120_000,
        "tag with a line end": "a: !<tag:x%0A/etc/passwd:1:1:%20fine> 1",
    }


def _characters() -> dict[str, str]:
    """Characters that are no text, and such as end a line somewhere."""
    return {
        "NUL": "a: \x00",
        "only NUL": "\x00" * 100_000,
        "NUL in quotes": 'a: "\\0"',
        "NUL in every line": "a: \x00\n" * 20_000,
        "not UTF-8": "a: \udcff" * 20_000,
        "surrogates": "a: \udced\udca0\udc80",
        "overlong": "a: \udcc0\udcaf",
        "escape sequences": "a: \x1b[2J\x1b]0;title\x07",
        "key with line ends": '"a\\n\\r\\v\\f\\x1c\\x85\\u2028\\u2029/etc/passwd:1:1: b": 1',
        "alias with line ends": "a: *b\x85c\u2028d\n",
        "turned text": '"\\u202e\\u2066x": 1',
        "escape beyond Unicode": '"\\UFFFFFFFF": 1',
        "lone surrogates": '"\\ud800": 1',
    }


def _with(old: str, new: str) -> str:
    """tests/spec/good.yaml with something else in one place."""
    text = _texts()[-1]
    assert text.count(old) == 1
    return text.replace(old, new)


_FAULT = "{use: effectiveness, channels: all, onset_s: {uniform: [30, 150]}, remaining: {uniform: [0.5, 1]}}"
_DISTURBANCE = "{use: constant, force_N: [0.01, 0, 0]}"
_REQUIREMENT = "  - {metric: captured, at_least: 0.9}\n"


def _many(entry: str, count: int) -> str:
    return ", ".join(entry.replace("#", str(number)) for number in range(count))


def _most_refused() -> dict[str, str]:
    """As many mistakes as a file holds, each of which costs a message, and some a search for the nearest word."""
    return {
        "faults that lack all": _with(_FAULT, _many("{use: bias}", 1_600)),
        "faults that nobody knows": _with(_FAULT, _many("{use: effectivenes-#}", 1_600)),
        "faults of one name": _with(_FAULT, _many("{use: bias, name: a}", 950)),
        "keys that a fault lacks": _with(_FAULT, "{use: bias, " + _many("onset_deg_#: 1", 2_300) + "}"),
        "unknown keys": "".join(f"mass_{number}: 1\n" for number in range(2_400)),
        "unknown laws": _with("[0.01, 0, 0]", "[" + _many("{truncated_normale_#: 1}", 1_500) + "]"),
        "requirements on nothing": _with(_REQUIREMENT, "  [" + _many("{metrik: a}", 1_500) + "]\n"),
        "metrics that nobody knows": _with(_REQUIREMENT, "  [" + _many("{metric: settling_time_#}", 1_500) + "]\n"),
        "a choice of text": _with("{uniform: [80, 120]}", "{choice: [" + _many("a", 4_500) + "]}"),
        "long texts": _with("name: docking", f"name: {'a' * 120_000}"),
    }


def _most_accepted() -> dict[str, str]:
    """Good campaigns as long as they may be."""
    return {
        "600 faults": _with(_FAULT, _many("{use: bias, onset_s: 3, share: 0.1}", 600)),
        "300 drawn faults": _with(_FAULT, _many(_FAULT.replace("channels: all, ", ""), 300)),
        "600 disturbances": _with(_DISTURBANCE, _many("{use: constant, force_N: {ball: 1}}", 600)),
        "900 requirements": _with(_REQUIREMENT, "  [" + _many("{metric: captured, at_least: 0.9}", 900) + "]\n"),
        "a choice of 4,000": _with("{uniform: [80, 120]}", "{choice: [" + _many("1#", 4_000) + "]}"),
        "120 KB of description": _with("name: docking", f"name: docking\ndescription: '{'its ' * 20_000}'"),
        "60,000 comments": _texts()[-1] + "#\n" * 60_000,
    }
