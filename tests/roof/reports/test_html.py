"""Reports of results folders: every number stands in the folders, and none beside."""

import json
import re
import shutil
import sys

import pytest
from browser import browser
from outcomes import SEARCH
from places import Folders, told_in, without_blanks, words_of_reports
from small_case import small_case, write_case

import drakesep
from drakesep.cli import app


SOURCE = 'guide, 4.2 <script>alert("no")</script> & more'


@pytest.fixture(autouse=True)
def figures_stay_blank():
    """They are drawn here, and the same to the last byte."""


def case_of_a_second():
    data = small_case(
        dispersions={"upper.mass_kg": 50.0}, objectives=None, published=None
    )
    speed = {**data["requirements"][0], "id": "R-1", "source": SOURCE}
    clearance = {"quantity": "clearance_mm", "at_least": 500.0}
    return data | {"requirements": [speed, clearance]}


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """A design with a failure case, and its clearances; flown by Drake alone."""
    home = tmp_path_factory.mktemp("study")
    data = case_of_a_second()
    case = write_case(home, data)
    words = ["verify", case, "-o", home / "verify", "--failures", "--report", "--quiet"]
    words += ["--prove"]
    with pytest.MonkeyPatch.context() as patch, pytest.raises(SystemExit):
        patch.setattr("sys.argv", ["drakesep", *map(str, [*words, *SEARCH])])
        app.main()
    drakesep.clearance(case, output=home / "clearance")
    return home / "verify", home / "clearance"


@pytest.fixture(scope="module")
def page(folders, tmp_path_factory):
    file = tmp_path_factory.mktemp("pages") / "page.html"
    assert drakesep.report(folders, output=file) == file
    return file


@pytest.fixture(scope="module")
def text(page):
    return page.read_text(encoding="utf-8")


def test_every_number_is_what_stands_in_its_place(text, folders):
    there = Folders({folder.name: folder for folder in folders})
    sourced = [told for told in told_in(text) if told.place]
    for told in sourced:
        there.check(told)
    assert len(sourced) > 200


def test_there_is_no_number_beside_them(text):
    own = words_of_reports()
    for told in told_in(text):
        beside = not told.place and not {"style", "title", "h1"} & {*told.tags}
        if beside and re.search(r"\d", told.text):
            assert without_blanks(told.text) in own, told


def test_what_a_case_says_is_text(text):
    assert SOURCE in [told.text for told in told_in(text)]


def test_nothing_is_fetched_and_nothing_runs(text):
    assert "<script" not in text
    assert not re.findall(r'(?:src|href)="(?!data:|#)[^"]*"', text)
    assert not re.findall(r"url\((?!#)|@import", text)


def test_the_same_folders_give_the_same_bytes(page, folders, tmp_path):
    again = drakesep.report(folders, output=tmp_path / "again.html")
    assert again.read_bytes() == page.read_bytes()
    assert page.stat().st_size < 5e6


def test_ids_are_unique_and_links_lead_to_them(text):
    ids = re.findall(r' id="([^"]*)"', text)
    assert len(ids) == len({*ids})
    assert {*re.findall(r'href="#([^"]*)"', text)} <= {*ids}


def test_pictures_have_words(text):
    assert all(
        re.search(r'alt="[^"]{20,}"', img) for img in re.findall("<img[^>]*>", text)
    )


def test_first_stands_what_is_asked_first(text, folders):
    """A clearance is beyond its limit: the verdict, which, where, and the commands."""
    plain = [told.text for told in told_in(text)]
    first = plain[plain.index("Is it met?") : plain.index("Compliance matrix")]
    assert first.index("not met") == 1
    assert "clearance" in first
    for folder in folders:
        record = drakesep.read_results(folder).record
        assert record.again in first


def test_verify_writes_its_report_at_once(folders, tmp_path):
    again = drakesep.report(folders[0], output=tmp_path / "again.html")
    at_once = folders[0].with_name("verify_report.html")
    assert again.read_bytes() == at_once.read_bytes()


def test_folders_of_different_cases_are_refused(folders, tmp_path):
    other = tmp_path / "other"
    shutil.copytree(folders[1], other)
    case = (other / "case.json").read_text(encoding="utf-8")
    (other / "case.json").write_text(case.replace("1200.0", "1201.0"), "utf-8")
    with pytest.raises(ValueError, match=r"other: must be of the case that .*verify"):
        drakesep.report([*folders, other])


def test_a_folder_twice_is_refused(folders):
    with pytest.raises(ValueError, match="folders: must "):
        drakesep.report([folders[1], folders[1]])


def test_two_campaigns_are_refused(folders, tmp_path):
    """`verify` may have flown one, too: which of them would be the answer?"""
    first, second = tmp_path / "first", tmp_path / "second"
    for folder in (first, second):
        shutil.copytree(folders[1], folder)
        study = json.loads((folder / "study.json").read_text(encoding="utf-8"))
        study["files"].append({"name": "campaign.csv", "what": "shares"})
        (folder / "study.json").write_text(json.dumps(study), encoding="utf-8")
    with pytest.raises(ValueError, match=r"must hold one campaign, got .*first"):
        drakesep.report([first, second])


def test_a_folder_without_results_is_refused(tmp_path):
    with pytest.raises(ValueError, match=r"must be a folder of results, got no study"):
        drakesep.report(tmp_path)


def test_page_stands_beside_its_folder_unless_it_is_said(folders, tmp_path):
    folder = tmp_path / "study"
    shutil.copytree(folders[1], folder)
    assert drakesep.report(folder) == tmp_path / "study_report.html"


@pytest.mark.slow
def test_pdf_is_the_same_to_the_last_byte(folders, tmp_path):
    try:
        import weasyprint  # noqa: F401
    except (ImportError, OSError) as error:
        pytest.skip(f"no PDF: {error}")
    first, again = (
        drakesep.report(folders[1], output=tmp_path / f"{k}.html", pdf=True)
        for k in ("first", "again")
    )
    pdf = first.with_suffix(".pdf").read_bytes()
    assert pdf.startswith(b"%PDF")
    assert again.with_suffix(".pdf").read_bytes() == pdf


def test_pdf_without_weasyprint_is_refused(folders, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "weasyprint", None)
    with pytest.raises(
        ValueError, match=r"pdf: needs WeasyPrint, which drakesep\[pdf\]"
    ):
        drakesep.report(folders[1], output=tmp_path / "page.html", pdf=True)


@pytest.mark.slow
def test_it_opens_without_network_and_is_never_wider_than_the_page(page):
    wide = "document.documentElement.scrollWidth > document.documentElement.clientWidth"
    with browser() as tab:
        tab.open(page)
        for width in (1280, 800, 360):
            tab.resize(width)
            assert tab.value(wide) is False
        assert tab.requests == tab.complaints == []
        assert tab.paper().startswith(b"%PDF")
