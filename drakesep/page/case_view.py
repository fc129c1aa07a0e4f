"""The tab Case: tables that are edited, the YAML beside them, the stack in 3-D."""

from nicegui import ui

from drakesep.page import elements
from drakesep.page.workspace import Workspace


def build(workspace: Workspace) -> None:
    """Fill the tab."""
    text = ui.label().classes("page-yaml")
    elements.follow(workspace, lambda: text.set_text(workspace.text))
