"""The three answers in the page: asked for by the form, shown side by side."""

import json

import pandas as pd
import pytest
from served import opened
from small_case import small_case, write_case


pytestmark = pytest.mark.browser
SEARCH = 'section[aria-label="Search"]'
ROWS = """[...document.querySelectorAll('section[aria-label="Search"] .study-title')]
  .filter(e => e.textContent.includes('side by side'))
  .map(e => [...e.nextElementSibling.querySelectorAll('tr')]
    .map(r => [...r.children].map(c => c.textContent)))[0]"""


def test_found_statistical_and_proven(tmp_path):
    write_case(tmp_path, small_case(published=None, objectives=None), "small.yaml")
    with opened(tmp_path, "small.yaml") as page:
        page.click_text("Search")
        page.click_text("Requirements", SEARCH)
        page.click_text("Proven bounds, too", SEARCH)
        page.fill(f"{SEARCH} input[aria-label='launches drawn, too']", "2000")
        page.click_text("Start", SEARCH)
        rows = page.wait(ROWS, 300.0)
        page.click_text("Report", SEARCH)
        page.wait(f"document.querySelector('{SEARCH} .study-made a')?.href", 60.0)
        pages = json.dumps(page.value("document.body.innerText"))
        assert "What is proven, and what is not" in pages
    head, *told = rows
    shown = pd.DataFrame(told, columns=head)
    folder = tmp_path / "results" / "small" / "verify-1"
    written = pd.read_csv(folder / "answers.csv")
    assert len(shown) == len(written)
    for heading, column in (
        ("worst found", "worst_case_found"),
        ("statistical bound", "bound"),
        ("proven bound", "proven_bound"),
    ):
        expected = ["" if x != x else f"{x:.6g}" for x in written[column]]
        assert [*shown[heading]] == expected, heading
        assert written[column].notna().any()
