"""A catalogue of mistakes that can be made in any shipped controller: each an edit of its source.

An edit finds its place in the syntax tree and changes the text there, so that all other lines stay.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

FOLDER = Path(__file__).parents[2] / "rvjax" / "components" / "controllers"
CONTROLLERS = tuple(path.stem for path in sorted(FOLDER.glob("*.py")) if path.stem not in ("__init__", "interface"))
LAW = ("respond", "update")


@dataclass(frozen=True)
class Planted:
    """name; edit of a source; words of the message; at: text in the line that the message names, "" for line 1; in: a function,
    whose first line the message names."""

    name: str
    edit: Callable[[str], str]
    words: tuple[str, ...]
    at: str = ""
    within: tuple[str, ...] = ()

    def line(self, source: str) -> int:
        """The line of the edited source that the message names."""
        if self.within:
            return place_of(source, *self.within).lineno
        return next(i for i, text in enumerate(source.splitlines(), start=1) if self.at in text)


def source_of(controller: str) -> str:
    """The source of a shipped controller."""
    return (FOLDER / f"{controller}.py").read_text()


def function(source: str, *names: str) -> ast.FunctionDef:
    """The function of one of these names, wherever it stands."""
    found = [node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.FunctionDef) and node.name in names]
    assert len(found) == 1, names
    return found[0]


def place_of(source: str, *names: str) -> ast.FunctionDef | ast.Lambda:
    """A function; where there is none of the name, the `lambda` that `build` gives instead."""
    tree = ast.parse(source)
    if any(isinstance(node, ast.FunctionDef) and node.name in names for node in ast.walk(tree)):
        return function(source, *names)
    return next(node for node in ast.walk(function(source, "build")) if isinstance(node, ast.Lambda))


def before(line: str) -> Callable[[str], str]:
    """A line at the beginning of the law, after its docstring."""

    def edit(source: str) -> str:
        body = function(source, *LAW).body
        first = body[1] if isinstance(body[0], ast.Expr) else body[0]
        lines = source.splitlines(keepends=True)
        lines.insert(first.lineno - 1, f"{' ' * first.col_offset}{line}\n")
        return "".join(lines)

    return edit


def returns(result: str, *names: str, first: str = "") -> Callable[[str], str]:
    """Another result of a function, made of `returned`, its own. first: a statement before that."""

    def edit(source: str) -> str:
        place = function(source, *(names or LAW)).body[-1]
        assert isinstance(place, ast.Return)
        assert place.value is not None
        assert place.end_lineno is not None
        value, space = ast.get_source_segment(source, place.value), " " * place.col_offset
        lines = source.splitlines(keepends=True)
        statements = [f"returned = {value}", *([first] if first else []), f"return {result}"]
        lines[place.lineno - 1 : place.end_lineno] = [f"{space}{text}\n" for text in statements]
        return "".join(lines)

    return edit


def by_form(continuous: str, discrete: str, first: str = "") -> Callable[[str], str]:
    """Another result of the law, of a continuous or a discrete-time controller."""
    return lambda source: returns(discrete if "def update(" in source else continuous, first=first)(source)


def command(text: str, first: str = "") -> Callable[[str], str]:
    """Another command. text: with `{}` for the right one."""
    return by_form(
        f"returned._replace(command={text.format('returned.command')})",
        f"({text.format('returned[0]')}, *returned[1:])",
        first,
    )


def state(text: str) -> Callable[[str], str]:
    """Another rate of the state, or another new state. text: with `{}` for the right one."""
    return by_form(
        f"returned._replace(rate={text.format('returned.rate')})",
        f"(returned[0], {text.format('returned[1]')}, returned[2])",
    )


def report(text: str) -> Callable[[str], str]:
    """Another report. text: with `{}` for the right one."""
    return by_form(
        f"returned._replace(report={text.format('returned.report')})",
        f"(*returned[:2], {text.format('returned[2]')})",
    )


def start_is_none(source: str) -> str:
    """No state, where `()` would be accepted."""
    if "lambda measurement, gains: ()" in source:
        return source.replace("lambda measurement, gains: ()", "lambda measurement, gains: None")
    return returns("None", "start")(source)


def declares(source: str) -> str:
    """A further signal, whose name is `declared`."""
    signals = '{**returned.signals, "declared": Column("declared", "1", "planted")}'
    return returns(f"returned._replace(signals={signals})", "build", first="from rvjax.columns import Column")(source)


def undeclared(source: str) -> str:
    """A signal that is not declared, beside all those that are."""
    given = '{{**{0}.signals, "declared": 1.0, "planted": 1.0}}'
    return report(f"{{0}}._replace(signals={given})")(declares(source))


def unused(source: str) -> str:
    """A gain that nothing uses."""
    gains = next(node for node in ast.parse(source).body if isinstance(node, ast.ClassDef) and node.name == "Gains")
    lines = source.splitlines(keepends=True)
    lines.insert(gains.body[0].lineno, '\n    planted: Quantity = scalar("1", default=1.0, doc="planted")\n')
    lines.insert(gains.lineno - 1, "from rvjax.campaign import Quantity, scalar\n")
    return "".join(lines)


def replaced(old: str, new: str) -> Callable[[str], str]:
    """Another text, which stands in every controller."""

    def edit(source: str) -> str:
        assert source.count(old) == 1
        return source.replace(old, new)

    return edit


def _line(name: str, line: str, *words: str) -> Planted:
    return Planted(name, before(line), words, at=line)


def _law(name: str, edit: Callable[[str], str], *words: str) -> Planted:
    return Planted(name, edit, words, within=LAW)


WHERE = "accepted: jnp.where(condition, a, b)"
IMPURE = ("two traces are different programs", "no chance, no clock, nothing kept")
COUNTER = "globals().__setitem__('KEPT', globals().get('KEPT', 0) + 1)"
END = "COMPONENT = Component(Parameters, build)\n"

PLANTED = (
    _line("raises", 'raise ValueError("not today")', "ValueError: not today"),
    _line("unknown name", "x = forec", "NameError: name 'forec' is not defined"),
    _line("python if", "if measurement.t > 3.0: pass", "a Python if", WHERE),
    _line("python and", "x = measurement.t > 3.0 and measurement.t < 5.0", "a Python if, while, and", WHERE),
    _line("float()", "x = float(measurement.motion.rho.x)", "float(), int() or another conversion of a number of the flight"),
    _line("range()", "x = range(measurement.t)", "a number of the flight as an index or a count"),
    _line("numpy", "import numpy; x = numpy.asarray(measurement.upper.force.x)",
          "NumPy on a number of the flight", "jax.numpy (jnp)"),
    _line("unknown measurement", "x = measurement.motionn", "there is no motionn here; did you mean motion?"),
    _line("unknown gain", "x = gains.mass_guess_g", "there is no mass_guess_g here; did you mean mass_guess_kg?"),
    _line("file", 'open("gains.txt")', "the code opens a file (gains.txt)", "accepted: numbers in the code or in the campaign"),
    _line("program", 'import subprocess; subprocess.run(["true"])', "the code starts a program"),
    _line("exit", "raise SystemExit(0)", "the file ends the program"),
    _law("returns none", returns("None"), "returns None", "accepted: "),
    _law("returns the command", by_form("returned.command", "returned[0]"), "returns a Channels", "accepted: "),
    _law("no channels", command("{0}.force"), "the command of", "is a Vector", "accepted: Channels(force, torque)"),
    _law("a number as torque", command("type({0})({0}.force, {0}.force.x)"),
         "the torque of the command of", "accepted: a Vector"),
    _law("components of odd shape", command("{} * np.ones(3)", "import numpy as np"),
         "the force of the command of", "x has the shape (3,)"),
    _law("complex", command("{} * 1j"), "the force of the command of", "has the type complex"),
    _law("state of another structure", state("({}, 1.0)"), "accepted: the structure of the state"),
    _law("no report", report("None"), "the report of", "is None", "accepted: Report(chi, drift, signals)"),
    _law("undeclared signal", undeclared, "the signal planted is not declared"),
    _law("missing signal", declares, "the declared signal declared is not given"),
    _law("signals are a list", report("{}._replace(signals=[])"), "the signals of", "are a list"),
    Planted("state is none", start_is_none, ("the state of", "is None"), within=("start",)),
    Planted("chance", command("{} * numpy.random.rand()", "import numpy"), IMPURE),
    Planted("counter", command("{} * KEPT", COUNTER), IMPURE),
    Planted("unused gain", unused, ("law.py does not use planted",), at="planted: Quantity"),
    Planted("nothing is built", returns("None", "build"), ("build returns None", "accepted: "), within=("build",)),
    Planted("import error", replaced("from rvjax.physics.state import", "from rvjax.physics.sate import"),
            ("No module named 'rvjax.physics.sate'",), at="physics.sate"),
    Planted("syntax error", before("x = (1 2)"), ("syntax error",), at="x = (1 2)"),
    Planted("no component", replaced(END, ""), ("there is no component in the file",)),
    Planted("NaN", command("{} * jax.numpy.sqrt(measurement.t - 60.0)", "import jax"),
            ("force.x is not finite at", "of 64 states")),
)  # fmt: skip
"""`NaN` is the only one that is computed, all others are traced."""
