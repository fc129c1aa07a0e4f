"""A case as tables: what stands in cells, where errors stand, what edits come to."""

import dataclasses

import pytest

from drakesep.case_file.errors import CaseError
from drakesep.case_file.reader import builtin_cases, load_case, read_case
from drakesep.page import case_edit
from drakesep.page.yaml_edit import YamlText
from drakesep.systems.checks import InputError
from drakesep.systems.model.parameters import parameters
from drakesep.units import unit_of, with_unit


FOLDER = builtin_cases()["vega"].parent


@pytest.fixture(scope="module")
def text():
    return builtin_cases()["vega"].read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def vega():
    return load_case("vega")


def tables_of(text):
    """The tables of a text, with what is wrong with it, and the case if nothing is."""
    case, problems = None, ()
    try:
        case = read_case(text, folder=FOLDER)
    except CaseError as error:
        problems = tuple(str(error).splitlines())
    found = case_edit.tables(YamlText(text), case, problems)
    return {table.key: table for table in found}, problems


def row_of(table, name):
    [row] = [row for row in table.rows if row.name == name]
    return {c.title: cell for c, cell in zip(table.columns, row.cells, strict=True)}


def test_vega_as_tables(text):
    tables, _ = tables_of(text)
    bodies = tables["bodies"]
    units = {column.title: column.unit for column in bodies.columns}
    assert units["mass"] == "kg" and units["cg x"] == "mm"
    assert units["inertia xx"] == "kg m²"
    payload = row_of(bodies, "payload")
    assert payload["cg z"].text == "8" and payload["inertia yy"].text == "3136"
    attachment = row_of(tables["attachments"], "attachment_2")
    assert attachment["joint stiffness"].text == "1.0e+7"  # as it is written
    assert row_of(tables["springs"], "attachment_3")["force max"].text == "1485"
    mass = row_of(tables["dispersions"], "payload.mass_kg")
    told = [mass[key].text for key in ("tolerance", "nominal", "least", "most")]
    assert told == ["20", "1860", "1840", "1880"]
    assert len(tables["requirements"].rows) == 4


def test_every_built_in_case_has_tables_of_all_its_bodies_and_attachments():
    for name, file in builtin_cases().items():
        yaml = YamlText(file.read_text(encoding="utf-8"))
        tables = {table.key: table for table in case_edit.tables(yaml)}
        for section in ("bodies", "attachments"):
            rows = [row.name for row in tables[section].rows]
            assert rows == list(yaml.data[section]), name


WRONG = {
    "a mass": (("bodies", "payload", "mass_kg"), "-3", "must be > 0, got -3"),
    "a word": (
        ("attachments", "attachment_1", "spring", "stroke_mm"),
        "abc",
        "must be a number",
    ),
    "a tolerance": (("dispersions", "payload.mass_kg"), "-4", "must be finite and > 0"),
    "a tolerance that cannot be": (
        ("dispersions", "payload.inertia_xx_kg_m2"),
        "4000",
        "must be positive definite",
    ),
    "a quantity": (("requirements", 0, "quantity"), "rat", "unknown quantity"),
    "nothing": (
        ("attachments", "attachment_1", "spring", "force_max_N"),
        "",
        "missing",
    ),
}


@pytest.mark.parametrize(("path", "typed", "words"), WRONG.values(), ids=WRONG)
def test_an_error_stands_at_its_cell_alone(text, path, typed, words):
    tables, problems = tables_of(case_edit.changed(text, path, typed))
    assert len(problems) == 1 and words in problems[0]
    cells = [c for t in tables.values() for r in t.rows for c in r.cells if c.problem]
    assert [cell.path for cell in cells] == [path]
    assert cells[0].problem == problems[0]


ROWS = {
    "an inertia": (("bodies", "payload", "inertia_kg_m2", "xx"), "99999", "payload"),
    "a body": (("attachments", "attachment_2", "B"), "x", "attachment_2"),
    "limits": (("requirements", 1, "at_most"), "[1, 2]", "2"),
}


