"""The pages know each other: what they link to is there, and the index has all."""

import re
from pathlib import Path

import pytest


ROOT = Path(__file__).parents[1]
PAGES = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "benchmarks/README.md")),
    *sorted((ROOT / "docs").glob("*.md")),
]
_CODE = re.compile(r"^```.*?^```|^ {4}.*?$", re.M | re.S)


def links(page: Path) -> list[str]:
    """What a page links to, other pages of the web left out."""
    text = _CODE.sub("", page.read_text(encoding="utf-8"))
    found = re.findall(r"\]\(([^)\s]+)\)", text)
    return [link for link in found if not link.startswith("http")]


def anchors(page: Path) -> set[str]:
    """The anchors that GitHub gives to the headings of a page."""
    text = re.sub(
        "^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.M | re.S
    )
    return {
        re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
        for heading in re.findall(r"^#+ (.*)$", text, re.M)
    }


@pytest.mark.parametrize("page", PAGES, ids=[str(p.relative_to(ROOT)) for p in PAGES])
def test_links_of_a_page_lead_somewhere(page):
    dead = []
    for link in links(page):
        file, _, anchor = link.partition("#")
        target = (page.parent / file).resolve() if file else page
        if not target.exists() or (anchor and anchor not in anchors(target)):
            dead.append(link)
    assert dead == []


def test_the_index_has_every_page():
    index = ROOT / "docs" / "README.md"
    pages = {page.name for page in (ROOT / "docs").glob("*.md")} - {"README.md"}
    assert {link for link in links(index) if "/" not in link} == pages


def test_every_benchmark_has_its_row():
    folder = ROOT / "benchmarks"
    rows = re.findall(
        r"^\| `(\w+\.py)", (folder / "README.md").read_text("utf-8"), re.M
    )
    assert sorted(rows) == sorted(path.name for path in folder.glob("*.py"))
