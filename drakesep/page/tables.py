"""Tables of a case as an element of the page, whose cells are fields."""

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict
from typing import Any

from nicegui.element import Element

from drakesep.page.case_edit import Table
from drakesep.page.yaml_edit import Path
from drakesep.systems.checks import InputError


_NARROWEST, _WIDEST = 5, 44
"""Fields, in digits."""


class Tables(  # type: ignore[call-arg]
    Element, component="tables.js", esm={"drakesep-page": "js"}
):
    """Tables whose cells can be changed, and whose rows can be added and removed."""

    def __init__(
        self,
        edit: Callable[[Path, str], None],
        add: Callable[[str], None],
        remove: Callable[[Path], None],
    ):
        """Show none yet.

        Args:
            edit: called with a path and what was typed; what it refuses stays in its
                cell, with what is wrong.
            add: called with the key of a table that is to have one more row.
            remove: called with the path of a row.
        """
        super().__init__()
        self._props["tables"] = []
        self._props["refused"] = None

        def edited(event: Any) -> None:
            path, text = tuple(event.args["path"]), str(event.args["text"])
            self._props["refused"] = None
            try:
                edit(path, text)
            except InputError as error:
                self._props["refused"] = {
                    "cell": json.dumps(list(path), separators=(",", ":")),
                    "text": text,
                    "problem": str(error),
                }
            self.update()

        self.on("edit", edited)
        self.on("add", lambda event: add(event.args["table"]))
        self.on("remove", lambda event: remove(tuple(event.args["path"])))

    def show(self, tables: Sequence[Table]) -> None:
        """Show tables in place of those that are shown."""
        self._props["tables"] = [_with_widths(table) for table in tables]
        self.update()


def _with_widths(table: Table) -> dict[str, Any]:
    told = asdict(table)
    for i, column in enumerate(told["columns"]):
        longest = max((len(row.cells[i].text) for row in table.rows), default=0)
        column["width"] = min(max(longest, _NARROWEST), _WIDEST) + 2
    return told
