"""What every form of a component checks when it is made."""

from __future__ import annotations

from typing import Any

from rvjax.campaign import Model


def check_form(form: Any, functions: tuple[str, ...], maybe: tuple[str, ...], model: Any) -> None:
    """TypeError where a form does not have what it needs."""
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
