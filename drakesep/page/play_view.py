"""The tab Play: values changed by sliders, and the motion that comes of them."""

from drakesep.page import elements
from drakesep.page.workspace import Workspace


def build(workspace: Workspace) -> None:
    """Fill the tab."""
    elements.placeholder("Nothing here yet")
