"""The tab Search."""

from drakesep.page import elements
from drakesep.page.workspace import Workspace


def build(workspace: Workspace) -> None:
    """Fill the tab."""
    elements.placeholder("Nothing here yet")
