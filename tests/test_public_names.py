"""Every public name has a docstring that names its arguments."""

import importlib
import inspect

import pytest


PACKAGES = ("drakesep", "drakesep.systems", "drakesep.analysis")


def public():
    for package in PACKAGES:
        module = importlib.import_module(package)
        for name in module.__all__:
            yield pytest.param(getattr(module, name), id=f"{package}.{name}")


def functions(thing):
    if inspect.isfunction(thing):
        yield thing
    elif inspect.isclass(thing):
        for name, member in vars(thing).items():
            if inspect.isfunction(member) and not name.startswith("_"):
                yield member


@pytest.mark.parametrize("thing", list(public()))
def test_docstrings(thing):
    if not (inspect.isclass(thing) or inspect.isfunction(thing)):
        return  # a table of objectives, a type
    assert inspect.getdoc(thing)
    if thing.__module__.startswith("drakesep.case_file.case"):
        return  # fields of the schema are named by the case file
    for function in functions(thing):
        doc = inspect.getdoc(function) or ""
        assert doc, function.__qualname__
        arguments = [
            name for name in inspect.signature(function).parameters if name != "self"
        ]
        if len(arguments) > 1 and inspect.isfunction(thing):
            for name in arguments:
                assert f"{name}:" in doc, f"{function.__qualname__}: {name}"


@pytest.mark.parametrize(
    ("package", "former", "new"),
    [
        ("drakesep.systems", "Element", "Part"),
        ("drakesep.systems", "SeparationElements", "SeparationForces"),
        ("drakesep.analysis", "Box", "ToleranceBox"),
        ("drakesep.analysis", "Fleet", "DrakePool"),
    ],
)
def test_former_names_still_work(package, former, new):
    module = importlib.import_module(package)
    with pytest.warns(DeprecationWarning, match=f"{former} is called {new} now"):
        assert getattr(module, former) is getattr(module, new)
    assert former not in module.__all__
