"""Where values come from: lines of a case file, and the comments that tell of them."""

import pytest

from drakesep.case_file.case import Case
from drakesep.case_file.yaml_text import read_yaml
from drakesep.reports.origins import CaseText


TEXT = """\
# The file as a whole.
name: mine
pair: {A: stage, B: satellite}
bodies:
  stage:
    # Weighed.
    mass_kg: 900
    cg_mm: [-1000, 0, 0]

    inertia_kg_m2: {xx: 300, yy: 400, zz: 400}  # of the drawing
  satellite:  # the data sheet
    mass_kg: 400
    cg_mm: [700, 0, 0]
    inertia_kg_m2: {xx: 120, yy: 150, zz: 140}
attachments:
  ring: &ring
    A: stage
    B: satellite
    position_mm: [0, 0, 0]
    joint: {rigid: true}
    spring: {name: spring, law: displacement, force_max_N: 1500, stroke_mm: 100}
  other:
    <<: *ring
    # "Beside" it's at 10 mm.
    position_mm: [0, 10, 0]
    spring: {name: second, law: displacement, force_max_N: 1500, stroke_mm: 100}
# Of the supplier.
dispersions:
  satellite.mass_kg: 20
  satellite.cg_y_mm: 5  # measured
run: {duration_s: 2}
"""


@pytest.fixture(scope="module")
def text():
    return CaseText(TEXT)


@pytest.fixture(scope="module")
def separation():
    return Case.model_validate(read_yaml(TEXT)).in_si().separation


def line_of(words):
    [line] = [k for k, each in enumerate(TEXT.splitlines(), 1) if words in each]
    return line


@pytest.mark.parametrize(
    ("parameter", "line", "note", "stands"),
    [
        ("stage.mass", "mass_kg: 900", "Weighed.", True),
        ("stage.cg_x", "cg_mm: [-1000", "Weighed.", True),  # no blank line between
        ("stage.inertia_xx", "xx: 300", "of the drawing", True),
        ("satellite.mass", "mass_kg: 400", "the data sheet", True),
        ("satellite.mated_offset_x", "satellite:  #", "the data sheet", False),
        ("spring.force_max", "name: spring,", "", True),
        ("other.position_y", "[0, 10, 0]", '"Beside" it\'s at 10 mm.', True),
        ("before_separation.rate_x", None, None, None),
    ],
)
def test_of_parameters(text, separation, parameter, line, note, stands):
    found = text.of_parameter(parameter, separation)
    if line is None:
        assert found is None
    else:
        assert (found.line, found.note, found.stands) == (line_of(line), note, stands)


def test_of_what_is_merged_from_elsewhere(text, separation):
    """It stands in the section that it is merged into."""
    found = text.of_parameter("other.release_time", separation)
    assert (found.line, found.stands) == (line_of("other:"), False)


@pytest.mark.parametrize(
    ("name", "line", "note"),
    [
        ("satellite.mass_kg", "satellite.mass_kg: 20", "Of the supplier."),
        ("satellite.cg_y_mm", "satellite.cg_y_mm: 5", "measured"),
    ],
)
def test_of_tolerances(text, name, line, note):
    found = text.of_dispersion(name)
    assert (found.line, found.note) == (line_of(line), note)
    assert text.of_dispersion("stage.mass_kg") is None


def test_of_several_tolerances_together():
    text = CaseText("dispersions:\n  spring_*.force_max_N: 5  # all\n")
    found = text.of_dispersion("spring_3.force_max_N")
    assert (found.line, found.note) == (2, "all")


def test_of_the_whole_file(text):
    assert text.header == "The file as a whole."
    assert CaseText("a: [").of_dispersion("x") is None
