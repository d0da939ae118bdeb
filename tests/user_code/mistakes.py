"""A catalogue of mistakes of users: each a change of a good file, with the place and the words of the message.

A change replaces a line of `LAW`; `@` in the place stands for the line that the change brings.
"""

from __future__ import annotations

from dataclasses import dataclass, field

LAW = '''"""PD on position and attitude."""
import jax
import jax.numpy as jnp
import numpy as np

from rvjax.components import Command, Controller, Parameters, Signal, scalar


class Gains(Parameters):
    """Gains."""

    kp: float = scalar("1/s²", default=0.01, above=0.0, doc="position stiffness")
    kd: float = scalar("1/s", default=0.2, above=0.0, doc="velocity damping")


def start(measured, gains):
    return jnp.zeros(3)


def respond(measured, integral, gains):
    force = -100.0 * (gains.kp * measured.rho + gains.kd * measured.nu)
    torque = -3.0 * measured.sigma - 15.0 * measured.omega
    return Command(force, torque, rate=measured.rho, signals={"integral": integral})


CONTROLLER = Controller(Gains, start, respond, {"integral": Signal("m·s", "integral of the position error")})
'''

FORCE = "    force = -100.0 * (gains.kp * measured.rho + gains.kd * measured.nu)\n"
RETURN = '    return Command(force, torque, rate=measured.rho, signals={"integral": integral})\n'
START = "    return jnp.zeros(3)\n"
END = 'CONTROLLER = Controller(Gains, start, respond, {"integral": Signal("m·s", "integral of the position error")})\n'
IMPORT = "import numpy as np\n"


@dataclass(frozen=True)
class Mistake:
    """name; old and new text of the law; words of the message; at: the text whose line the message names, "" for line 1, None for
    another place; use: what the campaign says; files: further files. alone, alone_at: words and
    place of `rvjax check-component` where they differ. right_alone: why this command finds the file right, "" where it names the
    mistake too."""

    name: str
    old: str
    new: str
    words: tuple[str, ...]
    at: str | None
    use: str = "./law.py"
    gains: str = ""
    files: dict[str, str] = field(default_factory=dict)
    alone: tuple[str, ...] = ()
    alone_at: str | None = None
    right_alone: str = ""


def _force(name: str, line: str, *words: str, at: str | None = None) -> Mistake:
    """A line before the force of the law."""
    return Mistake(name, FORCE, FORCE + f"    {line}\n", words, at if at is not None else line)


def _returns(name: str, what: str, *words: str, at: str = "def respond") -> Mistake:
    """Another result of the law."""
    return Mistake(name, RETURN, f"    return {what}\n", words, at)


WHERE = "jnp.where(condition, a, b)"

