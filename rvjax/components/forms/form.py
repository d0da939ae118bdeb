"""What every form of a component notes and checks when it is made."""

from __future__ import annotations

import inspect
import sys
from types import FrameType
from typing import Any

from rvjax.campaign import Model


def note_origin(component: Any) -> None:
    """Sets `made_in` of a component object: (file, module) of the code outside of all functions that has led to it."""
    frame: FrameType | None = sys._getframe(1)
    while frame is not None and frame.f_code.co_flags & inspect.CO_NEWLOCALS:
        frame = frame.f_back
    if frame is not None:
        object.__setattr__(component, "made_in", (frame.f_code.co_filename, str(frame.f_globals.get("__name__", ""))))


def check_form(form: Any, functions: tuple[str, ...], maybe: tuple[str, ...], model: Any) -> None:
    """TypeError where a form does not have what it needs."""
    note_origin(form)
    kind = type(form).__name__
    if not (isinstance(model, type) and issubclass(model, Model)):
        raise TypeError(f"{kind}: found {model!r} as its parameters; accepted: a class that inherits from Parameters")
    for name in (*functions, *maybe):
        given = getattr(form, name)
        if not callable(given) and not (given is None and name in maybe):
            found = "missing" if given is None else f"found {given!r}"
            raise TypeError(f"{kind}: {name} is {found}; accepted: a function")


def check_memory(form: Any) -> None:
    """TypeError where a form has only one of the two functions of a memory."""
    if (form.start is None) != (form.keep is None):
        raise TypeError(f"{type(form).__name__}: a memory needs both start and keep; accepted: both or neither")
