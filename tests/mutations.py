"""Case files that are nearly right: cases with a few mistakes in them.

Of the built-in cases, a small one, and those that hold every key there is.
"""

import copy
import io
import math

from every_leaf import MAIN, SOLIDS, STATE, TAKEN
from hypothesis import strategies as st
from ruamel.yaml import YAML
from small_case import small_case

from drakesep.case_file.reader import builtin_cases


TEXTS = {name: file.read_text() for name, file in builtin_cases().items()}
TEXTS |= {"main": MAIN, "solids": SOLIDS, "state": STATE, "taken": TAKEN}
CASES = {name: YAML(typ="safe", pure=True).load(text) for name, text in TEXTS.items()}
CASES |= {"small": small_case()}
NUMBERS = (
    *(0, -0.0, 1, -1, 1e-6, 1e6, 5e-324, 1e-300, 1e16, 1e308, 10**400, -(10**20)),
    *(math.nan, math.inf, -math.inf, math.pi, 90.0, 180.0, 360.0),
)
OTHERS = (
    *(True, False, None, "", "x", "M", "1e3", "vega", "no such.stl", "à\u0301\u202e"),
    *([], {}, [0, 0, 0], [1, 2], [[1]], {"x": 1}, {1: 2}, ["a"] * 3, [math.nan] * 3),
)
FACTORS = st.floats(-12, 12).map(lambda power: 10.0**power)


def places(data, within=()):
    """Each mapping or list with each of its keys: where something can be changed."""
    pairs = data.items() if isinstance(data, dict) else enumerate(data)
    for key, value in list(pairs):
        yield data, key
        if isinstance(value, dict | list):
            yield from places(value)


def _drawn_place(draw, data):
    found = list(places(data))
    return found[draw(st.integers(0, len(found) - 1))] if found else None


def _replace(draw, data, parent, key):
    parent[key] = copy.deepcopy(draw(st.sampled_from((*NUMBERS, *OTHERS))))


def _scale(draw, data, parent, key):
    """A number, or each of several: what a wrong unit does."""

    def scaled(value):
        if isinstance(value, list):
            return [scaled(entry) for entry in value]
        number = isinstance(value, int | float) and not isinstance(value, bool)
        return value * factor if number and abs(value) < 1e300 else value

    factor = draw(FACTORS) * draw(st.sampled_from((1.0, -1.0)))
    parent[key] = scaled(parent[key])


def _remove(draw, data, parent, key):
    del parent[key]


def _swap(draw, data, parent, key):
    other, other_key = _drawn_place(draw, data)
    mine, theirs = copy.deepcopy(parent[key]), copy.deepcopy(other[other_key])
    parent[key], other[other_key] = theirs, mine


def _graft(draw, data, parent, key):
    """What another case has at such a key, or anywhere."""
    source = CASES[draw(st.sampled_from(sorted(CASES)))]
    alike = [(p, k) for p, k in places(source) if k == key] or list(places(source))
    other, other_key = alike[draw(st.integers(0, len(alike) - 1))]
    parent[key] = copy.deepcopy(other[other_key])


def _repeat(draw, data, parent, key):
    """An entry once more, under another name in a mapping."""
    value = copy.deepcopy(parent[key])
    if isinstance(parent, list):
        parent.insert(key, value)
    else:
        parent[draw(st.sampled_from((f"{key}_2", "x", 1, "")))] = value


def _rename(draw, data, parent, key):
    if isinstance(parent, dict):
        names = (f"{key}x", str(key).upper(), 1, 1.5, True, "", "a.b", "..", "x/y")
        parent[draw(st.sampled_from(names))] = parent.pop(key)


@st.composite
def mutated(draw):
    """A case with one to four mistakes, as data."""
    data = copy.deepcopy(CASES[draw(st.sampled_from(sorted(CASES)))])
    mistakes = (_replace, _scale, _scale, _remove, _swap, _graft, _repeat, _rename)
    for _ in range(draw(st.integers(1, 4))):
        place = _drawn_place(draw, data)
        if place is not None:
            draw(st.sampled_from(mistakes))(draw, data, *place)
    return data


def as_text(data) -> str:
    """YAML of it."""
    stream = io.StringIO()
    yaml = YAML(typ="safe")
    yaml.allow_unicode = True
    yaml.dump(data, stream)
    return stream.getvalue()


@st.composite
def mangled(draw):
    """Text of a case, a few lines of which are cut, repeated or overwritten."""
    lines = TEXTS[draw(st.sampled_from(sorted(TEXTS)))].splitlines()
    for _ in range(draw(st.integers(1, 4))):
        i = draw(st.integers(0, len(lines) - 1))
        line = lines[i]
        j = draw(st.integers(0, len(line)))
        scrap = draw(st.sampled_from(SCRAPS) | st.text(max_size=3))
        lines[i : i + 1] = draw(
            st.sampled_from(
                (
                    [],
                    [line, line],
                    [line[:j]],
                    [line[:j] + scrap + line[j:]],
                    [" " * j + line],
                    [line.lstrip()],
                )
            )
        )
        if not lines:
            break
    return "\n".join(lines)


SCRAPS = ("&a ", "*a", "*joint", "<<: ", "!!str ", "- ", "? ", ": ", "{", "}", "[", "'")
SCRAPS += ('"', "#", "|", ">", "%", "@", "\t", "---\n", "\x00", "\ufeff", "1e999", "0x")
