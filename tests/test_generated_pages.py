"""Tables of pages that are made of what the code says of itself are as it says."""

import generate
import pytest


@pytest.mark.parametrize("page", generate.TABLES)
def test_pages_are_as_they_are_generated(page):
    written = (generate.DOCS / page).read_text(encoding="utf-8")
    assert written == generate.filled(page), "`python docs/generate.py` writes it anew"
