"""Tables of results as HTML, calm and legible."""

import html
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import pandas as pd
from nicegui import ui


_RIGHT = ("met", "proven met")
_WRONG = ("not met", "failed", "not looked at", "contradicted")
"""Verdicts. What is not proven or covered is neither: the worst case decides."""


def show_frame(
    frame: pd.DataFrame,
    columns: Mapping[str, str],
    *,
    on_row: Callable[[Mapping[str, Any]], Any] | None = None,
    button: str = "",
) -> None:
    """Show some columns of a table.

    Args:
        frame: the table; columns that it has not are left out.
        columns: names, and how they are headed.
        on_row: called with a row whose button is pressed.
        button: what that says.
    """
    shown = {name: head for name, head in columns.items() if name in frame}
    numbers = {n for n in shown if pd.api.types.is_numeric_dtype(frame[n])}
    with ui.element("div").classes("frame"), ui.element("table"):
        with ui.element("thead"), ui.element("tr"):
            for name, head in shown.items():
                _cell("th", html.escape(head), number=name in numbers)
            if on_row is not None:
                _cell("th", "")
        with ui.element("tbody"):
            for each in frame.to_dict("records"):
                row = {str(name): value for name, value in each.items()}
                with ui.element("tr"):
                    for name in shown:
                        text = html.escape(_text(row[name]))
                        _cell("td", text, number=name in numbers, says=row[name])
                    if on_row is not None:
                        with ui.element("td"):
                            _button(button, on_row, row)


def _button(
    words: str, action: Callable[[Mapping[str, Any]], Any], row: Mapping[str, Any]
) -> None:
    ui.button(words, on_click=lambda: action(row)).props("flat dense no-caps size=12px")


def _cell(tag: str, content: str, *, number: bool = False, says: Any = "") -> None:
    classes = ["number"] if number else []
    classes += ["wrong"] if says in _WRONG else []
    classes += ["right"] if says in _RIGHT else []
    ui.html(content, sanitize=False, tag=tag).classes(" ".join(classes))


def _text(value: Any) -> str:
    if isinstance(value, float):
        if math.isinf(value):
            return "none"
        return "" if math.isnan(value) else f"{value:.6g}"
    return "" if value is None else str(value)


def facts(pairs: Sequence[tuple[str, str]]) -> None:
    """Show names with what they are."""
    with ui.element("dl").classes("facts"):
        for name, what in pairs:
            ui.html(html.escape(name), sanitize=False, tag="dt")
            ui.html(html.escape(what), sanitize=False, tag="dd")
