"""A name means either a submodule or a function or class of its package, never both."""

from __future__ import annotations

import importlib
import inspect
import pkgutil

import pytest

import rvjax

PACKAGES = [
    "rvjax",
    *(module.name for module in pkgutil.walk_packages(rvjax.__path__, "rvjax.") if module.ispkg),
]


@pytest.mark.parametrize("name", PACKAGES)
def test_no_export_has_the_name_of_a_submodule(name: str) -> None:
    """Importing the submodule would replace the function or class of this name, depending on the order of imports."""
    package = importlib.import_module(name)
    submodules = {module.name for module in pkgutil.iter_modules(package.__path__)}
    listed = submodules.intersection(getattr(package, "__all__", ()))
    defined = {key for key, value in vars(package).items() if inspect.isroutine(value) or inspect.isclass(value)}
    assert not listed | submodules & defined