@pytest.mark.parametrize(("path", "typed", "name"), ROWS.values(), ids=ROWS)
def test_an_error_of_a_whole_entry_stands_at_its_row(text, path, typed, name):
    tables, problems = tables_of(case_edit.changed(text, path, typed))
    rows = [r for t in tables.values() for r in t.rows if r.problem]
    assert {row.name for row in rows} == {name}
    assert rows[0].problem == "\n".join(problems)


def test_a_parameter_is_changed_where_it_stands(text, vega):
    """Every parameter that has a place: read again, it alone has another value."""
    before = parameters(vega.separation)
    wanted = dict(before)
    for i, (name, value) in enumerate(before.items()):
        if not i % 4:
            unit = unit_of(name)
            new = unit.from_si(value) * 1.01 + 0.01
            try:
                text = case_edit.with_parameter(text, with_unit(name), new)
            except InputError as error:
                assert "stands nowhere in the case file" in str(error)
            else:
                wanted[name] = unit.to_si(new)
    after = parameters(read_case(text, folder=FOLDER).separation)
    assert after == pytest.approx(wanted, rel=1e-14)
    assert sum(after[name] != before[name] for name in after) > 12


def test_a_tolerance_and_a_requirement_are_added_and_removed(text):
    more = case_edit.with_tolerance(text, "launch_vehicle.mass_kg", "5 %")
    more = case_edit.with_requirement(
        more, quantity="rate_deg_s", when="at_end", at_least="", at_most="[1, 2, null]"
    )
    case = read_case(more, folder=FOLDER)
    [added] = [d for d in case.box.dispersions if d.name == "launch_vehicle.mass"]
    assert added.bounds == pytest.approx((712.5, 787.5), rel=1e-12)
    assert [len(case.limits), case.requirements[-1].when] == [10, "at_end"]
    for path in (("requirements", 4), ("dispersions", "launch_vehicle.mass_kg")):
        more = case_edit.without(more, path)
    assert more == text


def test_an_attachment_is_added_like_another_and_removed(text):
    like = case_edit.rows_of(text, "attachments")["attachment_2"]
    more = case_edit.with_another(text, like, " fifth ")
    placed = {a.name: a for a in read_case(more, folder=FOLDER).separation.attachments}
    second, fifth = placed["attachment_2"], placed["fifth"]
    spring = dataclasses.replace(second.spring, name="fifth_spring")
    assert fifth == dataclasses.replace(second, name="fifth", spring=spring)
    assert case_edit.without(more, ("attachments", "fifth")) == text
    for name, wrong in (("", "must be given"), ("attachment_1", "is there already")):
        with pytest.raises(InputError, match=wrong):
            case_edit.with_another(text, like, name)


def test_what_is_merged_is_removed_in_the_yaml():
    with pytest.raises(InputError, match="merged from elsewhere"):
        case_edit.without("a: &a {j: 1, k: 2}\nb: {<<: *a, l: 3}\n", ("b", "j"))


def test_what_has_no_tolerance_yet_may_have_one(vega):
    left = case_edit.parameters_left(vega)
    assert "launch_vehicle.mass_kg" in left and "payload.mass_kg" not in left
    assert len(left) == len(parameters(vega.separation)) - len(vega.box.names)


def test_a_component_cannot_be_nothing(text):
    with pytest.raises(InputError, match="must be a number"):
        case_edit.changed(text, ("bodies", "payload", "cg_mm", 1), " ")


def test_tables_of_what_is_no_case():
    assert [t.key for t in case_edit.tables(YamlText("just words"))] == [
        *("dispersions", "requirements")
    ]
    found = case_edit.tables(YamlText("bodies: [1]\nrequirements: 3\nrun: {a: }\n"))
    assert {t.key for t in found} == {"dispersions", "requirements", "settings"}
    odd = "bodies: {1: {mass_kg: {3: 4}}, null: {}, b: {mass_kg: {3: 4}}}"
    [bodies, *_] = case_edit.tables(YamlText(odd))
    assert [row.name for row in bodies.rows] == ["b"]  # the others are no names
