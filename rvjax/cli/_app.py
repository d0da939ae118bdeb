"""Commands, shared options and exit codes. Nothing heavy is imported before a command runs, so that --help is quick."""

from __future__ import annotations

import os
import signal
import sys
import threading
import traceback
import warnings
from collections.abc import Sequence
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any, Literal, NoReturn

import typer

import rvjax
from rvjax.cli import _completion, _help, _streams
from rvjax.cli._output import Output, say
from rvjax.errors import CampaignError, Finding, IncompleteError, RvjaxError
from rvjax.places import place_of

COMMANDS = (
    *("init", "check-component", "validate", "run", "check", "report", "view", "compare", "drivers", "sensitivity", "reweigh"),
    *("tune", "worst", "rare", "replay", "export", "plan", "list", "explain", "schema", "bench", "doctor"),
)
"""The commands in the order of `rvjax --help`: each is the function `command` of `rvjax.cli.<name>`, with _ for -."""

Json = Annotated[bool, typer.Option("--json", help="One JSON document on stdout, everything else on stderr.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress and no hints.")]
Sets = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="PATH=VALUE", help="Replace a campaign value; repeatable.", autocompletion=_completion.settings
    ),
]
Samples = Annotated[int | None, typer.Option("--samples", min=1, help="Number of samples; replaces the campaign's.")]
Seed = Annotated[int | None, typer.Option("--seed", min=0, help="Seed; replaces the campaign's.")]
Engine = Annotated[
    Literal["auto", "llvm", "xla"] | None, typer.Option("--engine", help="What compiles the flights; replaces the campaign's.")
]
Campaign = Annotated[Path, typer.Argument(metavar="FILE", help="A campaign file.", autocompletion=_completion.campaigns)]
Folder = Annotated[
    Path,
    typer.Argument(
        metavar="DIR", help="A run folder, also s3://bucket/prefix.", autocompletion=_completion.run_folders, parser=place_of
    ),
]
Dask = Annotated[
    str | None, typer.Option("--dask", metavar="WHERE", help="Fly on Dask workers: tcp://scheduler:8786, or local:N processes.")
]
Out = Annotated[
    Path | None,
    typer.Option(
        "--out",
        metavar="DIR",
        help="The run folder, also s3://bucket/prefix; default reports/<name>/<identity>.",
        parser=place_of,
    ),
]
TimingsOption = Annotated[bool, typer.Option("--timings", help="Print where the time went; also in summary.json.")]

JunitXml = Annotated[Path | None, typer.Option("--junit-xml", metavar="PATH", help="Also write the verdicts as JUnit XML.")]


@cache
def program() -> typer.Typer:
    """The command line with every command."""
    app = typer.Typer(
        cls=_help.Group,
        no_args_is_help=True,
        rich_markup_mode=None,
        pretty_exceptions_enable=False,
        context_settings={"help_option_names": ["-h", "--help"]},
        help="Batched Monte-Carlo robustness analysis of spacecraft rendezvous.",
        epilog="Exit codes: 0 done, every requirement passes; 1 a requirement failed; 2 the command or the campaign is wrong; "
        "3 undecided; 4 incomplete; 5 a run folder is damaged or belongs to another run; 130, 143 interrupted; "
        "141 the reader of the output closed the pipe.",
    )
    app.callback()(_options)
    for name in COMMANDS:
        app.command(name, cls=_help.Command)(import_module(f"rvjax.cli.{name.replace('-', '_')}").command)
    return app


class Terminated(BaseException):
    """The process received SIGTERM."""