MISTAKES = (
    _force("raises", 'raise ValueError("not today")', "respond: ValueError: not today"),
    _force("unknown name", "force = forec", "NameError: name 'forec' is not defined"),
    _force("division of a text", 'force = "a" / 2', "TypeError: unsupported operand"),
    _force("python if", "if measured.rho[0] > 0: force = -force", "a Python if", WHERE, at="if measured.rho[0]"),
    _force("python while", "while measured.t < 3: pass", "a Python if, while", WHERE),
    _force("python and", "x = measured.t > 3 and measured.t < 5", "a Python if, while, and", WHERE),
    _force("float()", "force = force * float(measured.t)", "float(), int() or another conversion"),
    _force("int()", "n = int(measured.t)", "conversion of a number of the flight"),
    _force("range()", "for i in range(measured.t): pass", "a number of the flight as an index or a count"),
    _force("numpy on a traced number", "force = np.clip(force, -1, 1) * np.sin(measured.t)", "NumPy on a number of the flight", "jnp"),
    _force("index by a traced number", "x = [1, 2, 3][measured.t.astype(int)]", "as an index or a count"),
    _force("boolean index", "force = force[force > 0]", "indexing with a condition", WHERE),
    _force("in-place assignment", "force[0] = 0.0", "TypeError:", ".at["),
    _force("unknown measurement", "x = measured.rhoo", "there is no rhoo here; did you mean rho?"),
    _force("unknown gain", "x = gains.kq", "there is no kq here; accepted: kd, kp"),
    _force("shapes that do not fit", "force = force + jnp.ones(4)", "TypeError: add got incompatible shapes"),
    _force("file at trace time", 'open("gains.txt")', "the code opens a file (gains.txt)", "in the code or in the campaign"),
    _force("numpy file at trace time", 'np.loadtxt(__file__)', "the code opens a file"),
    _force("network at trace time", 'import socket; socket.create_connection(("127.0.0.1", 9), 1)', "the code uses the network"),
    _force("program at trace time", 'import subprocess; subprocess.run(["true"])', "the code starts a program"),
    _force("chance at trace time", "force = force * np.random.rand()", "two traces are different programs", at=""),
    _force("clock at trace time", "import time; force = force * time.perf_counter_ns()", "two traces are different programs", at=""),
    _force("endless recursion", "return respond(measured, integral, gains)", "RecursionError", at="force = -100"),
    _force("exit", "raise SystemExit(0)", "the file ends the program"),
    _returns("none", "None", "respond returns None", "accepted: Command(force=…, torque=…)"),
    _returns("a tuple", "force, torque", "respond returns a tuple"),
    _returns("wrong shape", "Command(force[:2], torque, measured.rho, {'integral': integral})", "the force of respond has the shape (2,)",
             "real numbers of shape (3,)"),
    _returns("a number as force", "Command(1.0, torque, measured.rho, {'integral': integral})", "the force of respond has the shape ()"),
    _returns("force is none", "Command(None, torque, measured.rho, {'integral': integral})", "the force of respond is None"),
    _returns("complex", "Command(force * 1j, torque, measured.rho, {'integral': integral})", "has the type complex"),
    _returns("boolean", "Command(force > 0, torque, measured.rho, {'integral': integral})", "has the type bool"),
    _returns("a text as torque", "Command(force, 'no', measured.rho, {'integral': integral})", "the torque of respond is a str"),
    _returns("rate of another shape", "Command(force, torque, measured.rho[:2], {'integral': integral})", "the rate of respond, entry 1",
             "has the shape (2,)"),
    _returns("rate of another structure", "Command(force, torque, (measured.rho, 1.0), {'integral': integral})", "the rate of respond is",
             "the structure of the state"),
    _returns("no rate", "Command(force, torque, signals={'integral': integral})", "the rate of respond is"),
    _returns("undeclared signal", "Command(force, torque, measured.rho, {'integral': integral, 'x': 1.0})", "the signal x is not declared"),
    _returns("missing signal", "Command(force, torque, measured.rho)", "the declared signal integral is not given"),
    _returns("signal of odd shape", "Command(force, torque, measured.rho, {'integral': integral[:2]})", "the signal integral has the shape (2,)"),
    _returns("signals are a list", "Command(force, torque, measured.rho, [integral])", "the signals of respond are a list"),
    Mistake("state is none", START, "    return None\n", ("the state of start is None",), "def start"),
    Mistake("state is a text", START, '    return "zero"\n', ("the state of start, entry 1 is a str",), "def start"),
    Mistake("too few arguments", "def respond(measured, integral, gains):", "def respond(measured, gains):",
            ("TypeError: respond() takes 2 positional arguments but 3 were given",), "def respond"),
    Mistake("dead gain", FORCE, FORCE.replace("gains.kd", "0.2"), ("law.py does not use kd", "something depends on"), None, alone_at="kd: float"),
    Mistake("gain out of range", "", "", ("controller.gains.kp: -1 1/s²", "above 0"), None, gains="{kp: -1}",
            right_alone="the campaign gives the value"),
    Mistake("gain that is not declared", "", "", ("unknown key", "accepted: kp, kd"), None, gains="{kq: 1}",
            right_alone="the campaign gives the key"),
    Mistake("syntax error", FORCE, "    force = (1\n", ("syntax error: '(' was never closed",), "force = (1"),
    Mistake("bad indentation", FORCE, " force = 1\n", ("syntax error",), "torque = -3.0"),
    Mistake("import error", IMPORT, "import numpyy as np\n", ("ModuleNotFoundError: No module named 'numpyy'",), "import numpyy"),
    Mistake("import of a missing name", IMPORT, "from numpy import nothing\n", ("ImportError: cannot import name 'nothing'",), "from numpy"),
    Mistake("error in a helper", IMPORT, "import numpy as np\nfrom helper import gain\n", ("ZeroDivisionError",), None,
            files={"helper.py": "gain = 1 / 0\n"}),
    Mistake("syntax error in a helper", IMPORT, "import numpy as np\nimport helper\n", ("syntax error",), None, files={"helper.py": "x = = 1\n"}),
    Mistake("cyclic import", IMPORT, "import numpy as np\nfrom helper import gain\n", ("ImportError: cannot import name 'FACTOR'",), None,
            files={"helper.py": "from law import FACTOR\ngain = 2 * FACTOR\n"}),
    Mistake("import by a call", IMPORT, "import importlib, sys\nimport numpy as np\nimportlib.import_module('helper')\n",
            ("No module named 'helper'",), "importlib.import_module", files={"helper.py": "gain = 2\n"}),
    Mistake("no controller", END, "", ("no component of controllers", "CONTROLLER = Controller(Gains, start, respond)"), "",
            alone=("there is no component in the file", "`rvjax init --controller FILE` writes")),
    Mistake("two controllers", END, END + "OTHER = Controller(Gains, start, respond)\n",
            ("2 components of controllers", "law.py:CONTROLLER or law.py:OTHER"), "", right_alone="both are checked"),
    Mistake("another family", END, "from rvjax.components import Saturation\nS = Saturation(lambda command, upper, lower: command)\n",
            ("no component of controllers (S is one of saturations)",), "", right_alone="any family is accepted"),
    Mistake("object that is no controller", "", "", ("start is a function, not of controllers", "accepted: CONTROLLER"), "", use="./law.py:start",
            alone=("start is a function, not a component", "accepted: CONTROLLER")),
    Mistake("object that is not there", "", "", ("there is no Nothing", "accepted: CONTROLLER"), "", use="./law.py:Nothing"),
    Mistake("file that is not there", "", "", ("nolaw.py cannot be read: No such file",), None, use="./nolaw.py"),
    Mistake("file outside", "", "", ("which is not a plain relative path",), None, use="../law.py", right_alone="any folder is accepted"),
    Mistake("no suffix", "", "", ("does not end in .py",), None, use="./law"),
    Mistake("unknown component", "", "", ("'pid' is not known here", "or ./FILE.py with a controller, such as `rvjax init --controller FILE.py` writes"), None, use="pid",
            right_alone="the name of a shipped component is no file"),
    Mistake("gains that are no model", END, END.replace("Controller(Gains,", "Controller(dict(kp=1),"),
            ("TypeError: Controller: found {'kp': 1} as its parameters",), "CONTROLLER ="),
    Mistake("no respond", END, END.replace("start, respond", "start, None"), ("TypeError: Controller: respond is missing",), "CONTROLLER ="),
    Mistake("unit that disagrees", "    kp: float = scalar(\"1/s²\"", "    kp_deg: float = scalar(\"1/s²\"", ("name, key and unit disagree",),
            "class Gains"),
    Mistake("counter outside", FORCE, FORCE + "    global KEPT\n    KEPT = 1 + (KEPT if 'KEPT' in globals() else 0)\n    force = force * KEPT\n",
            ("two traces are different programs", "nothing kept"), ""),
)  # fmt: skip
