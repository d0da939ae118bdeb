"""The pages of --help: as wide as the terminal, no summary cut, in characters that the terminal has."""

from __future__ import annotations

import shutil
import sys
from typing import Any

from typer.core import TyperCommand, TyperGroup

from rvjax.cli._streams import printable

NARROW = 66
"""Below this width a meaning stands under its option, not next to it, unless all names are short."""

SHORT = 12

_WIDEST = 80
_UNCUT = 1000


def _page(command: Any, ctx: Any) -> str:
    """The help of a command. Typer assumes 50 columns at least, and UTF-8 where a terminal has ASCII."""
    formatter = ctx.make_formatter()
    formatter.width = max(min(shutil.get_terminal_size().columns, _WIDEST) - 2, 20)
    if formatter.width < NARROW:
        beside = formatter.write_dl

        def below(rows: Any, *widths: int, **more: int) -> None:
            if all(len(name) <= SHORT for name, _ in rows):
                beside(rows, *widths, **more)
                return
            for name, meaning in rows:
                formatter.write_text(name)
                formatter.indent()
                formatter.indent()
                formatter.write_text(meaning)
                formatter.dedent()
                formatter.dedent()

        formatter.write_dl = below
    command.format_help(ctx, formatter)
    return printable(formatter.getvalue().rstrip("\n"), sys.stdout)


class Command(TyperCommand):
    """A command with such a page."""

    def get_help(self, ctx: Any) -> str:
        return _page(self, ctx)


class Group(TyperGroup):
    """The program with such a page, which lists the commands."""

    def get_help(self, ctx: Any) -> str:
        return _page(self, ctx)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """The whole first sentence of each command."""
        commands = [(name, self.get_command(ctx, name)) for name in self.list_commands(ctx)]
        with formatter.section("Commands"):
            formatter.write_dl([(name, command.get_short_help_str(_UNCUT)) for name, command in commands if command is not None])
