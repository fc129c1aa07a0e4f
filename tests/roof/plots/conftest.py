"""What the tests of plots share."""

import pytest


@pytest.fixture(autouse=True)
def figures_stay_blank() -> None:
    """They are looked at here."""
