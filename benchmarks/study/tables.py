"""The tables of docs/study.md, from the record of the study."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from benchmarks import markdown
from benchmarks.study.results import KINDS
from rvjax.columns import CHANNELS

Json = Mapping[str, Any]

CLASSES = ("collided", "not finite", "left the corridor", "position", "attitude only")
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def rare(value: float) -> str:
    """A small probability: 1.3·10⁻⁵."""
    if value == 0:
        return "0"
    digits, exponent = f"{value:.1e}".split("e")
    return f"{digits}·10{str(int(exponent)).translate(SUPERSCRIPTS)}"


def percent(value: float, digits: int = 2) -> str:
    """A share as per cent; never rounded to 100 or to 0 where it is not."""
    if value in (0, 1):
        return f"{100 * value:.0f}"
    shown = f"{100 * value:.{digits}f}"
    return percent(value, digits + 1) if float(shown) in (0, 100) else shown


def interval(number: Json | None, form: str) -> str:
    """A number with its interval; a dash where there is none, "never" for one that is not finite."""
    if number is None:
        return "–"
    values = [number[key] for key in ("value", "low", "high")]
    if any(isinstance(value, str) or value is None for value in values[:1]):
        return "never"
    value, low, high = (format(each, form) if isinstance(each, (int, float)) else "never" for each in values)
    return value if low == value == high else f"{value} [{low}, {high}]"


def table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """In Markdown."""
    return "\n".join([markdown.head(heads), *map(markdown.row, rows)])


def _rows(record: Json, row: Callable[[str, Json], Sequence[str]]) -> list[Sequence[str]]:
    return [(f"`{name}`", *row(name, of)) for name, of in record["controllers"].items()]


def search(record: Json) -> str:
    """What the searches found."""

    def row(_: str, of: Json) -> Sequence[str]:
        came = of["search"]
        gains = ", ".join(f"{name} {value:g}" for name, value in came["gains"].items())
        return f"{came['candidate']}{'' if came['met'] else ', closest'}", f"{came['flights']:,}", gains

    return table(("controller", "candidate", "flights", "gains"), _rows(record, row))


def outcomes(record: Json) -> str:
    """Captured flights, and classes of the others."""

    def row(_: str, of: Json) -> Sequence[str]:
        captured = of["captured"]
        low, high = (percent(captured[end]) for end in ("low", "high"))
        return (
            f"{of['account']['captured']:,}",
            f"{percent(captured['value'])} [{low}, {high}]",
            *(f"{of['classes'][name]:,}" for name in CLASSES),
        )

    return table(("controller", "captured", "%", *CLASSES), _rows(record, row))


def verdicts(record: Json) -> str:
    """Of every requirement."""
    names = list(next(iter(record["controllers"].values()))["requirements"])
    return table(("controller", *names), _rows(record, lambda _, of: [of["requirements"][name] for name in names]))


def cost(record: Json) -> str:
    """Fuel, time, accuracy, saturation."""

    def row(_: str, of: Json) -> Sequence[str]:
        numbers = of["numbers"]
        error = numbers["window_position_error_m.q95"]
        scaled = {key: 1000 * value if isinstance(value, (int, float)) else value for key, value in error.items()}
        return (
            interval(numbers["delta_v_m_s.q50"], ".2f"),
            interval(numbers["delta_v_m_s.q95"], ".2f"),
            interval(numbers["settling_time_s.q95"], ".1f"),
            interval(scaled, ".1f"),
        )

    heads = ("controller", "Δv, median [m/s]", "Δv, 95 % [m/s]", "settling, 95 % [s]", "position error, 95 % [mm]")
    return table(heads, _rows(record, row))


def paired(record: Json) -> str:
    """Against the controller under test, on the same draws."""

    def row(_: str, of: Json) -> Sequence[str]:
        came = of["against"]
        p = "below 10⁻⁹" if came["p"] < 1e-9 else f"{came['p']:.2g}"
        return f"{came['only']:,}", f"{came['other']:,}", p, f"{came['both']:,}", interval(came["delta_v"], "+.2f")

    rows = [row for row in _rows(record, row) if row[0] != f"`{next(iter(record['controllers']))}`"]
    heads = (
        "controller",
        "captured by it only",
        "by `saturated-adaptive` only",
        "McNemar's p",
        "by both",
        "Δv of it more, median [m/s]",
    )
    return table(heads, rows)


def kinds(record: Json) -> str:
    """Share of flights that are not captured, with and without each kind of fault."""

    def cell(of: Json, kind: str) -> str:
        both = (of["kinds"][kind][which] for which in ("with", "without"))
        return " / ".join(percent(each["count"] / each["n"]) for each in both)

    return table(("controller", *KINDS), _rows(record, lambda _, of: [cell(of, kind) for kind in KINDS]))


def collisions(record: Json) -> str:
    """Counted and estimated probability of a collision."""

    def row(_: str, of: Json) -> Sequence[str]:
        came = of["collisions"]
        counted, estimated = (
            f"{rare(value)} [{rare(low)}, {rare(high)}]"
            for value, low, high in (
                [of["collided"][key] for key in ("value", "low", "high")],
                [came[key] for key in ("estimate", "low", "high")],
            )
        )
        estimate = f"refused: {'; '.join(came['refusals'])}" if came["refusals"] else estimated
        return f"{of['account']['collided']}", counted, estimate, f"{came['flights']:,}"

    heads = ("controller", "collided", "share of the campaign", "probability by splitting", "its flights")
    return table(heads, _rows(record, row))


def causes(record: Json) -> str:
    """Where the failing flights of the search for collisions lie."""

    def row(_: str, of: Json) -> Sequence[str]:
        regions = of["collisions"]["regions"]
        if not regions:
            return "–", "–", "no collision reached"
        first = regions[0]
        moved = ", ".join(f"{each['name']} {each['mean']:+.1f} σ" for each in first["moved"])
        return percent(first["share"], 0) + " %", f"{first['distance']:.1f} σ", moved

    heads = ("controller", "of the colliding flights", "nearest", "draws that moved most")
    return table(heads, _rows(record, row))


def channels(record: Json) -> str:
    """Failures among flights with a weak channel; collisions in which the braking channel is weak and restarts."""

    def row(_: str, of: Json) -> Sequence[str]:
        weak, braking = of["channels"]["weak"], of["channels"]["braking"]
        shown = [percent(each["count"] / each["n"]) if each["n"] else "–" for each in weak.values()]
        return *shown, f"{braking['collided']} of {braking['of']}"

    return table(("controller", *CHANNELS, "collisions with both"), _rows(record, row))


def drivers(record: Json) -> str:
    """The draws that explain most of the variance of Δv."""

    def row(_: str, of: Json) -> Sequence[str]:
        draws = of["drivers"]
        return (", ".join(f"{each['draw'].replace('|', chr(92) + '|')} {100 * each['value']:.0f} %" for each in draws) or "–",)

    return table(("controller", "share of the variance of Δv"), _rows(record, row))


TABLES: Mapping[str, Callable[[Json], str]] = {
    make.__name__: make for make in (search, outcomes, verdicts, cost, paired, kinds, channels, collisions, causes, drivers)
}