def main() -> NoReturn:
    """Runs the program and exits with its code; a user's mistake ends in a message, never in a traceback."""
    signal.signal(signal.SIGTERM, _terminate)
    _streams.prepare()
    sys.unraisablehook = _send_again
    warnings.showwarning = _warn
    try:
        code = program()(standalone_mode=False, prog_name="rvjax")
    except RvjaxError as error:
        code = _report(error)
    except (typer.Abort, KeyboardInterrupt, Terminated) as stop:
        code = 143 if isinstance(stop, Terminated) else 130
        _tell_github(code, reason(stop))
    except SystemExit as ended:  # typer ends with 1, the code of a failed requirement, where it meets a closed pipe
        lost = ended.__context__
        code = _unexpected(lost) if isinstance(lost, OSError) else ended.code
    except Exception as error:  # noqa: BLE001
        code = _unexpected(error)
    code = 2 if code == 1 and sys.argv[1].endswith("-completion") else code  # typer ends with 1 in an unknown shell
    sys.exit(_streams.exit_code(code if isinstance(code, int) else 0))


def _terminate(number: int, frame: Any) -> NoReturn:
    raise Terminated


def _send_again(lost: sys.UnraisableHookArgs) -> None:
    """A stop signal inside a callback is lost by Python: sends it again a moment later."""
    number = {KeyboardInterrupt: signal.SIGINT, Terminated: signal.SIGTERM}.get(lost.exc_type)
    if number is None:
        sys.__unraisablehook__(lost)
    else:
        timer = threading.Timer(0.05, os.kill, (os.getpid(), number))
        timer.daemon = True
        timer.start()


def _warn(message: Warning | str, *origin: Any) -> None:
    """A warning as a single line, without its place in the code."""
    del origin
    say(f"rvjax: {message}", sys.stderr)


def _report(error: RvjaxError) -> int:
    say(str(error), sys.stderr)
    _tell_github(error.exit_code, str(error), error.findings if isinstance(error, CampaignError) else ())
    if "--json" in sys.argv:
        findings = [vars(finding) for finding in error.findings] if isinstance(error, CampaignError) else []
        document = {"error": str(error), "findings": findings, "exit_code": error.exit_code}
        if isinstance(error, IncompleteError) and error.stopped:
            document |= {"stopped": error.stopped, "go_on_with": error.go_on_with}
        Output(as_json=True).document(document)
    return error.exit_code


def reason(error: BaseException) -> str:
    """Why a command ended, in words."""
    if isinstance(error, RvjaxError):
        return str(error)
    if isinstance(error, (KeyboardInterrupt, typer.Abort, Terminated)):
        return f"stopped by {'SIGTERM' if isinstance(error, Terminated) else 'SIGINT'} before its end"
    return f"internal error (a bug in rvjax): {type(error).__name__}: {error}"


def _tell_github(code: int, text: str, findings: Sequence[Finding] = ()) -> None:
    """Annotations and a job summary of what ended the command; nothing outside of GitHub Actions."""
    if os.environ.get("GITHUB_ACTIONS") != "true":
        return
    from rvjax.report.ci import github

    output = Output(as_json="--json" in sys.argv)
    output.annotate(github.of_findings(findings) if findings else [github.of_error(text)])
    try:
        github.append_summary(github.summary_of_error(["rvjax", *sys.argv[1:]], code, text))
    except OSError as problem:
        output.note(f"no job summary: {problem}")


def _unexpected(error: Exception) -> int:
    """2 for a wrong command line, whose exceptions format their message; 4, never a verdict's code, for a bug."""
    message = getattr(error, "format_message", None)
    if message is not None:
        say(f"rvjax: {message()}\nTry `rvjax --help`.", sys.stderr)
        _tell_github(2, str(message()))
        return 2
    _tell_github(4, reason(error))
    traceback.print_exception(error)
    say("rvjax: internal error (a bug in rvjax); please report it", sys.stderr)
    return 4


def _version(wanted: bool) -> None:
    if wanted:
        print(f"rvjax {rvjax.__version__}")
        raise typer.Exit


def _options(
    version: Annotated[bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")] = False,
) -> None:
    """Options without a command."""


def overrides(
    sets: list[str] | None, samples: int | None = None, seed: int | None = None, engine: str | None = None
) -> list[str]:
    """--samples, --seed and --engine as --set."""
    given = {"samples": samples, "seed": seed, "engine": engine}
    return [*(sets or ()), *(f"{name}={value}" for name, value in given.items() if value is not None)]
