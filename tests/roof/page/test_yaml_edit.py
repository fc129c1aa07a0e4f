"""YAML text changed in one place: its data are as they should be, all else stays."""

import copy
import difflib

import pytest

from drakesep.case_file.reader import builtin_cases
from drakesep.case_file.yaml_text import read_yaml
from drakesep.page.yaml_edit import YamlText, in_one_line, typed_in
from drakesep.systems.checks import InputError


TEXT = """\
# Of a case.
name: a  # the name
bodies:
  one:  # the first
    mass: &m 1.0e+3
    cg: [1, 2, 3]  # mm
    inner: {x: 1, y: {z: 2}}

  two:
    mass: *m
    cg:
      - 4
      - 5  # last
empty: {}
limits:
- quantity: q
  at_most: 1
- {quantity: r, at_least: 2}

text: |
  some
  lines
last: 3"""


def changed_lines(before, after):
    told = difflib.ndiff(before.splitlines(), after.splitlines())
    return [line for line in told if line[:2] in ("- ", "+ ")]


def put(data, path, value):
    data = copy.deepcopy(data)
    *above, last = path
    inner = data
    for key in above:
        inner = inner[key] if isinstance(inner, list) else inner.setdefault(key, {})
    if isinstance(inner, list) and last == len(inner):
        inner.append(value)
    else:
        inner[last] = value
    return data


@pytest.mark.parametrize(
    ("path", "value", "lines"),
    [
        (("name",), "'b: c'", 2),
        (("bodies", "one", "cg", 1), "7.5", 2),
        (("bodies", "one", "cg"), "[9, 9]", 2),
        (("bodies", "one", "inner", "y", "z"), "8", 2),
        (("bodies", "one", "inner", "w"), "8", 2),
        (("bodies", "two", "cg", 1), "6", 2),
        (("bodies", "two", "cg"), "[9, 9]", 4),
        (("bodies", "two", "cg", 2), "6", 1),
        (("bodies", "two", "new"), "5 %", 1),
        (("bodies", "three", "mass"), "1", 2),
        (("bodies", "three", "cg", "x"), "1", 3),
        (("empty", "a", "b"), "1", 2),
        (("limits", 0, "at_most"), "[1, null]", 2),
        (("limits", 0, "at_least"), "3", 1),
        (("limits", 1, "at_least"), "3", 2),
        (("limits", 2), "{quantity: s}", 1),
        (("last",), "4", 2),
        (("text",), "short", 4),
        (("new",), "1", 2),
        (("new", "deep", "er"), "1", 4),
    ],
)
def test_a_value_is_changed_or_added(path, value, lines):
    before = YamlText(TEXT)
    after = before.with_value(path, value)
    assert read_yaml(after) == put(before.data, path, read_yaml(value))
    assert len(changed_lines(TEXT, after)) <= lines + (path[0] in ("new", "last"))


def without(data, path):
    data = copy.deepcopy(data)
    inner = data
    for key in path[:-1]:
        inner = inner[key]
    del inner[path[-1]]
    return data


@pytest.mark.parametrize(
    "path",
    [
        ("name",),
        ("bodies", "one", "cg", 0),
        ("bodies", "one", "cg", 2),
        ("bodies", "one", "cg"),
        ("bodies", "one", "inner", "x"),
        ("bodies", "one", "inner", "y"),
        ("bodies", "two", "cg", 0),
        ("bodies", "two"),
        ("limits", 0),
        ("limits", 1),
        ("limits", 0, "quantity"),
        ("limits", 0, "at_most"),
        ("limits", 1, "quantity"),
        ("text",),
        ("last",),
        ("empty",),
    ],
)
def test_an_entry_is_removed(path):
    before = YamlText(TEXT)
    after = before.without(path)
    assert read_yaml(after) == without(before.data, path)
    assert not [x for x in changed_lines(TEXT, after) if x[0] == "+" and "#" in x][1:]


def test_a_mapping_goes_with_its_last_entry():
    text = "a:\n  b:\n    c: 1\nd: 2\n"
    assert read_yaml(YamlText(text).without(("a", "b", "c"))) == {"d": 2}


def leaves(data, path=()):
    if isinstance(data, dict | list):
        entries = data.items() if isinstance(data, dict) else enumerate(data)
        for key, value in entries:
            yield from leaves(value, (*path, key))
    else:
        yield path


@pytest.mark.parametrize("name", ["vega", "dual_launch"])
def test_any_number_of_a_built_in_case_is_changed_in_its_line_alone(name):
    text = builtin_cases()[name].read_text(encoding="utf-8")
    yaml = YamlText(text)
    for path in [*leaves(yaml.data)][::11]:
        if not yaml.shown(path) or not yaml._node(path):  # merged from elsewhere
            continue
        after = yaml.with_value(path, "12345.5")
        [old, new] = [x for x in changed_lines(text, after) if x]
        assert old[0] == "-" and new[0] == "+"
        assert "12345.5" in new
        found = read_yaml(after)
        for key in path:
            found = found[key]
        assert found == 12345.5


def test_what_is_merged_from_elsewhere_is_shown_and_not_lost():
    text = "a: &a {j: {k: 1, d: 2}, p: 1}\nb: {<<: *a}\n"
    yaml = YamlText(text)
    assert yaml.shown(("b", "p")) == "1"
    after = read_yaml(yaml.with_value(("b", "p"), "5"))
    assert after["b"] == {"j": {"k": 1, "d": 2}, "p": 5}
    with pytest.raises(InputError, match="merged from elsewhere"):
        yaml.with_value(("b", "j", "k"), "5")


def test_what_others_refer_to_is_not_replaced():
    with pytest.raises(InputError, match="anchor"):
        YamlText("a: &a {b: 1}\nc: *a\n").with_value(("a",), "3")


@pytest.mark.parametrize(
    ("typed", "value"),
    [
        (" 1e-6 ", 1e-6),
        ("1.0e+7", 1e7),
        ("5 %", "5 %"),
        ("a: b", {"a": "b"}),
        ("[1, null]", [1, None]),
        ("a # b", "a"),
        ("x, y", "x, y"),
        ("'12'", "12"),
        ("never", "never"),
        ("1: 2: 3", None),
        ("{", None),
        ("", None),
        ("# nothing", None),
    ],
)
def test_what_is_typed_is_yaml_that_can_stand_anywhere(typed, value):
    if value is None:
        with pytest.raises(InputError):
            typed_in(typed)
        return
    text = typed_in(typed)
    assert read_yaml(f"{{k: {text}, l: [{text}]}}") == {"k": value, "l": [value]}
    assert "\n" not in text


def test_a_number_stays_as_it_was_typed():
    assert typed_in("1.50e3") == "1.50e3"
    assert in_one_line({"b": 1, "a": "x"}) == "{b: 1, a: x}"


@pytest.mark.parametrize("path", [("b",), ("a", 3), ("c", "d"), ("e", "g")])
def test_what_is_not_there_cannot_be_taken_out(path):
    """Nor is what stands alone beside it."""
    with pytest.raises(InputError, match="is not there"):
        YamlText("a: [1, 2]\nc: {}\ne: {f: 1}\n").without(path)
