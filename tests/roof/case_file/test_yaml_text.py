"""Text that stands for too much is refused before anything is made of it."""

import io

import pytest
from hypothesis import given
from hypothesis import strategies as st
from ruamel.yaml import YAML

from drakesep.case_file.reader import builtin_cases, load_case
from drakesep.case_file.yaml_text import read_yaml
from drakesep.systems.checks import InputError


def bomb(levels, row):
    """Lines of which each names the one before nine times; below 1 kB."""
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x]"]
    for i in range(1, levels):
        nine = ", ".join([f"*a{i - 1}"] * 9)
        lines.append(f"a{i}: &a{i} {row.format(nine)}")
    return "\n".join(lines)


LISTS = bomb(10, "[{}]")
MAPPINGS = bomb(10, "{{<<: [{}]}}").replace("[x, x, x, x, x, x, x, x, x]", "{x: 1}", 1)
BAD = {
    "aliases": (LISTS, "aliases must stand for at most 100000 entries"),
    "merge keys": (MAPPINGS, "aliases must stand for at most 100000 entries"),
    "a list in itself": ("x: &x [*x]", "*x in line 1 must not stand within what it"),
    "a mapping in itself": ("a: 1\nx: &x {y: {z: *x}}", "*x in line 2 must not stand"),
    "merged with itself": ("x: &x {<<: *x}", "*x in line 1 must not stand within"),
    "lists in lists": ("a: " + "[" * 10_000, "must be nested at most 50 levels deep"),
    "closed": ("[" * 300 + "]" * 300, "must be nested at most 50 levels deep"),
    "blocks": ("- " * 3000 + "x", "must be nested at most 50 levels deep"),
    "mappings": ("{a: " * 3000, "must be nested at most 50 levels deep"),
    "a name of two": (
        "a: &x 1\nb: &x 2",
        "&x must name one thing, got it in lines 1 and",
    ),
    "an unknown name": ("a: *b", "must be YAML, got: found undefined alias"),
    "digits": ("a: " + "9" * 5000, "must be YAML, got: Exceeds the limit"),
    "no boolean": ("a: !!bool x", "must be YAML, got: 'x'"),
    "no number": ("a: !!float x", "must be YAML, got: could not convert"),
    "a program": ("a: !!python/object:os.system x", "must be YAML, got: could not"),
    "a zero": ("a: \x00", "must be YAML, got: "),
    "two documents": (
        "a: 1\n---\nb: 1",
        "must be YAML, got: but found another",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_refused_at_once_in_one_line(name, tmp_path):
    text, message = BAD[name]
    assert name not in ("aliases", "merge keys") or len(text) < 1000
    file = tmp_path / "case.yaml"
    file.write_text(text)
    with pytest.raises(InputError) as refused:
        load_case(file)
    assert str(refused.value).startswith(f"{file}: {message}")
    assert len(str(refused.value).splitlines()) == 1


def test_a_bomb_that_is_no_bomb():
    """9 + 81 + 729 entries: three levels are what they say."""
    data = read_yaml(bomb(3, "[{}]"))
    assert data["a2"] == [[["x"] * 9] * 9] * 9


def test_a_file_that_never_ends(tmp_path):
    with pytest.raises(InputError, match=r"/dev/zero: .* got: more than 10 MB"):
        load_case("/dev/zero")


@pytest.mark.parametrize("name", builtin_cases())
def test_built_in_cases_are_read_as_by_the_library(name):
    text = builtin_cases()[name].read_text()
    assert read_yaml(text) == YAML(typ="safe", pure=True).load(text)


@given(
    st.recursive(
        st.none() | st.booleans() | st.integers() | st.text("abc", max_size=5),
        lambda inner: (
            st.lists(inner, max_size=4)
            | st.dictionaries(st.text("ab", max_size=3), inner, max_size=4)
        ),
        max_leaves=20,
    )
)
def test_data_go_through(data):
    text = io.StringIO()
    YAML(typ="safe", pure=True).dump(data, text)
    assert read_yaml(text.getvalue()) == YAML(typ="safe", pure=True).load(
        text.getvalue()
    )


@given(st.text("[]{}&*a<:-,!?|>'\"%@ \n1.", max_size=40))
def test_any_text_is_data_or_bad_input(text):
    try:
        read_yaml(text)
    except InputError as error:
        assert len(str(error).splitlines()) <= 1


def test_times_are_text():
    """Their decimals stay, however many; what is no time is told where it is read."""
    text = "a: 2026-03-01T12:00:00.123456789012\nb: 2020-13-45"
    epoch = "2026-03-01T12:00:00.123456789012"
    assert read_yaml(text) == {"a": epoch, "b": "2020-13-45"}
